//! One Newton iteration per tick: the cheapest way to follow a motion in small steps, its error known from the last residual.
//!
//! A tick extrapolates, evaluates once and takes one step. What is left after the step is of second order in the residual that
//! was found before it, so that residual says how far the result may be trusted; where it is too large, or anything else about
//! the step is out of the ordinary, the tick goes on with Newton's method to convergence.

use super::{Follower, Outcome, Phase};
use crate::newton::gaps;
use crate::newton::{Hessian, step};
use crate::object::Object;
use crate::real::Real;
use crate::size::Size;
use crate::status::Status;

/// Residuals before the one step above which it is not trusted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tracking {
    /// Largest component of the energy's gradient, N·mm.
    pub gradient: f64,
    /// Largest closure error, gap error and penetration, mm.
    pub length: f64,
}

impl Tracking {
    /// Bounds within which the force stays within 10 mN of the converged one (*measured*, test `tracking`).
    pub const DEFAULT: Self = Self { gradient: 1.0, length: 0.008 };
}

/// Gap within which a sample takes part in the one step, mm: one that the step would press into the object unseen. *Measured*:
/// without, 18 mN off where a sample comes in (test `tracking`); with it, 1.3 mN.
const NEAR: f64 = 0.002;

impl<T: Real, S: Size, O: Object<T>> Follower<T, S, O> {
    /// Follows the equilibrium to a coordinate (rad or mm) with one Newton iteration if that is enough: the status is then
    /// `tracking`, and the outcome's residuals are those found before the iteration. Otherwise as [`Self::follow_within`].
    pub fn track(&mut self, to: f64, within: Tracking, budget: u32) -> Outcome {
        let target = T::of(to);
        let near = (target - self.at).abs() <= self.max_step() * T::of(0.25);
        let ready = self.ladder.cells > 0 && to.is_finite() && self.phase == Phase::Following;
        if !ready || !near || !self.extrapolates || self.settings.hessian != Hessian::Newton || budget == 0 {
            return self.follow_within(to, budget);
        }
        self.extrapolate(target);
        let object = self.object.displaced(&self.motion.world_to_finger(target));
        let (residual, sweep) = step::evaluate(&self.ladder, &self.state, &mut self.work, &object, T::of(NEAR));
        gaps::thin(&mut self.work, super::MANY);
        let (gradient, length) = (residual.gradient.to_f64(), residual.length.to_f64());
        let small = gradient <= within.gradient && length <= within.length && !sweep.overflow;
        // Without a stable factorisation, or with a step that wants clipping, the whole method decides.
        let inertia = step::solve(&self.ladder, &mut self.work, Hessian::Newton, T::ZERO);
        let moved = step::apply(&self.ladder, &mut self.state, &self.work, T::one());
        let finite = self.state.lambda.as_ref().iter().fold(T::ZERO, |sum, l| sum + l[0] + l[1]).is_finite();
        if !inertia.is_stable() || !finite || moved > T::of(step::CLIP) || self.state.touching_count == 0 {
            self.state.copy_from(&self.accepted, &self.ladder);
            return self.follow_within(to, budget);
        }
        if !small {
            let attempt = self.newton(target, self.settings.max_iterations.min(budget) - 1, T::TOLERANCE);
            if attempt.status != Status::Converged || attempt.inertia.is_some_and(|i| !i.is_stable()) {
                self.state.copy_from(&self.accepted, &self.ladder);
                return self.follow_within(to, budget);
            }
            self.accept(target);
            return Outcome {
                status: self.standing(),
                iterations: 1 + attempt.iterations,
                steps: 1,
                snaps: 0,
                gradient: attempt.residual.gradient.to_f64(),
                length: attempt.residual.length.to_f64(),
            };
        }
        step::settle_rows(&self.state, &mut self.work);
        self.sweep = sweep;
        self.accept(target);
        let status = if self.snapped { Status::Snapped } else { Status::Tracking };
        Outcome { status, iterations: 1, steps: 1, snaps: 0, gradient, length }
    }
}
