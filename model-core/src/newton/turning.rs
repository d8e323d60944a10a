//! The turning of the contact force as the beam slides along the object: the contact curvature in the Newton step.
//!
//! A touching sample that moves by dP turns its normal by κ t (t·dP), with t the tangent and κ the curvature of the object's
//! level line: its force changes by −ν t with ν = μκ t·dP. Exactly that is one row t·dP − ν/(μκ) = 0 per contact. Neighbouring
//! samples of a beam that hardly stretches move alike along the object, so that one row, at the middle of the force, with the
//! sum of the multipliers, does for all. It spares a sixth of the iterations of a closing in steps of 1°; being a matter of the step only, it
//! leaves the solution as it is.

use super::gaps::Contacts;
use crate::access::Access;
use crate::contact::{ContactState, Direction, Row};
use crate::real::Real;
use crate::size::Size;

/// A stiffness μκ below which the turning does not matter, and its row would only spoil the scale of the others, N/mm.
const LEAST_STIFFNESS: f64 = 1e-3;

impl<T: Real, S: Size> Contacts<T, S> {
    /// Puts the row beside that of the sample at the middle of the contact force, if something touches and there is room for so many rows.
    pub fn add_turning(&mut self, capacity: usize) {
        let count = self.count;
        self.turning = None;
        let Some(rows) = self.rows.as_mut().get_mut(..count).filter(|_| count < capacity) else { return };
        let pushes = |row: &Row<T>| if row.only_pushes() { row.multiplier } else { T::ZERO };
        let total = rows.iter().fold(T::ZERO, |sum, row| sum + pushes(row));
        let mut below = T::ZERO;
        let middle = rows.iter().position(|row| {
            below += pushes(row);
            below + below >= total
        });
        let Some(middle) = middle.filter(|_| total > T::ZERO) else { return };
        let row = rows.at(middle);
        let stiffness = total * row.curvature;
        let tilted = rows.iter().fold(T::ZERO, |sum, row| sum + row.multiplier * row.tilt);
        if stiffness.abs() <= T::of(LEAST_STIFFNESS) {
            return;
        }
        let turning = Row {
            direction: Direction::Turning,
            state: ContactState::Closed,
            gap: tilted / stiffness,
            normal: [-row.normal[1], row.normal[0]],
            softness: -T::one() / stiffness,
            multiplier: T::ZERO,
            ..row
        };
        // Those above make room.
        let mut moved = turning;
        for slot in self.rows.as_mut().iter_mut().take(count + 1).skip(middle + 1) {
            core::mem::swap(slot, &mut moved);
        }
        self.count = count + 1;
        self.turning = Some((middle + 1) as u16);
    }

    /// Negative eigenvalues that the turning's row has by itself: one on a convex object, none in a bore, whose normals turn the other way.
    pub fn turning_negative(&self) -> isize {
        let row = self.turning.and_then(|index| self.rows.as_ref().get(usize::from(index)));
        isize::from(row.is_some_and(|row| row.softness < T::ZERO))
    }

    /// How far the touching samples slide along the object by the rows' steps Δμ, mm; positive turns the normals counter-clockwise for a
    /// convex object.
    pub fn slide(&self, delta: &[T]) -> T {
        let Some(index) = self.turning.map(usize::from) else { return T::ZERO };
        match (self.rows.as_ref().get(index), delta.get(index)) {
            // ν = μκ t·dP + Σ μ tilt, and the row's softness is −1/(μκ).
            (Some(row), Some(&delta)) => -delta * row.softness - row.gap,
            _ => T::ZERO,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::size::{Blank, Paper};
    use std::boxed::Box;

    /// Rows that touch with these multipliers, on a level line of this curvature.
    fn touching(multipliers: &[f64], curvature: f64) -> Box<Contacts<f64, Paper>> {
        let mut contacts: Box<Contacts<f64, Paper>> = Box::new(Contacts::EMPTY);
        for (j, &multiplier) in multipliers.iter().enumerate() {
            let (state, normal) = (ContactState::Closed, [-0.8, 0.6]);
            contacts.rows[j] =
                Row { sample: j as u16, state, normal, tilt: 1e-3, curvature, softness: 0.5, multiplier, ..Row::BLANK };
        }
        contacts.count = multipliers.len();
        contacts
    }

    #[test]
    fn one_row_at_the_middle_of_the_force_stands_for_all() {
        let mut contacts = touching(&[1.0, 1.0, 4.0, 1.0], 0.02);
        contacts.add_turning(5);
        assert_eq!((contacts.count, contacts.turning), (5, Some(3)));
        let stiffness = 7.0 * 0.02;
        let row = contacts.rows[3];
        assert!(!row.touches() && !row.only_pushes() && row.state == ContactState::Closed);
        assert_eq!((row.sample, row.multiplier, row.normal), (2, 0.0, [-0.6, -0.8]));
        assert!((row.gap - 7e-3 / stiffness).abs() < 1e-15 && (row.softness + 1.0 / stiffness).abs() < 1e-15);
        assert!(contacts.rows[4].sample == 3 && contacts.rows[4].touches(), "the row above has made room");
        // ν = μκ t·dP + Σ μ tilt.
        let slid = contacts.slide(&[0.0, 0.0, 0.0, stiffness * 0.25 + 7e-3, 0.0]);
        assert!((slid - 0.25).abs() < 1e-12, "{slid}");
    }

    #[test]
    fn its_own_sign_is_negative_outside_of_an_object_and_positive_in_a_bore() {
        for (curvature, expected) in [(0.02, 1), (-0.02, 0)] {
            let mut contacts = touching(&[2.0, 3.0], curvature);
            contacts.add_turning(5);
            assert_eq!((contacts.turning.is_some(), contacts.turning_negative()), (true, expected));
        }
    }

    #[test]
    fn there_is_none_without_room_force_or_curvature() {
        for (multipliers, curvature, capacity) in
            [([1.0, 1.0], 0.02, 2), ([0.0, 0.0], 0.02, 5), ([1.0, 1.0], 0.0, 5), ([1.0, 1.0], 1e-4, 5)]
        {
            let mut contacts = touching(&multipliers, curvature);
            contacts.add_turning(capacity);
            assert_eq!((contacts.count, contacts.turning, contacts.turning_negative()), (2, None, 0));
            assert_eq!(contacts.slide(&[1.0, 1.0]), 0.0);
        }
    }
}
