//! What happens where a branch ends: the overdamped motion just past the fold, to wherever it comes to rest.

use super::hop::change;
use super::{Follower, Outcome, Phase};
use crate::newton::Hessian;
use crate::object::Object;
use crate::real::Real;
use crate::size::Size;

/// Iterations of the fold handler before it gives up.
const FOLD_ITERATIONS: u32 = 300;
/// Steps past the end of a branch at which the fold handler looks for another: this part of the largest step, then four
/// times as far, up to the largest step.
pub(super) const FOLD_STEP: f64 = 0.0625;
/// Gap within which samples take part in its steps, which are large, mm.
const FOLD_MARGIN: f64 = 0.3;
/// Shift it begins with, relative to the stiffness at rest.
pub(super) const FOLD_SHIFT: f64 = 0.01;
/// Residuals below which the fold handler tries Newton's method alone, N·mm and mm.
const POLISH_GRADIENT: f64 = 5.0;
const POLISH_LENGTH: f64 = 0.02;
/// Largest change of an angle in one of its steps, and the one below which its motion is slow, rad.
const FASTEST: f64 = 0.1;
const SLOW: f64 = 0.02;
/// A solution past the end of a branch that differs by less than this angle is the same branch, rad.
const SAME_BRANCH: f64 = 0.03;
/// And whose force differs by less than this part: small snap-throughs move little and may still take a quarter of the force.
const SAME_FORCE: f64 = 0.1;

impl<T: Real, S: Size, O: Object<T>> Follower<T, S, O> {
    /// Part of the fold handler: the overdamped motion from the end of the branch to wherever it comes to rest.
    ///
    /// Each step is Newton's with the stiffness at rest added to the Hessian, `shift` times (Levenberg–Marquardt): an
    /// implicit step in time of a finger in a viscous bath, 1/`shift` long, which goes downhill in energy as long as the
    /// shifted problem is stable. The time step follows the motion: short while it is fast, long while it is slow.
    pub(super) fn fold(&mut self, target: T, shift: T, spent: u32, budget: u32, outcome: &mut Outcome) {
        self.aim(target);
        let object = self.seen(target);
        let margin = T::of(FOLD_MARGIN);
        let tolerance = T::TOLERANCE;
        let (mut shift, mut spent) = (shift, spent);
        let (mut used, mut polishes, mut slow) = (0, 6, false);
        loop {
            if used >= budget {
                self.phase = Phase::Folding { target, shift, spent };
                return;
            }
            let (residual, sweep) = self.work.evaluate(&self.model, &self.timeline.present, &object, margin);
            self.sweep = sweep;
            self.note(&residual, outcome);
            let settled = residual.gradient <= tolerance.gradient && residual.length <= tolerance.length;
            if spent >= FOLD_ITERATIONS || residual.gradient >= T::of(1e12) {
                self.give_up(target);
                return;
            }
            used += 1;
            spent += 1;
            outcome.iterations += 1;
            if settled {
                let inertia = self.work.solve(&self.model, &mut self.factored, Hessian::Newton, T::ZERO);
                if inertia.is_stable() {
                    if self.timeline.moved(&self.model) > T::of(SAME_BRANCH)
                        || change(self.timeline.present.force(), self.timeline.accepted.force()) > T::of(SAME_FORCE)
                    {
                        self.snapped = true;
                        outcome.snaps += 1;
                    }
                    let passed = self.presses_from_behind();
                    self.phase = Phase::Following;
                    (self.drift, self.factored.is_near) = (T::ZERO, true);
                    self.begin_fall(target);
                    self.accept(target);
                    if passed {
                        self.phase = Phase::Lost;
                    }
                    outcome.steps += 1;
                    self.step = self.max_step() * T::of(0.125);
                    return;
                }
                // A saddle: leave it along the shifted direction.
                shift = shift.max(T::of(1e-3));
                self.nudge();
                continue;
            }
            // Where the motion has slowed down, Newton's method may end it.
            let near = residual.gradient < T::of(POLISH_GRADIENT) && residual.length < T::of(POLISH_LENGTH);
            if near && slow && polishes > 0 && shift < T::of(0.1) {
                polishes -= 1;
                slow = false;
                let attempt = self.newton(target, 12, budget.saturating_sub(used), tolerance, false);
                used += attempt.iterations;
                spent += attempt.iterations;
                outcome.iterations += attempt.iterations;
                continue;
            }
            let inertia = self.work.solve(&self.model, &mut self.factored, Hessian::Newton, shift);
            if !inertia.is_stable() {
                shift = (shift * T::of(4.0)).max(T::of(1e-4));
                if shift > T::of(1e6) {
                    spent = FOLD_ITERATIONS;
                }
                continue;
            }
            let turn = self.work.increment.largest;
            self.work.apply(&self.model, &mut self.timeline.present, (T::of(FASTEST) / turn).min(T::one()));
            slow = turn < T::of(SLOW);
            if turn > T::of(FASTEST) {
                shift *= T::of(2.0);
            } else if slow {
                shift = if shift < T::of(1e-6) { T::ZERO } else { shift * T::of(0.5) };
            }
        }
    }

    /// Goes back to the end of the branch, to try further beyond it or to leave it at that.
    fn give_up(&mut self, target: T) {
        self.reject();
        let further = (target - self.timeline.at()) * T::of(4.0);
        self.phase = if further.abs() <= self.max_step() {
            Phase::Folding { target: self.timeline.at() + further, shift: T::of(FOLD_SHIFT), spent: 0 }
        } else {
            self.step = self.max_step();
            Phase::Ended { forward: further > T::ZERO }
        };
    }

    /// A small deterministic disturbance of the interior angles, to leave a saddle.
    fn nudge(&mut self) {
        for (node, angle) in self.timeline.present.angle.as_mut().iter_mut().enumerate().take(self.model.node_count) {
            let sign = if node % 3 == 0 { T::of(1e-3) } else { T::of(-5e-4) };
            *angle += sign;
        }
        self.timeline.present.share_joints(&self.model);
    }
}
