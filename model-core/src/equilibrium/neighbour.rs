//! A finger beside another one: design, object and motion a little way from those of an equilibrium, at its coordinate.

use super::{Follower, Phase};
use crate::design::Design;
use crate::discretise::{Discretisation, discretise_in};
use crate::object::{Motion, Object};
use crate::real::Real;
use crate::size::Size;
use crate::state::State;
use crate::units::Units;

impl<T: Real, S: Size, O: Object<T>> Follower<T, S, O> {
    /// Takes a finger, an object and a motion beside those of another follower, in the same units; false if there is no such finger, or
    /// its model is of another size.
    pub(crate) fn stand_beside(
        &mut self,
        other: &Self,
        (design, how): (&Design, &Discretisation),
        object: O,
        motion: Motion,
    ) -> bool {
        self.phase = Phase::Lost;
        // That of the design: a factor of Young's modulus comes on top.
        let (force, _) = other.model.sudden;
        let units = Units { length: other.model.units.length.to_f64(), force: force.to_f64() };
        let fits = discretise_in(design, how, Some(units), &mut self.model).is_ok()
            && other.is_like(&self.model)
            && self.fit();
        if !fits {
            self.model.reset(0);
            return false;
        }
        (self.settings, self.modulus) = (other.settings, other.modulus);
        (self.object, self.motion) = (object, motion);
        self.youngs_modulus = T::of(design.material.youngs_modulus);
        self.model.sudden = (self.model.units.force, self.model.softness);
        self.model.stiffen(T::one(), self.modulus);
        // The places between the samples have the same indices on both.
        (self.model.fineness, self.model.every) = (other.model.fineness, other.model.every);
        (self.model.sharpest, self.model.bluntest) = (other.model.sharpest, other.model.bluntest);
        self.phase = Phase::Following;
        true
    }

    /// Goes to the other follower's accepted state and `part` of a velocity beyond it; the workspace shows it.
    pub(crate) fn go_beside(&mut self, other: &Self, velocity: &State<T, S>, part: T) {
        let at = other.timeline.at();
        self.timeline.stand(at);
        self.timeline.present.copy(&other.timeline.present, &self.model);
        self.timeline.present.go_on(velocity, part, &self.model);
        self.timeline.accept(at, &self.model);
        self.show_accepted();
    }
}
