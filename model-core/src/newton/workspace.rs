//! The workspace: what each stage of a step finds, side by side.

use super::Effort;
use super::condensed::{Condensed, Own};
use crate::contact::{ContactState, Row};
use crate::element::{Node, Strain};
use crate::linear::banded::BAND;
use crate::model::Model;
use crate::real::Real;
use crate::size::{Blank, Size, Storage};

/// Kinematics and residual: the strained finger at the present state.
pub(crate) struct Shape<T: Real, S: Size> {
    pub nodes: S::Nodes<Node<T>>,
    pub members: S::Members<Strain<T>>,
    /// Position of each front span's start, mm.
    pub start: S::Cells<[T; 2]>,
    /// Σ μ n of the contacts on higher spans, N.
    pub above: S::Cells<[T; 2]>,
    /// Closure errors, mm.
    pub closure: S::Cells<[T; 2]>,
    /// The last evaluation found residuals only: second derivatives are those of an earlier state.
    pub lacks_tangent: bool,
}

/// Contact rows: touching samples and those near the object, in order along the beam.
pub(crate) struct Contacts<T: Real, S: Size> {
    pub rows: S::Contacts<Row<T>>,
    pub row_count: usize,
    /// The row among them that is not a gap but the turning of the contact force (see `turning`).
    pub turning: Option<u16>,
}

/// Condensed members and the banded KKT, factorised. It may be kept for the residuals of later states.
pub(crate) struct Factorisation<T: Real, S: Size> {
    /// It has the second derivatives of the force's part: it takes the nodes' coupling, not the model's.
    pub curved: bool,
    /// Condensed front spans: what the contact rows on the spans above pull at.
    pub fronts: S::Cells<Condensed<T>>,
    /// Lower band of the condensed KKT matrix, then its factors; the last entry of a row is the diagonal.
    pub band: S::Unknowns<[T; BAND + 1]>,
    /// Samples of the rows that it was made with; the place and the softness of the turning among them.
    pub kept: S::Contacts<u16>,
    pub kept_count: usize,
    pub kept_turning: Option<(u16, T)>,
    /// Its negative pivots, less those that the closures give.
    pub excess: isize,
}

/// The contact rows against joints, λ and each other.
pub(crate) struct Border<T: Real, S: Size> {
    /// Columns Q of the contact rows, then L⁻¹Q; one run of unknowns per row.
    pub columns: S::Rows<T>,
    /// Own-span entries of each row.
    pub own: S::Contacts<Own<T>>,
    /// D = −Z + Qᵀ KKT⁻¹ Q, mm/N, row by row; symmetric.
    pub flexibility: S::Pairs<T>,
    /// Right-hand side of the rows, mm.
    pub row_rhs: S::Contacts<T>,
    /// D⁻¹ L⁻¹ of one column.
    pub scaled: S::Unknowns<T>,
}

/// What the contact law makes of the border.
pub(crate) struct ContactSolution<T: Real, S: Size> {
    /// Factor of D on the active set.
    pub factored: S::Pairs<T>,
    pub order: S::Contacts<u16>,
    /// The active rows in the order in which they are factorised.
    pub listed: S::Contacts<u16>,
    /// How many of them have their factors: a settling with the same D needs no other.
    pub factorised: usize,
    /// States that the contact law has found.
    pub states: S::Contacts<ContactState>,
    /// The rows' step Δμ, N.
    pub row_delta: S::Contacts<T>,
    pub scratch: S::Contacts<T>,
    pub spare: S::Contacts<T>,
}

/// Room for one step. Nothing in it outlives a solve but the count of them.
pub struct Workspace<T: Real, S: Size> {
    pub(crate) effort: Effort,
    pub(crate) shape: Shape<T, S>,
    pub(crate) contacts: Contacts<T, S>,
    pub(crate) factorisation: Factorisation<T, S>,
    pub(crate) border: Border<T, S>,
    pub(crate) solution: ContactSolution<T, S>,
    /// Right-hand side, then the step in joint angles and λ.
    pub(crate) rhs: S::Unknowns<T>,
    /// Largest change of an angle that the step's increments ask for, rad.
    pub(crate) largest_turn: T,
}

impl<T: Real, S: Size> Workspace<T, S> {
    /// Room before anything was fitted.
    pub const EMPTY: Self = Self {
        effort: Effort::NONE,
        shape: Shape {
            nodes: <S::Nodes<Node<T>> as Storage<Node<T>>>::EMPTY,
            members: <S::Members<Strain<T>> as Storage<Strain<T>>>::EMPTY,
            start: <S::Cells<[T; 2]> as Storage<[T; 2]>>::EMPTY,
            above: <S::Cells<[T; 2]> as Storage<[T; 2]>>::EMPTY,
            closure: <S::Cells<[T; 2]> as Storage<[T; 2]>>::EMPTY,
            lacks_tangent: false,
        },
        contacts: Contacts { rows: <S::Contacts<Row<T>> as Storage<Row<T>>>::EMPTY, row_count: 0, turning: None },
        factorisation: Factorisation {
            curved: false,
            fronts: <S::Cells<Condensed<T>> as Storage<Condensed<T>>>::EMPTY,
            band: <S::Unknowns<[T; BAND + 1]> as Storage<[T; BAND + 1]>>::EMPTY,
            kept: <S::Contacts<u16> as Storage<u16>>::EMPTY,
            kept_count: 0,
            kept_turning: None,
            excess: 0,
        },
        border: Border {
            columns: <S::Rows<T> as Storage<T>>::EMPTY,
            own: <S::Contacts<Own<T>> as Storage<Own<T>>>::EMPTY,
            flexibility: <S::Pairs<T> as Storage<T>>::EMPTY,
            row_rhs: <S::Contacts<T> as Storage<T>>::EMPTY,
            scaled: <S::Unknowns<T> as Storage<T>>::EMPTY,
        },
        solution: ContactSolution {
            factored: <S::Pairs<T> as Storage<T>>::EMPTY,
            order: <S::Contacts<u16> as Storage<u16>>::EMPTY,
            listed: <S::Contacts<u16> as Storage<u16>>::EMPTY,
            factorised: 0,
            states: <S::Contacts<ContactState> as Storage<ContactState>>::EMPTY,
            row_delta: <S::Contacts<T> as Storage<T>>::EMPTY,
            scratch: <S::Contacts<T> as Storage<T>>::EMPTY,
            spare: <S::Contacts<T> as Storage<T>>::EMPTY,
        },
        rhs: <S::Unknowns<T> as Storage<T>>::EMPTY,
        largest_turn: T::ZERO,
    };

    /// Makes room for a model; false if there is none.
    pub(crate) fn fit(&mut self, model: &Model<T, S>) -> bool {
        let (nodes, members, cells) = (model.node_count, model.topology.member_count(), model.cells());
        let (unknowns, rows) = (model.unknowns(), S::CONTACTS);
        // What no element ends up writing must not be left from another model.
        self.shape.nodes.as_mut().fill(Node::BLANK);
        self.shape.nodes.fit(nodes)
            && self.shape.members.fit(members)
            && self.factorisation.fronts.fit(cells)
            && self.shape.start.fit(cells)
            && self.shape.above.fit(cells)
            && self.shape.closure.fit(cells)
            && self.factorisation.band.fit(unknowns)
            && self.rhs.fit(unknowns)
            && self.border.scaled.fit(unknowns)
            && self.contacts.rows.fit(rows)
            && self.factorisation.kept.fit(rows)
            && self.border.columns.fit(rows * unknowns)
            && self.border.own.fit(rows)
            && self.border.flexibility.fit(rows * rows)
            && self.solution.factored.fit(rows * rows)
            && self.solution.order.fit(rows)
            && self.solution.listed.fit(rows)
            && self.solution.states.fit(rows)
            && self.border.row_rhs.fit(rows)
            && self.solution.row_delta.fit(rows)
            && self.solution.scratch.fit(rows)
            && self.solution.spare.fit(rows)
    }

    /// Position of the front tip (deformed), finger frame, mm; needs the kinematics.
    pub(crate) fn tip(&self, model: &Model<T, S>) -> [T; 2] {
        let mut tip = model.base;
        for front in self.shape.members.as_ref().iter().take(model.cells()) {
            let d = front.end_to_end();
            tip = [tip[0] + d[0], tip[1] + d[1]];
        }
        tip
    }
}
