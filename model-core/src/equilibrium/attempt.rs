//! Newton's method at one coordinate of the motion.

use super::Follower;
use crate::newton::attempt::{Attempt, Judged, Limits};
use crate::object::Object;
use crate::real::{Real, Tolerance};
use crate::size::Size;

/// Part of the largest step up to which a step is short: few samples come in by it.
const SHORT: f64 = 0.25;

impl<T: Real, S: Size, O: Object<T>> Follower<T, S, O> {
    /// Newton's method at a coordinate from the present state, with at most so many iterations; judging the solution may take one more,
    /// within the budget.
    pub(super) fn newton(
        &mut self,
        coordinate: T,
        iterations: u32,
        budget: u32,
        tolerance: Tolerance<T>,
        is_short: bool,
    ) -> Attempt<T> {
        self.aim(coordinate);
        let object = self.seen(coordinate);
        let near = (coordinate - self.timeline.at()).abs() <= T::of(SHORT) * self.max_step();
        let limits = Limits {
            iterations: iterations.min(budget),
            budget,
            tolerance,
            hessian: self.settings.hessian,
            margin: T::of(self.settings.margin) / self.model.units.length,
            thins: near && self.model.fineness <= 1,
            is_short,
        };
        let (present, accepted) = self.timeline.present_and_accepted();
        let judged = Judged { state: accepted, drift: self.drift };
        let attempt = self.work.newton(&self.model, &mut self.factored, present, &object, judged, &limits);
        self.sweep = attempt.sweep;
        attempt
    }
}
