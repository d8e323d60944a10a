//! The workspace: the stages of a step, side by side, but for what it factorises ([`super::factored`]).

use super::Effort;
use super::border::Right;
use super::gaps::Contacts;
use super::history::History;
use super::increment::Increment;
use super::kinematics::Kinematics;
use super::residual::Residual;
use super::solution::ContactSolution;
use crate::model::Model;
use crate::real::Real;
use crate::size::Size;

/// Room for one step: each stage is made from those before it.
pub struct Workspace<T: Real, S: Size> {
    pub(crate) effort: Effort,
    pub(crate) kinematics: Kinematics<T, S>,
    pub(crate) contacts: Contacts<T, S>,
    pub(crate) residual: Residual<T, S>,
    pub(crate) right: Right<T, S>,
    pub(crate) solution: ContactSolution<T, S>,
    pub(crate) increment: Increment<T, S>,
    /// What outlives a step.
    pub(crate) history: History<T, S>,
}

impl<T: Real, S: Size> Workspace<T, S> {
    /// Room before anything was fitted.
    pub const EMPTY: Self = Self {
        effort: Effort::NONE,
        kinematics: Kinematics::EMPTY,
        contacts: Contacts::EMPTY,
        residual: Residual::EMPTY,
        right: Right::EMPTY,
        solution: ContactSolution::EMPTY,
        increment: Increment::EMPTY,
        history: History::EMPTY,
    };

    /// Makes room for a model; false if there is none.
    pub(crate) fn fit(&mut self, model: &Model<T, S>) -> bool {
        self.kinematics.fit(model)
            && self.contacts.fit()
            && self.residual.fit(model)
            && self.right.fit(model)
            && self.solution.fit()
            && self.increment.fit(model)
            && self.history.fit(model)
    }
}
