//! Moving the object while the finger's base stands still.

use super::passing::Barred;
use super::{FOLLOW_ITERATIONS, Follower, Outcome, Phase};
use crate::object::{Motion, Object};
use crate::real::{Real, Vec2, vec2};
use crate::size::Size;
use crate::status::Status;

/// Newton iterations allowed for the way back from where a budget ran out: on a way just come, one or two a step.
const BACK: u32 = 16;

impl<T: Real, S: Size, O: Object<T>> Follower<T, S, O> {
    /// Shifts the object by a vector (world frame, mm), following the equilibrium; `to` is the object where it then is.
    ///
    /// If the equilibrium cannot be followed there, object and finger are as before, unless the outcome's status is
    /// trustworthy.
    pub fn shift_object(&mut self, by: [f64; 2], to: impl Into<O>) -> Outcome {
        self.shift_object_within(by, to, FOLLOW_ITERATIONS)
    }

    /// The same with at most so many Newton iterations and accepted steps, and [`BACK`] more for the way back if they are
    /// too few.
    pub(crate) fn shift_object_within(&mut self, by: [f64; 2], to: impl Into<O>, budget: u32) -> Outcome {
        let length = libm::hypot(by[0], by[1]);
        let along = if length > 0.0 { by.map(|x| x / length) } else { [1.0, 0.0] };
        let along = self.displacement().vector(vec2::<T>(along));
        // An object that goes one way is a base that goes the other.
        self.carry(Motion::Translating { direction: [-along.x.to_f64(), -along.y.to_f64()] }, length, to.into(), budget)
    }

    /// Turns the object about a point (world frame, mm) by an angle (rad, counter-clockwise); otherwise as
    /// [`Self::shift_object`].
    pub fn turn_object(&mut self, about: [f64; 2], angle: f64, to: impl Into<O>) -> Outcome {
        self.turn_object_within(about, angle, to, FOLLOW_ITERATIONS)
    }

    /// The same, bounded as [`Self::shift_object_within`].
    pub(crate) fn turn_object_within(&mut self, about: [f64; 2], angle: f64, to: impl Into<O>, budget: u32) -> Outcome {
        let pivot = self.displacement().point(vec2::<T>(about));
        self.carry(Motion::Rotating { axis: [pivot.x.to_f64(), pivot.y.to_f64()] }, angle, to.into(), budget)
    }

    /// Follows the equilibrium while the object, as the finger sees it now, moves as it would if the base moved so far along
    /// a motion; then takes the object that stands there.
    fn carry(&mut self, path: Motion, far: f64, to: O, budget: u32) -> Outcome {
        if !self.has_equilibrium() || !far.is_finite() {
            return Outcome {
                status: Status::OutOfRange,
                iterations: 0,
                steps: 0,
                snaps: 0,
                gradient: 0.0,
                length: 0.0,
            };
        }
        let (object, motion, at, barred) = (self.object, self.motion, self.at, self.barred);
        self.barred = Barred::NONE;
        self.object = object.displaced(&motion.world_to_finger(at));
        self.motion = path;
        self.begin_path(T::ZERO);
        let outcome = self.follow_within(far, budget);
        let arrived = outcome.status.is_trustworthy();
        if let Phase::Folding { .. } = self.phase {
            self.show_accepted();
            self.phase = Phase::Following;
        }
        let back = arrived || self.follow_within(0.0, budget.max(BACK)).status.is_trustworthy();
        self.object = if arrived { to } else { object };
        self.motion = motion;
        if barred.way != 0 {
            self.barred = barred;
        }
        self.begin_path(at);
        if !back {
            self.phase = Phase::Lost;
        }
        outcome
    }

    /// The accepted equilibrium is the first of a new path.
    fn begin_path(&mut self, at: T) {
        self.at = at;
        self.before = at;
        self.extrapolates = false;
        self.step = self.max_step();
    }

    /// Force (N, world frame) on the object and its moment (N·mm, counter-clockwise) about a point (mm, world frame).
    pub fn wrench(&self, about: [T; 2]) -> [T; 3] {
        let pivot = self.displacement().point(Vec2::new(about[0], about[1]));
        let mut moment = T::ZERO;
        for contact in self.contacts() {
            let arm = [contact.position[0] - pivot.x, contact.position[1] - pivot.y];
            moment -= contact.force * (arm[0] * contact.normal[1] - arm[1] * contact.normal[0]);
        }
        let [x, y] = self.force_world();
        [x, y, moment]
    }
}
