//! One step of the coordinate: extrapolate, solve, accept or halve.

use super::fold::{FOLD_SHIFT, FOLD_STEP};
use super::hop::Fall;
use super::phase::Phase;
use super::timeline::Search;
use super::{Follower, LONGEST_PAUSE, Outcome};
use crate::newton::Hessian;
use crate::newton::attempt::NEAR_ENOUGH;
use crate::newton::settings::NewtonSettings;
use crate::object::Object;
use crate::real::Real;
use crate::size::Size;
use crate::status::Status;

/// Newton iterations after which a step is halved rather than pursued: iterates that wander may end on another branch (how many do:
/// `cargo xtask bench branches`).
const PATIENCE: u32 = 5;
/// The same on the way to the coordinate asked for, where the tolerance is looser.
const PATIENCE_ON_THE_WAY: u32 = 4;
/// Residuals, in tolerances of single precision, that a step may leave if its tick has no time for another iteration.
const EASED: f64 = 20.0;
/// Longest time at one coordinate that is taken for the end of a branch where it fails, s.
const SHORTEST_PAUSE: f64 = 1e-4;
/// Part of the largest step below which they may take all that the settings allow: a step this short does not stray.
const PATIENT_BELOW: f64 = 1.0 / 16.0;
/// Part of the normal forces by which what a step brings into contact may pull, and part of the largest step below which it is taken as it is
/// ([`Settings::resolves_contact`](super::Settings::resolves_contact)).
const DOUBTFUL: f64 = 0.01;
const SURE_BELOW: f64 = 1.0 / 16.0;

impl<T: Real, S: Size, O: Object<T>> Follower<T, S, O> {
    /// One step towards `to`; the status if the call ends with it. A call that `is_short` of time is content with less.
    pub(super) fn advance(&mut self, to: T, budget: u32, is_short: bool, outcome: &mut Outcome) -> Option<Status> {
        let remaining = to - self.timeline.at();
        let untouched = self.timeline.accepted.touching_count == 0 && self.timeline.accepted.load == [T::ZERO; 2];
        let is_strained = self.work.history.memory.is_strained();
        if untouched && !is_strained && remaining.abs() > self.max_step() && self.is_clear_on_the_way(to) {
            // From one open hand to another nothing happens on the way.
            self.timeline.take(to, to);
            self.accept(to);
            outcome.steps += 1;
            return Some(self.standing());
        }
        let size = self.step.min(self.max_step());
        let reaches = remaining.abs() <= size;
        let target = if reaches {
            to
        } else if remaining > T::ZERO {
            self.timeline.at() + size
        } else {
            self.timeline.at() - size
        };
        if untouched
            && !is_strained
            && self.work.history.slip.rubs()
            && remaining != T::ZERO
            && let Some(met) = self.meets(target)
        {
            self.timeline.take(met, to);
            self.wait_open(met);
            return None;
        }
        // A step costs at least an evaluation, also where it needs no iteration.
        let left = budget.saturating_sub(outcome.iterations + outcome.steps);
        if left == 0 && outcome.steps > 0 {
            return Some(Status::MaxIterations);
        }
        self.timeline.take(target, to);
        if remaining == T::ZERO && self.remembers() {
            self.timeline.take_at_most(self.pause);
        }
        let seconds = self.timeline.taken();
        let search = Search::Step { forward: target > self.timeline.at() };
        let spent = self.timeline.take_up(search, &self.model);
        if spent == 0 {
            self.timeline.predict(target, self.work.history.slip.rubs(), &self.model);
        }
        let settings = NewtonSettings::<T>::of_precision();
        let tolerance = match (reaches, is_short) {
            (true, false) => settings.tolerance,
            (false, false) => settings.on_the_way,
            (_, true) => settings.on_the_way.times(T::of(EASED)),
        };
        let patience = self.patience((target - self.timeline.at()).abs(), reaches);
        let allowed = patience.saturating_sub(spent).max(1);
        let attempt = self.newton(target, allowed, left, tolerance, is_short);
        outcome.iterations += attempt.iterations;
        self.note(&attempt.residual, outcome);
        let stable = self.settings.hessian == Hessian::GaussNewton || attempt.inertia.is_none_or(|i| i.is_stable());
        // Its residuals are small, but nothing is left to judge it with.
        let unjudged = is_short && attempt.status == Status::MaxIterations && attempt.residual.is_within(&tolerance);
        let converged = (attempt.status == Status::Converged || unjudged) && stable;
        let passed = converged && self.presses_from_behind();
        let forces = self.forces();
        let is_good = converged && !passed && !self.passes_a_fall(target, forces);
        self.crowded = attempt.status == Status::ContactCapacity || self.crowded && !(is_good && reaches);
        if is_good && self.lands_early(target) {
            self.reject();
            self.timeline.stop_predicting();
            self.step = size.min(remaining.abs()) * T::of(0.5);
            return None;
        }
        if is_good {
            self.drift = attempt.drift;
            self.factored.is_near |= attempt.iterations > 0;
            if untouched && attempt.iterations == 0 {
                // The open hand as it was, and evaluated as it is.
                self.keep(target);
            } else {
                outcome.hops += u32::from(self.hops(target, forces));
                self.accept(target);
            }
            outcome.steps += 1;
            self.step = (size + size).min(self.max_step());
            self.pause = (self.pause + self.pause).min(T::of(LONGEST_PAUSE));
            let reaches = reaches && !(remaining == T::ZERO && self.remembers() && self.timeline.elapsed() > T::ZERO);
            let status = match self.standing() {
                Status::Converged | Status::Snapped if unjudged && attempt.drift > T::of(2.0 * NEAR_ENOUGH) => {
                    Status::MaxIterations
                }
                Status::Converged | Status::Snapped if unjudged => Status::Updating,
                Status::Converged if !attempt.residual.is_within(&settings.tolerance) => Status::Tracking,
                other => other,
            };
            return (reaches && self.phase == Phase::Following).then_some(status);
        }
        // With friction the next call goes on with a step that this one had no iterations left for. (Without, one that is nearly right is
        // accepted: `track`.)
        let spent = spent + attempt.iterations;
        let waits = self.work.history.slip.rubs() && attempt.is_cut_off() && left < allowed && spent > 0;
        if waits && self.timeline.put_aside(search, spent, &self.model) {
            self.factored.is_near = false;
            return Some(Status::MaxIterations);
        }
        self.reject();
        if left == 0 && attempt.status == Status::MaxIterations {
            // Nothing was tried, so that nothing is known of the step.
            return Some(Status::MaxIterations);
        }
        self.timeline.stop_predicting();
        if remaining == T::ZERO && seconds > T::of(SHORTEST_PAUSE) {
            // A motor that stands: the time is what can be halved.
            self.pause = T::of(0.5) * seconds;
            return (outcome.iterations >= budget).then_some(Status::MaxIterations);
        }
        let half = size.min(remaining.abs()) * T::of(0.5);
        // A step that had its due, or a whole call to itself, has failed; another call would only repeat it.
        let due = allowed.min(PATIENCE).min(budget);
        let out_of_budget = attempt.status == Status::MaxIterations && left < due;
        if half >= self.max_step() * T::of(self.settings.min_step) {
            self.step = half;
        } else if passed {
            self.phase = Phase::Lost;
        } else if self.settings.hessian == Hessian::GaussNewton {
            // Without the geometric stiffness neither stability nor a fold can be told.
            self.step = self.max_step();
            return Some(attempt.status);
        } else if attempt.status == Status::ContactCapacity {
            self.step = self.max_step();
            return Some(Status::ContactCapacity);
        } else if !out_of_budget {
            // Just past the end the energy's slope is too faint to follow: go a small step further.
            let past = self.max_step() * T::of(FOLD_STEP);
            let target = if remaining > T::ZERO { self.timeline.at() + past } else { self.timeline.at() - past };
            self.failed = attempt.cause();
            self.timeline.take(target, to);
            self.phase = Phase::Folding { target, shift: T::of(FOLD_SHIFT), spent: 0 };
        }
        (outcome.iterations >= budget).then_some(Status::MaxIterations)
    }

    /// The step to the present state is long, and what comes into contact by it pulls by more than may be left in doubt.
    fn lands_early(&self, target: T) -> bool {
        let slip = &self.work.history.slip;
        self.settings.resolves_contact
            && slip.rubs()
            && !slip.is_forced()
            && (target - self.timeline.at()).abs() > T::of(SURE_BELOW) * self.max_step()
            && slip.doubtful(self.work.contacts.rows()) > T::of(DOUBTFUL)
    }

    /// Newton iterations that a step of this size may take.
    pub(super) fn patience(&self, size: T, reaches: bool) -> u32 {
        let large = size > self.max_step() * T::of(PATIENT_BELOW);
        if large && self.settings.hessian == Hessian::Newton {
            self.settings.max_iterations.min(if reaches { PATIENCE } else { PATIENCE_ON_THE_WAY })
        } else {
            self.settings.max_iterations
        }
    }

    /// Takes the present state. If it is one without contact whose rest position the object is in the way of, or behind (the
    /// finger has slipped off and past it), there is no equilibrium that the model knows of: the follower is lost.
    pub(super) fn accept(&mut self, at: T) {
        if self.timeline.present.touching_count == 0 && self.timeline.present.load == [T::ZERO; 2] {
            self.snapped = false;
            self.fall = Fall::NONE;
            // Nothing touches: the rest position exactly, whatever the iterations left behind, but where the material has yet to return.
            if !self.work.history.memory.is_strained() {
                self.timeline.present.rest();
                self.drift = T::ZERO;
                let object = self.seen(at);
                (_, self.sweep) = self.work.evaluate(&self.model, &self.timeline.present, &object, T::ZERO);
            }
            if self.sweep.nearest < -T::TOLERANCE.length || self.rests_behind(&self.sweep) {
                self.phase = Phase::Lost;
            }
        }
        self.keep(at);
    }

    pub(super) fn keep(&mut self, at: T) {
        self.bar(at);
        self.remember();
        self.timeline.accept(at, &self.model);
    }
}
