//! What a step factorises: a value that right-hand sides are solved on, in this step or a later one, in this tick or the next (35).

use super::border::{Border, Right};
use super::condense::Diagonal;
use super::evaluated::Evaluated;
use super::factorisation::Factorisation;
use super::residual::Residual;
use crate::model::Model;
use crate::real::Real;
use crate::size::Size;

/// The factorised KKT matrix and its border by the rows that it was made with.
///
/// The follower owns it and lends it to each attempt: one that begins near enough to the state that it was made at may use it at once.
pub(crate) struct Factored<T: Real, S: Size> {
    pub kkt: Factorisation<T, S>,
    pub border: Border<T, S>,
    /// It was made at the accepted state, or at one that no angle differs from by more than the follower's drift.
    pub is_near: bool,
}

impl<T: Real, S: Size> Factored<T, S> {
    pub const EMPTY: Self = Self { kkt: Factorisation::EMPTY, border: Border::EMPTY, is_near: false };

    /// Makes room for a model; false if there is none.
    pub fn fit(&mut self, model: &Model<T, S>) -> bool {
        self.is_near = false;
        self.kkt.fit(model) && self.border.fit(model)
    }

    /// Factorises at the evaluated state and borders by its rows, `room` for a solution on the interiors; returns the number of negative
    /// pivots.
    pub fn make(
        &mut self,
        at: Evaluated<'_, T, S>,
        residual: &Residual<T, S>,
        diagonal: Diagonal<T>,
        right: &mut Right<T, S>,
        room: &mut [T],
    ) -> usize {
        let negative = self.kkt.make(at, residual, diagonal, right.joints.as_mut());
        self.border.make(at, &self.kkt, right, room);
        negative
    }
}
