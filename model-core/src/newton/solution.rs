//! What the contact law makes of the border: the rows' states and multipliers.

use super::border::{Border, Right};
use super::gaps::Contacts;
use super::slip::Slip;
use crate::contact::ContactState;
use crate::contact::coulomb::{self, Law};
use crate::contact::frictionless::{self, Problem, Settled};
use crate::real::Real;
use crate::size::{Size, Storage};

/// What the contact law makes of the border, and the room that it needs.
pub(crate) struct ContactSolution<T: Real, S: Size> {
    /// The rows' step Δμ, N.
    pub delta: S::Contacts<T>,
    /// States that the contact law has found.
    pub states: S::Contacts<ContactState>,
    /// Few sets of friction's states are tried.
    pub is_bounded: bool,
    /// Factor of D on the active set.
    pub factored: S::Pairs<T>,
    pub order: S::Contacts<u16>,
    /// The active rows in the order in which they are factorised.
    pub listed: S::Contacts<u16>,
    /// How many of them have their factors: a settling with the same D needs no other.
    factorised: usize,
    pub scratch: S::Contacts<T>,
    pub spare: S::Contacts<T>,
}

impl<T: Real, S: Size> ContactSolution<T, S> {
    pub const EMPTY: Self = Self {
        delta: <S::Contacts<T> as Storage<T>>::EMPTY,
        states: <S::Contacts<ContactState> as Storage<ContactState>>::EMPTY,
        is_bounded: false,
        factored: <S::Pairs<T> as Storage<T>>::EMPTY,
        order: <S::Contacts<u16> as Storage<u16>>::EMPTY,
        listed: <S::Contacts<u16> as Storage<u16>>::EMPTY,
        factorised: 0,
        scratch: <S::Contacts<T> as Storage<T>>::EMPTY,
        spare: <S::Contacts<T> as Storage<T>>::EMPTY,
    };

    /// Makes room; false if there is none.
    pub fn fit(&mut self) -> bool {
        self.delta.fit(S::CONTACTS)
            && self.states.fit(S::CONTACTS)
            && self.fit_rows(S::stride(0))
            && self.order.fit(S::CONTACTS)
            && self.listed.fit(S::CONTACTS)
            && self.scratch.fit(S::CONTACTS)
            && self.spare.fit(S::CONTACTS)
    }

    /// Makes room for a factor whose rows are so far apart; an array has it since it was fitted.
    pub fn fit_rows(&mut self, stride: usize) -> bool {
        self.factored.fit(stride * stride)
    }

    /// D is another one: no factor of it is known.
    pub fn forget(&mut self) {
        self.factorised = 0;
    }

    /// Settles the active set, from the rows that touch, and finds the rows' step (32), (33).
    pub fn settle(
        &mut self,
        border: &Border<T, S>,
        right: &Right<T, S>,
        contacts: &Contacts<T, S>,
        slip: &Slip<T, S>,
    ) -> Settled {
        let stride = border.stride();
        // A heap has the room.
        let _ = self.fit_rows(stride);
        let mut problem = Problem {
            flexibility: border.flexibility.as_ref(),
            stride,
            rhs: right.rows.as_ref(),
            rows: contacts.rows.as_ref(),
            tolerance: T::TOLERANCE.length * T::of(0.1),
            factored: self.factored.as_mut(),
            order: self.order.as_mut(),
            listed: self.listed.as_mut(),
            factorised: self.factorised,
            scratch: self.scratch.as_mut(),
            spare: self.spare.as_mut(),
        };
        let (states, delta) = (self.states.as_mut(), self.delta.as_mut());
        let settled = if slip.rubs() {
            coulomb::settle(
                &mut problem,
                Law { is_bounded: self.is_bounded, ..slip.law() },
                contacts.count,
                states,
                delta,
            )
        } else {
            frictionless::settle(&mut problem, contacts.count, states, delta)
        };
        self.factorised = settled.factorised;
        settled
    }

    /// A row of those settled still presses after the step.
    pub fn presses(&self, contacts: &Contacts<T, S>) -> bool {
        let found = self.delta.as_ref().iter().zip(self.states.as_ref());
        contacts.rows().iter().zip(found).any(|(row, (&delta, &state))| {
            row.only_pushes() && state == ContactState::Closed && row.multiplier + delta > T::ZERO
        })
    }
}
