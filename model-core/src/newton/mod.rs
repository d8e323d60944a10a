//! One Newton step for the ladder in contact, cost linear in elements and lamellae:
//! `kinematics` and `gaps` → `residual` → `condense` each member onto its joints and force → `assembly` of the banded KKT in joints and λ →
//! `border` by the contact rows → contact law (`contact::frictionless`) on the dense border → increments. What a member's elements do is
//! asked of [`crate::element`]; `lagged` are the steps that keep an earlier factorisation.
//!
//! Here mm, N and N·mm stand for the finger's own units of length, force and moment ([`crate::units`]).

pub(crate) mod assembly;
pub(crate) mod border;
pub(crate) mod condense;
pub(crate) mod condensed;
pub(crate) mod gaps;
pub(crate) mod kinematics;
pub(crate) mod lagged;
pub(crate) mod residual;
pub(crate) mod settings;
pub(crate) mod step;
#[cfg(test)]
mod tests;
pub(crate) mod turning;

use crate::contact::{ContactState, Row};
use crate::element::{Node, Strain};
use crate::ladder::Ladder;
use crate::linear::banded::BAND;
use crate::real::Real;
use crate::size::{Blank, Size, Storage};
use condensed::{Condensed, Own};

/// Which second derivative the step uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Hessian {
    /// The energy's plus the exact geometric stiffness of links and contacts.
    ///
    /// The default: the geometric stiffness stays within an element, so it costs next to nothing, and without it a compressed beam
    /// looks as stiff as a stretched one. In double precision the iterations after a step's first keep its factorisation as long as the
    /// residuals shrink fast: *measured* at 170/20, one servo count, as many iterations at a third of the cost each.
    #[default]
    Newton,
    /// The energy's alone (Gauss–Newton): blind to compression, so no stability test is possible.
    ///
    /// *Measured* on the target, one servo count in contact (`cargo xtask bench`, reduced model): without stretch and shear 23 to
    /// 26 iterations and a quarter of the ticks failed, where the default needs 1.1; with them 1.5 to 1.7 against 1.0 to 1.1, none
    /// failed.
    GaussNewton,
}

/// What was computed since the program began, counted; every count wraps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Evaluations of residuals and gaps.
    pub evaluations: u32,
    /// Linear systems solved: Newton iterations, factorisations that judge a solution, derivatives.
    pub solves: u32,
}

impl Effort {
    pub(crate) const NONE: Self = Self { evaluations: 0, solves: 0 };

    /// What was computed since an earlier count.
    pub fn since(self, earlier: Self) -> Self {
        Self {
            evaluations: self.evaluations.wrapping_sub(earlier.evaluations),
            solves: self.solves.wrapping_sub(earlier.solves),
        }
    }

    /// Both together.
    pub fn with(self, other: Self) -> Self {
        Self {
            evaluations: self.evaluations.wrapping_add(other.evaluations),
            solves: self.solves.wrapping_add(other.solves),
        }
    }

    pub(crate) fn evaluates(&mut self) {
        self.evaluations = self.evaluations.wrapping_add(1);
    }

    pub(crate) fn solves(&mut self) {
        self.solves = self.solves.wrapping_add(1);
    }
}

/// Room for one step. Nothing in it outlives a solve but the count of them.
pub struct Workspace<T: Real, S: Size> {
    pub(crate) effort: Effort,
    pub(crate) nodes: S::Nodes<Node<T>>,
    /// The factorisation has the second derivatives of the force's part: it takes the nodes' coupling, not the ladder's.
    pub(crate) curved: bool,
    pub(crate) members: S::Members<Strain<T>>,
    /// Condensed front spans: what the contact rows on the spans above pull at.
    pub(crate) fronts: S::Cells<Condensed<T>>,
    /// Largest change of an angle that the step's increments ask for, rad.
    pub(crate) largest_turn: T,
    /// Position of each front span's start, mm.
    pub(crate) start: S::Cells<[T; 2]>,
    /// Σ μ n of the contacts on higher spans, N.
    pub(crate) above: S::Cells<[T; 2]>,
    /// Closure errors, mm.
    pub(crate) closure: S::Cells<[T; 2]>,
    /// Lower band of the condensed KKT matrix, then its factors; the last entry of a row is the diagonal.
    pub(crate) band: S::Unknowns<[T; BAND + 1]>,
    /// Right-hand side, then the step in joint angles and λ.
    pub(crate) rhs: S::Unknowns<T>,
    /// D⁻¹ L⁻¹ of one column.
    pub(crate) scaled: S::Unknowns<T>,
    /// Contact rows: touching samples and those near the object, in order along the beam.
    pub(crate) rows: S::Contacts<Row<T>>,
    pub(crate) row_count: usize,
    /// The row among them that is not a gap but the turning of the contact force (see `turning`).
    pub(crate) turning: Option<u16>,
    /// Samples of the rows that the last factorisation was made with; the place and the softness of the turning among them.
    pub(crate) kept: S::Contacts<u16>,
    pub(crate) kept_count: usize,
    pub(crate) kept_turning: Option<(u16, T)>,
    /// Its negative pivots, less those that the closures give.
    pub(crate) excess: isize,
    /// The last evaluation found residuals only: second derivatives are those of an earlier state.
    pub(crate) lacks_tangent: bool,
    /// Columns Q of the contact rows, then L⁻¹Q; one run of unknowns per row.
    pub(crate) columns: S::Rows<T>,
    /// Own-span entries of each row.
    pub(crate) own: S::Contacts<Own<T>>,
    /// D = −Z + Qᵀ KKT⁻¹ Q, mm/N, row by row; symmetric.
    pub(crate) flexibility: S::Pairs<T>,
    /// Factor of D on the active set.
    pub(crate) factored: S::Pairs<T>,
    pub(crate) order: S::Contacts<u16>,
    /// The active rows in the order in which they are factorised.
    pub(crate) listed: S::Contacts<u16>,
    /// How many of them have their factors: a settling with the same D needs no other.
    pub(crate) factorised: usize,
    /// States that the contact law has found.
    pub(crate) states: S::Contacts<ContactState>,
    /// Right-hand side of the rows, then their step Δμ, N.
    pub(crate) row_rhs: S::Contacts<T>,
    pub(crate) row_delta: S::Contacts<T>,
    pub(crate) scratch: S::Contacts<T>,
    pub(crate) spare: S::Contacts<T>,
}

impl<T: Real, S: Size> Workspace<T, S> {
    /// Room before anything was fitted.
    pub const EMPTY: Self = Self {
        effort: Effort::NONE,
        nodes: <S::Nodes<Node<T>> as Storage<Node<T>>>::EMPTY,
        curved: false,
        members: <S::Members<Strain<T>> as Storage<Strain<T>>>::EMPTY,
        fronts: <S::Cells<Condensed<T>> as Storage<Condensed<T>>>::EMPTY,
        largest_turn: T::ZERO,
        start: <S::Cells<[T; 2]> as Storage<[T; 2]>>::EMPTY,
        above: <S::Cells<[T; 2]> as Storage<[T; 2]>>::EMPTY,
        closure: <S::Cells<[T; 2]> as Storage<[T; 2]>>::EMPTY,
        band: <S::Unknowns<[T; BAND + 1]> as Storage<[T; BAND + 1]>>::EMPTY,
        rhs: <S::Unknowns<T> as Storage<T>>::EMPTY,
        scaled: <S::Unknowns<T> as Storage<T>>::EMPTY,
        rows: <S::Contacts<Row<T>> as Storage<Row<T>>>::EMPTY,
        row_count: 0,
        turning: None,
        kept: <S::Contacts<u16> as Storage<u16>>::EMPTY,
        kept_count: 0,
        kept_turning: None,
        excess: 0,
        lacks_tangent: false,
        columns: <S::Rows<T> as Storage<T>>::EMPTY,
        own: <S::Contacts<Own<T>> as Storage<Own<T>>>::EMPTY,
        flexibility: <S::Pairs<T> as Storage<T>>::EMPTY,
        factored: <S::Pairs<T> as Storage<T>>::EMPTY,
        order: <S::Contacts<u16> as Storage<u16>>::EMPTY,
        listed: <S::Contacts<u16> as Storage<u16>>::EMPTY,
        factorised: 0,
        states: <S::Contacts<ContactState> as Storage<ContactState>>::EMPTY,
        row_rhs: <S::Contacts<T> as Storage<T>>::EMPTY,
        row_delta: <S::Contacts<T> as Storage<T>>::EMPTY,
        scratch: <S::Contacts<T> as Storage<T>>::EMPTY,
        spare: <S::Contacts<T> as Storage<T>>::EMPTY,
    };

    /// Makes room for a ladder; false if there is none.
    pub(crate) fn fit(&mut self, ladder: &Ladder<T, S>) -> bool {
        let (nodes, members, cells) = (ladder.node_count, ladder.topology.member_count(), ladder.cells());
        let (unknowns, rows) = (ladder.unknowns(), S::CONTACTS);
        // What no element ends up writing must not be left from another ladder.
        self.nodes.as_mut().fill(Node::BLANK);
        self.nodes.fit(nodes)
            && self.members.fit(members)
            && self.fronts.fit(cells)
            && self.start.fit(cells)
            && self.above.fit(cells)
            && self.closure.fit(cells)
            && self.band.fit(unknowns)
            && self.rhs.fit(unknowns)
            && self.scaled.fit(unknowns)
            && self.rows.fit(rows)
            && self.kept.fit(rows)
            && self.columns.fit(rows * unknowns)
            && self.own.fit(rows)
            && self.flexibility.fit(rows * rows)
            && self.factored.fit(rows * rows)
            && self.order.fit(rows)
            && self.listed.fit(rows)
            && self.states.fit(rows)
            && self.row_rhs.fit(rows)
            && self.row_delta.fit(rows)
            && self.scratch.fit(rows)
            && self.spare.fit(rows)
    }

    /// Position of the front tip (deformed), finger frame, mm; needs the kinematics.
    pub(crate) fn tip(&self, ladder: &Ladder<T, S>) -> [T; 2] {
        let mut tip = ladder.base;
        for front in self.members.as_ref().iter().take(ladder.cells()) {
            let d = front.end_to_end();
            tip = [tip[0] + d[0], tip[1] + d[1]];
        }
        tip
    }
}
