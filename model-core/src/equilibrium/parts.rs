//! What other modules see of a follower: its solution, its settings, and the parts that a derivative needs.

use super::{Follower, Phase};
use crate::model::Model;
use crate::newton::factored::Factored;
use crate::newton::{Effort, Workspace};
use crate::object::{Displacement, Object};
use crate::real::Real;
use crate::size::Size;
use crate::solution::Solution;
use crate::state::State;
use crate::units::Units;

/// The follower's parts that a derivative needs.
pub(crate) struct Parts<'a, T: Real, S: Size> {
    pub(crate) model: &'a Model<T, S>,
    pub(crate) work: &'a mut Workspace<T, S>,
    pub(crate) factored: &'a mut Factored<T, S>,
}

impl<T: Real, S: Size, O: Object<T>> Follower<T, S, O> {
    /// The equilibrium accepted last.
    pub fn solution(&self) -> Solution<'_, T, S> {
        Solution {
            model: &self.model,
            state: &self.timeline.present,
            kinematics: &self.work.kinematics,
            rows: &self.work.contacts,
            slip: &self.work.history.slip,
            motion: self.motion,
            coordinate: self.timeline.at(),
            nearest: self.sweep.nearest,
        }
    }

    /// What was computed so far: the cost of a call is the difference before and after it.
    pub fn effort(&self) -> Effort {
        self.work.effort
    }

    /// Number of angles of the model.
    pub fn unknowns(&self) -> usize {
        self.model.angles()
    }

    /// Arc lengths of all contact samples, touching or not, mm, base to tip.
    pub fn sample_arcs(&self) -> impl Iterator<Item = T> + '_ {
        self.model.samples.as_ref()[..self.model.sample_count].iter().map(|sample| sample.arc * self.model.units.length)
    }

    /// Contact softness ε_c in use, mm/N: a touching place is pressed into the object by ε_c times its force.
    pub fn softness(&self) -> T {
        let Units { length, force } = self.model.units;
        self.model.contact_softness() * length / force
    }

    /// Coefficient of friction.
    pub fn friction(&self) -> T {
        self.work.history.slip.coefficient
    }

    /// There is friction.
    #[inline(always)]
    pub(crate) fn rubs(&self) -> bool {
        self.work.history.slip.is_given()
    }

    /// From the world frame into the finger's, at the accepted coordinate.
    pub(crate) fn displacement(&self) -> Displacement<T> {
        self.motion.world_to_finger(self.timeline.at())
    }

    pub(crate) fn has_equilibrium(&self) -> bool {
        self.model.cells() > 0 && self.phase == Phase::Following
    }

    /// The last factorisation is that of the accepted state, or nearly.
    pub(crate) fn is_factored(&self) -> bool {
        self.factored.is_near
    }

    pub(crate) fn has_snapped(&self) -> bool {
        self.snapped
    }

    pub(crate) fn youngs_modulus(&self) -> T {
        self.modulus * self.youngs_modulus
    }

    pub(crate) fn parts(&mut self) -> Parts<'_, T, S> {
        Parts { model: &self.model, work: &mut self.work, factored: &mut self.factored }
    }

    /// The accepted state, which the workspace shows, beside the parts.
    pub(crate) fn state_and_parts(&mut self) -> (&State<T, S>, Parts<'_, T, S>) {
        (&self.timeline.present, Parts { model: &self.model, work: &mut self.work, factored: &mut self.factored })
    }

    /// Another model has the same unknowns and samples.
    pub(crate) fn is_like(&self, other: &Model<T, S>) -> bool {
        self.model.cells() == other.cells()
            && self.model.unknowns() == other.unknowns()
            && self.model.node_count == other.node_count
            && self.model.sample_count == other.sample_count
    }
}
