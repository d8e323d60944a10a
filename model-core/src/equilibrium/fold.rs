//! What happens where a branch ends: a minimisation of the energy just past the fold.

use super::{Follower, Outcome, Phase};
use crate::ladder::PER_CELL;
use crate::newton::{Hessian, gaps, residual, step};
use crate::object::{Circle, Object};
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
/// A solution past the end of a branch that differs by less than this angle is the same branch, rad.
const SAME_BRANCH: f64 = 0.03;

impl<T: Real, S: Size> Follower<T, S> {
    /// Energy with penalties for open closures and penetration: the merit of the fold handler's line search.
    fn merit(&mut self, object: &Circle<T>, penalty: T) -> T {
        let energy = residual::potential(&self.ladder, &self.state, &mut self.work);
        let mut open = T::ZERO;
        for closure in &self.work.closure.as_ref()[..self.ladder.cells] {
            open += closure[0].abs() + closure[1].abs();
        }
        let penetration = gaps::penetration(&self.ladder, &self.work, object, penalty);
        energy + penalty * open + penetration
    }

    /// Part of the fold handler: shifted Hessian (Levenberg–Marquardt) with a line search on an ℓ1 merit.
    pub(super) fn fold(&mut self, target: T, shift: T, spent: u32, budget: u32, outcome: &mut Outcome) {
        let object = self.object.displaced(&self.motion.world_to_finger(target));
        let margin = T::of(FOLD_MARGIN);
        let tolerance = T::TOLERANCE;
        let (mut shift, mut spent) = (shift, spent);
        let (mut used, mut polishes) = (0, 6);
        loop {
            let (residual, sweep) = step::evaluate(&self.ladder, &self.state, &mut self.work, &object, margin);
            self.sweep = sweep;
            outcome.gradient = residual.gradient.to_f64();
            outcome.length = residual.length.to_f64();
            let settled = residual.gradient <= tolerance.gradient && residual.length <= tolerance.length;
            if spent >= FOLD_ITERATIONS || !residual.gradient.is_finite() {
                self.state.copy_from(&self.accepted, &self.ladder);
                let further = (target - self.at) * T::of(4.0);
                self.phase = if further.abs() <= self.max_step() {
                    Phase::Folding { target: self.at + further, shift: T::of(FOLD_SHIFT), spent: 0 }
                } else {
                    self.step = self.max_step();
                    Phase::Ended { forward: further > T::ZERO }
                };
                return;
            }
            if used >= budget {
                self.phase = Phase::Folding { target, shift, spent };
                return;
            }
            used += 1;
            spent += 1;
            outcome.iterations += 1;
            // The merit is blind near a solution (its closures curve): Newton's method decides there.
            let near = residual.gradient < T::of(POLISH_GRADIENT) && residual.length < T::of(POLISH_LENGTH);
            if near && !settled && shift < T::of(0.1) && polishes > 0 {
                polishes -= 1;
                let attempt = self.newton(target, budget.saturating_sub(used).min(12));
                used += attempt.iterations;
                spent += attempt.iterations;
                outcome.iterations += attempt.iterations;
                continue;
            }
            if settled {
                let inertia = step::solve(&self.ladder, &mut self.work, Hessian::Newton, T::ZERO);
                if inertia.is_stable() {
                    let moved = self.largest_move();
                    self.snapped |= moved > T::of(SAME_BRANCH);
                    self.accept(target);
                    outcome.steps += 1;
                    self.step = self.max_step() * T::of(0.125);
                    self.phase = Phase::Following;
                    return;
                }
                // A saddle: leave it along the shifted direction.
                shift = shift.max(T::of(1e-3));
                self.nudge();
                continue;
            }
            let inertia = step::solve(&self.ladder, &mut self.work, Hessian::Newton, shift);
            if !inertia.is_stable() {
                shift = (shift * T::of(4.0)).max(T::of(1e-4));
                if shift > T::of(1e6) {
                    spent = FOLD_ITERATIONS;
                }
                continue;
            }
            let mut penalty = T::one();
            for lambda in &self.state.lambda.as_ref()[..self.ladder.cells] {
                penalty = penalty.max(T::of(2.0) * (lambda[0].abs() + lambda[1].abs()));
            }
            for cell in 0..self.ladder.cells {
                for i in 0..2 {
                    let next = self.state.lambda.as_ref()[cell][i] + self.work.rhs.as_ref()[PER_CELL * cell + i];
                    penalty = penalty.max(T::of(2.0) * next.abs());
                }
            }
            let before = self.merit(&object, penalty);
            let mut part = step::clip(&self.ladder, &self.work);
            let mut better = false;
            for _ in 0..8 {
                step::advance_geometry(&self.ladder, &mut self.state, &self.work, part);
                let after = self.merit(&object, penalty);
                if after < before {
                    better = true;
                    break;
                }
                step::advance_geometry(&self.ladder, &mut self.state, &self.work, -part);
                part *= T::of(0.5);
            }
            if better {
                step::advance_multipliers(&mut self.state, &self.work, part);
                shift = if shift < T::of(1e-6) { T::ZERO } else { shift * T::of(0.25) };
            } else {
                let size = (residual.gradient / tolerance.gradient).max(residual.length / tolerance.length);
                if size < T::of(1e4) {
                    // Near a solution the merit is flat at this precision: a full step decides.
                    step::apply(&self.ladder, &mut self.state, &self.work, T::one());
                }
                shift = (shift * T::of(8.0)).max(T::of(1e-3));
            }
        }
    }

    /// Largest difference of an angle between the present and the accepted state, rad.
    fn largest_move(&self) -> T {
        let n = self.ladder.node_count;
        let (now, then) = (&self.state.angle.as_ref()[..n], &self.accepted.angle.as_ref()[..n]);
        now.iter().zip(then).fold(T::ZERO, |most, (&a, &b)| most.max((a - b).abs()))
    }

    /// A small deterministic disturbance of the interior angles, to leave a saddle.
    fn nudge(&mut self) {
        for (node, angle) in self.state.angle.as_mut()[..self.ladder.node_count].iter_mut().enumerate() {
            let sign = if node % 3 == 0 { T::of(1e-3) } else { T::of(-5e-4) };
            *angle += sign;
        }
        step::share_joints(&self.ladder, &mut self.state);
    }
}
