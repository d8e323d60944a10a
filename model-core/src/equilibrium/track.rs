//! One Newton iteration per tick: the cheapest way to follow a motion in small steps, its error known from the last residual.
//!
//! A tick extrapolates, evaluates once and takes one step. What is left after the step is of second order in the residual that
//! was found before it, so that residual says how far the result may be trusted; where it is too large, or anything else about
//! the step is out of the ordinary, the tick goes on with Newton's method to convergence.

use super::{Follower, Outcome, Phase, Target};
use crate::newton::Hessian;
use crate::newton::attempt::{FEW, MANY, NEAR_ENOUGH};
use crate::newton::increment::CLIP;
use crate::object::Object;
use crate::real::Real;
use crate::size::Size;
use crate::status::Status;

/// Residuals before the one step above which it is not trusted, in the finger's units ([`crate::units`]): those below for a finger of
/// 80 mm in a soft plastic. On a sharp outline a part of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tracking {
    /// Largest component of the energy's gradient, N·mm.
    pub gradient: f64,
    /// Largest closure error, gap error and penetration, mm.
    pub length: f64,
}

impl Tracking {
    /// Bounds within which the force stays within 10 mN of the converged one (test `tracking`).
    pub const DEFAULT: Self = Self { gradient: 1.0, length: 0.008 };
}

/// Gap within which a sample takes part in the one step, mm: the step would press it into the object unseen, and the force would be off where
/// it comes in (test `tracking`).
const NEAR: f64 = 0.002;
/// Longest step in contact, in largest steps: with time for the whole method, and without, where a longer one finds more rows than a tick has
/// time for.
const FARTHEST: f64 = 0.25;
const FARTHEST_SHORT: f64 = 0.4;
/// How far a first step into an object is meant to press, mm, and the least part of a step that it is cut to.
const PRESSED: f64 = 0.02;
const LEAST_PART: f64 = 1.0 / 16.0;
/// Radius of curvature of an outline on which the bounds hold as they are, mm: on a sharper one they are less in proportion, and where they
/// are coarse by its cube.
const ROUND: f64 = 10.0;
/// Steps after which the whole method decides.
const MOST: u32 = 4;
/// Where the budget ends, a step from residuals up to this many times the bounds is kept, untrusted: the next tick goes on from
/// there, and does not fall behind a motion that is too fast to be trusted.
const COARSE: f64 = 10.0;

impl<T: Real, S: Size, O: Object<T>> Follower<T, S, O> {
    /// Follows the equilibrium to a coordinate (rad or mm) by Newton steps without looking at what the last one has left: until
    /// the residuals *before* a step are within bounds, one step as a rule. The status is then `tracking`, and the outcome's
    /// residuals are those. Otherwise as [`Self::follow_within`], with what is left of the budget; where nothing is left the
    /// status is `max-iterations`.
    pub fn track(&mut self, to: impl Into<Target>, within: Tracking, budget: u32) -> Outcome {
        let to = to.into();
        if self.model.cells() == 0 || !to.is_valid() {
            return Outcome::at(Status::OutOfRange);
        }
        self.timeline.pass(T::of(to.time_step_s));
        let outcome = self.track_on(T::of(to.coordinate), within, budget);
        self.named(outcome)
    }

    /// The same in the time that has passed.
    fn track_on(&mut self, to: T, within: Tracking, budget: u32) -> Outcome {
        let remaining = to - self.timeline.at();
        let ready = self.phase == Phase::Following && budget > 0;
        let is_short = budget <= MOST;
        let is_open = is_short && self.timeline.accepted.touching_count == 0;
        let farthest = match (is_open, is_short) {
            (true, _) => 1.0,
            (_, true) => FARTHEST_SHORT,
            _ => FARTHEST,
        };
        let far = self.max_step() * T::of(farthest);
        // With time for the whole method only what it would not do better.
        let begins = if is_short {
            self.timeline.accepted.load == [T::ZERO; 2]
        } else {
            self.timeline.predicts() && remaining.abs() <= far
        };
        let smallest = self.max_step() * T::of(self.settings.min_step);
        if !ready
            || !begins
            || self.step <= smallest
            || self.settings.hessian != Hessian::Newton
            || self.work.history.is_kept()
        {
            return self.follow_on(to, budget, is_short);
        }
        let mut outcome = Outcome::at(Status::MaxIterations);
        if is_open && remaining.abs() > self.max_step() && self.is_clear_on_the_way(to) {
            // From one open hand to another nothing happens on the way.
            self.accept(to);
            return Outcome { status: self.standing(), steps: 1, ..outcome };
        }
        let mut size = self.step.min(far);
        let mut reaches = remaining.abs() <= size;
        if !reaches && !is_short {
            return self.follow_on(to, budget, false);
        }
        let towards = |size: T, at: T| at + if remaining > T::ZERO { size } else { -size };
        let mut target = if reaches { to } else { towards(size, self.timeline.at()) };
        self.timeline.take(target, to);
        self.timeline.predict(target, self.work.history.slip.rubs(), &self.model);
        let mut object = self.seen(target);
        let clearance = self.sweep.nearest;
        let mut shortens = is_open;
        // On a sharp outline the direction of the force turns as well: what is said of a step is less, but not how it goes on.
        let round = (self.model.sharpest.to_f64() / ROUND).min(1.0);
        let (near, mut moved) = (T::of(NEAR_ENOUGH), T::ZERO);
        let (mut trusted, mut bounded, mut spare);
        loop {
            let (residual, sweep) = self.work.evaluate(&self.model, &self.timeline.present, &object, T::of(NEAR));
            if outcome.iterations == 0 && self.model.fineness <= 1 {
                self.work.contacts.thin(MANY);
                if is_short {
                    self.work.contacts.cut(FEW);
                }
            }
            self.sweep = sweep;
            self.note(&residual, &mut outcome);
            let tolerance = T::TOLERANCE;
            let converged = residual.gradient <= tolerance.gradient && residual.length <= tolerance.length;
            if converged && is_open && sweep.nearest_free >= T::ZERO {
                self.drift = T::ZERO;
                self.keep(target);
                self.step = (size + size).min(self.max_step());
                let status = if reaches { self.standing() } else { Status::MaxIterations };
                return Outcome { status, steps: 1, ..outcome };
            }
            if converged && reaches {
                // As where the motor stands: the factorisation that judged the last step has judged this state.
                let drift = if outcome.iterations == 0 { self.drift + self.timeline.moved(&self.model) } else { moved };
                let forces = self.forces();
                let is_alike = self.factored.kkt.has_gaps_of(&self.model, &self.work.kinematics);
                if drift <= near && is_alike && !self.passes_a_fall(target, forces) {
                    self.drift = drift;
                    self.factored.is_near |= outcome.iterations > 0;
                    outcome.hops += u32::from(self.hops(target, forces));
                    self.accept(target);
                    return Outcome { status: self.standing(), steps: 1, ..outcome };
                }
            }
            let is_within = |times: f64| {
                let bound = |bound: f64| T::of(times * bound);
                residual.gradient <= bound(within.gradient) && residual.length <= bound(within.length)
            };
            if shortens && !is_within(COARSE) {
                // Far into the object: no further than it begins, as far as is known.
                shortens = false;
                let part = (clearance + T::of(PRESSED)) / (clearance + residual.length);
                let whole = if reaches { remaining.abs() } else { size };
                size = whole * part.max(T::of(LEAST_PART)).min(T::of(1.0 - LEAST_PART));
                (reaches, target) = (false, towards(size, self.timeline.at()));
                self.reject();
                self.timeline.take(target, to);
                object = self.seen(target);
                continue;
            }
            let Some(inertia) = self.work.solve_if_stable(&self.model, &mut self.factored) else {
                outcome.iterations += 1;
                return self.pursue(to, budget, outcome, size);
            };
            moved = self.work.increment.largest;
            self.work.apply(&self.model, &mut self.timeline.present, T::one());
            outcome.iterations += 1;
            let finite =
                self.timeline.present.lambda.as_ref().iter().fold(T::ZERO, |sum, l| sum + l[0] + l[1]).is_finite();
            // Without a stable factorisation, or with a step that wants clipping, the whole method decides.
            let odd = self.timeline.present.touching_count == 0 || self.presses_from_behind();
            if self.timeline.present.touching_count == 0 && finite && self.opens(to, is_within(COARSE)) {
                return Outcome { status: self.standing(), steps: 1, ..outcome };
            }
            if !inertia.is_stable() || !finite || moved > T::of(CLIP) || odd {
                return self.pursue(to, budget, outcome, size);
            }
            // What a step leaves grows with its square.
            spare = is_within(1.0 / 16.0);
            trusted = is_within(round) && !sweep.overflow && moved <= near;
            bounded = trusted || is_within(COARSE * round * round * round);
            if trusted {
                break;
            }
            if outcome.iterations >= budget.min(MOST) {
                if !is_short || !is_within(COARSE) {
                    return self.pursue(to, budget, outcome, size);
                }
                break;
            }
        }
        let forces = self.forces();
        if self.passes_a_fall(target, forces) {
            return self.pursue(to, budget, outcome, size);
        }
        self.work.contacts.settle(&self.timeline.present);
        (self.drift, self.factored.is_near) = (moved, true);
        outcome.hops += u32::from(self.hops(target, forces));
        self.accept(target);
        self.step = (if spare { T::of(4.0) * size } else { size + size }).min(self.max_step());
        let status = match self.standing() {
            // An object against the base has no status of this mode's own.
            Status::OutOfRange => Status::OutOfRange,
            _ if !reaches || moved > near + near || !bounded => Status::MaxIterations,
            _ if !trusted => Status::Updating,
            Status::Snapped => Status::Snapped,
            _ => Status::Tracking,
        };
        Outcome { status, steps: 1, ..outcome }
    }

    /// A step has let the object go. Where the open hand lies clear of it, that is the equilibrium, and accepted; `likely`, if that is to be
    /// expected.
    fn opens(&mut self, to: T, likely: bool) -> bool {
        let clear = if likely { self.is_clear(to) } else { self.is_clear_on_the_way(to) };
        if clear {
            self.rest();
            self.accept(to);
        }
        clear
    }

    /// Goes back to the accepted state, and on from there with what a step of this size has left of the budget.
    fn pursue(&mut self, to: T, budget: u32, so_far: Outcome, size: T) -> Outcome {
        self.reject();
        let left = budget.saturating_sub(so_far.iterations);
        if left == 0 {
            self.step = size * T::of(0.5);
            self.show_accepted();
            return so_far;
        }
        let outcome = self.follow_on(to, left, false);
        Outcome { iterations: so_far.iterations + outcome.iterations, ..outcome }
    }
}
