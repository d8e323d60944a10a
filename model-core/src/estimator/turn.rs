//! A turn of the motion that passes while the follower is behind.
//!
//! The force depends on the way: on a snap that lies on it, and on what friction remembers of it. Where the motor turns round before the
//! follower has come there, the follower goes to the place of the turn first. A further turn meanwhile is not kept: with friction the way
//! is unknown then.

use super::{Estimator, SHORT_WAY};
use crate::equilibrium::Outcome;
use crate::real::Real;
use crate::size::Size;
use crate::status::Status;

impl<T: Real, S: Size> Estimator<T, S> {
    /// The motion begins at an angle, rad, or goes on from there with the object: no turn is left behind.
    pub(super) fn set_off(&mut self, at: f64) {
        (self.asked, self.due) = (at, None);
    }

    /// Takes the angle to follow in this tick, rad, and its coordinate; where the follower is to go: there, or to the turn that it has not
    /// reached yet.
    pub(super) fn by_way_of_turn(&mut self, to: f64, coordinate: f64) -> f64 {
        let (heads, asked) = (self.due.unwrap_or(self.asked), core::mem::replace(&mut self.asked, to));
        let was_due = self.due.take().is_some();
        // Where the branch ends, or contacts find no room, more iterations lead nowhere.
        let is_behind = matches!(self.last.status, Status::MaxIterations | Status::Updating);
        if !is_behind || !self.follower.has_equilibrium() || self.follower.approaches() {
            return coordinate;
        }
        let Some([goal, _]) = self.drive.coordinate(heads) else { return coordinate };
        let missing = T::of(goal).to_f64() - self.follower.solution().coordinate();
        // What friction remembers of a short way is little.
        let is_short =
            self.follower.rubs() && !self.follower.is_folding() && missing.abs() <= SHORT_WAY * self.ratio.abs();
        if is_short || (coordinate - goal) * missing >= 0.0 {
            return coordinate;
        }
        self.due = Some(heads);
        if was_due && self.follower.rubs() && (to - asked) * (asked - heads) < 0.0 {
            self.forget_path();
        }
        goal
    }

    /// Goes on to a coordinate from a turn, once the follower has reached that or has found no way to it, with what is left of so many iterations.
    pub(super) fn leave_turn(&mut self, reached: Outcome, coordinate: f64, budget: u32) -> Outcome {
        if matches!(reached.status, Status::MaxIterations | Status::Updating) {
            return reached;
        }
        let Some(turn) = self.due.take() else { return reached };
        if self.follower.rubs() && reached.status.is_trustworthy() {
            self.turn_at(turn);
        }
        let left = budget.saturating_sub(reached.iterations);
        if left == 0 {
            return Outcome { status: Status::MaxIterations, ..reached };
        }
        let Outcome { iterations, snaps, hops, .. } = reached;
        let gone = self.run(coordinate, left);
        Outcome { iterations: iterations + gone.iterations, snaps: snaps + gone.snaps, hops: hops + gone.hops, ..gone }
    }
}
