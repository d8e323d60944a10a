//! Moving the object while the finger's base keeps its place.

use super::passing::Barred;
use super::{FOLLOW_ITERATIONS, Follower, Outcome, Phase};
use crate::newton::Workspace;
use crate::newton::slip::Rubbed;
use crate::object::{Motion, Object};
use crate::real::{Real, vec2};
use crate::size::Size;
use crate::status::Status;

/// What [`Follower::go_back`] needs besides the state that the follower keeps.
pub(crate) struct Mark<T, O> {
    /// There is an equilibrium to go back to.
    is_good: bool,
    object: O,
    motion: Motion,
    at: T,
    snapped: bool,
    drift: T,
    barred: Barred<T>,
    rubbed: Rubbed<T>,
}

impl<T: Real, S: Size, O: Object<T>> Follower<T, S, O> {
    /// Shifts the object by a vector (world frame, mm), following the equilibrium with at most [`FOLLOW_ITERATIONS`] Newton
    /// iterations; `to` is the object where it then is.
    ///
    /// A finger that remembers ([`Follower::set_prony`]) cannot go back, so that it refuses: `out-of-range`.
    ///
    /// If the equilibrium cannot be followed there, object and finger are as before, unless the outcome's status is
    /// trustworthy.
    pub fn shift_object(&mut self, by: [f64; 2], to: impl Into<O>) -> Outcome {
        let mark = self.mark();
        let outcome = self.shift_marked(by, to, FOLLOW_ITERATIONS);
        self.settled(&mark, outcome)
    }

    /// Turns the object about a point (world frame, mm) by an angle (rad, counter-clockwise); otherwise as
    /// [`Self::shift_object`].
    pub fn turn_object(&mut self, about: [f64; 2], angle: f64, to: impl Into<O>) -> Outcome {
        let mark = self.mark();
        let outcome = self.turn_marked(about, angle, to, FOLLOW_ITERATIONS);
        self.settled(&mark, outcome)
    }

    fn settled(&mut self, mark: &Mark<T, O>, outcome: Outcome) -> Outcome {
        if !outcome.status.is_trustworthy() {
            self.go_back(mark);
        }
        self.unmark();
        outcome
    }

    /// Remembers the accepted equilibrium, to which [`Self::go_back`] returns without an iteration, until [`Self::unmark`].
    pub(crate) fn mark(&mut self) -> Mark<T, O> {
        self.timeline.mark(&self.model);
        Mark {
            is_good: self.has_equilibrium(),
            object: self.object,
            motion: self.motion,
            at: self.timeline.at(),
            snapped: self.snapped,
            drift: self.drift,
            barred: self.barred,
            rubbed: self.work.history.slip.mark(),
        }
    }

    /// Object and finger are as they were at the mark, which stays. One evaluation.
    #[inline(never)]
    pub(crate) fn go_back(&mut self, mark: &Mark<T, O>) {
        if !self.timeline.is_marked() || !mark.is_good || self.remembers() {
            return;
        }
        self.timeline.go_back(&self.model);
        (self.object, self.motion, self.snapped, self.barred) = (mark.object, mark.motion, mark.snapped, mark.barred);
        self.drift = mark.drift;
        self.phase = Phase::Following;
        self.begin_path(mark.at);
        self.show_accepted();
        let Workspace { kinematics, history, .. } = &mut self.work;
        history.slip.go_back(&mark.rubbed, &self.model, &self.timeline.present, kinematics);
    }

    pub(crate) fn unmark(&mut self) {
        self.timeline.unmark();
        self.begin_fall(self.timeline.at());
    }

    /// Shifts the object of a marked follower with at most so many Newton iterations and accepted steps. What it leaves behind
    /// when the outcome is not trustworthy is good for [`Self::go_back`] only.
    pub(crate) fn shift_marked(&mut self, by: [f64; 2], to: impl Into<O>, budget: u32) -> Outcome {
        let length = libm::hypot(by[0], by[1]);
        let along = if length > 0.0 { by.map(|x| x / length) } else { [1.0, 0.0] };
        let along = self.displacement().vector(vec2::<T>(along));
        // An object that goes one way is a base that goes the other.
        self.carry(Motion::Translating { direction: [-along.x.to_f64(), -along.y.to_f64()] }, length, to.into(), budget)
    }

    /// Turns the object of a marked follower, as [`Self::shift_marked`].
    pub(crate) fn turn_marked(&mut self, about: [f64; 2], angle: f64, to: impl Into<O>, budget: u32) -> Outcome {
        let pivot = self.displacement().point(vec2::<T>(about));
        self.carry(Motion::Rotating { axis: [pivot.x.to_f64(), pivot.y.to_f64()] }, angle, to.into(), budget)
    }

    /// Follows the equilibrium while the object, as the finger sees it now, moves as it would if the base moved so far along
    /// a motion; then takes the object that is there.
    #[inline(never)]
    fn carry(&mut self, path: Motion, far: f64, to: O, budget: u32) -> Outcome {
        // What a material remembers has no room for a second past to go back to.
        if !self.has_equilibrium() || !far.is_finite() || self.remembers() {
            return Outcome::at(Status::OutOfRange);
        }
        let (motion, at, barred) = (self.motion, self.timeline.at(), self.barred);
        self.barred = Barred::NONE;
        self.object = self.object.displaced(&motion.world_to_finger(at));
        self.motion = path;
        self.begin_path(T::ZERO);
        let outcome = self.follow_within(far, budget);
        if outcome.status.is_trustworthy() {
            (self.object, self.motion) = (to, motion);
            if barred.way != 0 {
                self.barred = barred;
            }
            self.begin_path(at);
        }
        outcome
    }

    /// The accepted equilibrium is the first of a new path.
    fn begin_path(&mut self, at: T) {
        self.timeline.stand(at);
        self.allow_steps();
    }
}
