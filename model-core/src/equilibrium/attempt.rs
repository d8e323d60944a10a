//! Newton's method at one coordinate, and what it says of the state that it ends at.

use super::Follower;
use crate::newton::gaps;
use crate::newton::residual::Residual;
use crate::newton::settings::NewtonSettings;
use crate::newton::step::{self, Inertia};
use crate::newton::{Hessian, lagged};
use crate::object::Object;
use crate::real::{Real, Tolerance};
use crate::size::Size;
use crate::status::Status;

/// New rows of a short step's first iteration beyond which they are thinned.
pub(super) const MANY: usize = 7;

/// Largest difference of an angle, rad, at which one state's inertia is taken for another's (see the module).
pub const NEAR_ENOUGH: f64 = 2e-3;
/// Change of an angle, in units of the precision's [`Real::EPSILON`], below which a Newton step is rounding.
const ROUNDING: f64 = 1e3;

/// Result of Newton's method at one coordinate.
pub(super) struct Attempt<T> {
    pub(super) status: Status,
    pub(super) iterations: u32,
    /// What the last factorisation says, and how far the state has moved from the one that it was made at.
    pub(super) inertia: Option<Inertia>,
    pub(super) drift: T,
    /// Some iterate was unstable with contacts that had settled.
    pub(super) unstable: bool,
    /// Largest change of an angle in the smallest step, rad.
    pub(super) least_turn: T,
    pub(super) residual: Residual<T>,
}

impl<T: Real> Attempt<T> {
    /// Why it failed.
    pub(super) fn cause(&self) -> Status {
        if self.unstable {
            Status::Folded
        } else if self.inertia.is_some_and(|inertia| !inertia.settled) {
            Status::Unsettled
        } else if self.least_turn <= T::of(ROUNDING) * T::EPSILON
            || self.status == Status::Converged && self.inertia.is_some_and(|inertia| !inertia.is_stable())
        {
            // Steps that are rounding, or an inertia that no matrix has.
            Status::Precision
        } else {
            Status::Stagnated
        }
    }
}

impl<T: Real, S: Size, O: Object<T>> Follower<T, S, O> {
    /// Newton's method at a coordinate from the present state, with at most so many iterations; judging the solution may take one more,
    /// within the budget.
    pub(super) fn newton(
        &mut self,
        coordinate: T,
        max_iterations: u32,
        budget: u32,
        tolerance: Tolerance<T>,
    ) -> Attempt<T> {
        let max_iterations = max_iterations.min(budget);
        let settings = NewtonSettings::<T>::of_precision();
        let object = self.seen(coordinate);
        let margin = T::of(self.settings.margin) / self.model.units.length;
        let mut attempt = Attempt {
            status: Status::MaxIterations,
            iterations: 0,
            inertia: None,
            drift: T::ZERO,
            unstable: false,
            least_turn: T::of(1e30),
            residual: Residual { gradient: T::of(1e30), length: T::of(1e30) },
        };
        let small = (coordinate - self.timeline.at()).abs() <= T::of(0.25) * self.max_step();
        let (mut best, mut last) = (T::of(1e30), T::of(1e30));
        let mut stalled = 0;
        let mut may_keep = false;
        loop {
            let (residual, sweep) = if may_keep {
                step::residuals(&self.model, &self.timeline.present, &mut self.work, &object, margin)
            } else {
                step::evaluate(&self.model, &self.timeline.present, &mut self.work, &object, margin)
            };
            if attempt.iterations == 0 && small && self.model.fineness <= 1 {
                gaps::thin(&mut self.work, MANY);
            }
            attempt.residual = residual;
            self.sweep = sweep;
            let near = T::of(NEAR_ENOUGH);
            let newton = self.settings.hessian == Hessian::Newton;
            let converged = residual.gradient <= tolerance.gradient && residual.length <= tolerance.length;
            if converged && attempt.iterations == 0 {
                attempt.drift = self.drift + self.largest_move();
            }
            if converged {
                let stable = attempt.inertia.is_none_or(|inertia| inertia.is_stable());
                let judges = newton && (!stable || attempt.drift > near);
                if judges && attempt.iterations >= budget {
                    return attempt;
                }
                attempt.status = Status::Converged;
                if judges {
                    // The last factorisation was made at another state: judge the solution itself.
                    if self.work.shape.lacks_tangent {
                        step::evaluate(&self.model, &self.timeline.present, &mut self.work, &object, margin);
                    }
                    let inertia = step::solve(&self.model, &mut self.work, Hessian::Newton, T::ZERO);
                    (attempt.inertia, attempt.drift) = (Some(inertia), T::ZERO);
                    attempt.iterations += 1;
                    attempt.unstable |= inertia.is_unstable();
                }
                return attempt;
            }
            if attempt.iterations >= max_iterations {
                if sweep.overflow {
                    attempt.status = Status::ContactCapacity;
                }
                return attempt;
            }
            // Growth beyond all bounds, NaN included, or no progress at the precision's floor.
            let size = (residual.gradient / tolerance.gradient).max(residual.length / tolerance.length);
            if residual.gradient >= T::of(1e12) {
                return attempt;
            }
            if size < best * T::of(0.7) {
                (best, stalled) = (size, 0);
            } else {
                stalled += 1;
                if stalled > 6 && size < T::of(100.0) {
                    attempt.status = if sweep.overflow { Status::ContactCapacity } else { Status::Stagnated };
                    return attempt;
                }
            }
            // What the stiffness is kept for would have to be judged at the end.
            let keeps = may_keep && size <= last * settings.chord && attempt.drift <= near;
            last = size;
            let inertia = if keeps && lagged::align(&self.model, &mut self.work) {
                lagged::solve(&self.model, &mut self.work)
            } else {
                if may_keep {
                    step::evaluate(&self.model, &self.timeline.present, &mut self.work, &object, margin);
                }
                attempt.drift = T::ZERO;
                step::solve(&self.model, &mut self.work, self.settings.hessian, T::ZERO)
            };
            attempt.inertia = Some(inertia);
            attempt.unstable |= inertia.is_unstable();
            attempt.iterations += 1;
            let part = step::clip(&self.work);
            attempt.drift += part * self.work.largest_turn;
            attempt.least_turn = attempt.least_turn.min(self.work.largest_turn);
            step::apply(&self.model, &mut self.timeline.present, &self.work, part);
            may_keep = settings.keeps_factors() && part == T::one() && self.settings.hessian == Hessian::Newton;
        }
    }
}
