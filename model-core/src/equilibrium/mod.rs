//! Equilibria along a motion: continuation from no contact, the stability test, and what happens where a branch ends.
//!
//! The answer depends on the path (the finger can snap through, with hysteresis), so an equilibrium is always reached by
//! following the branch in small steps of the motion's coordinate: the motor angle in rad, or the distance in mm of a
//! translated base. A step counts only if all residuals are within tolerance *and* the equilibrium is stable; otherwise
//! it is halved. Where even the smallest step fails, the fold handler follows the overdamped motion from there to rest, just beyond,
//! and what it finds is flagged as a snap. If it finds nothing, the status says why the smallest step failed: `folded` only if the
//! stability test has seen a direction in which the energy falls.
//!
//! The inertia behind "stable" is that of the accepted state itself or of a state so near that no angle differs by more than
//! [`NEAR_ENOUGH`]: as a rule the one before the last Newton step. Steps without an iteration add up until they are as far as that; then
//! the state itself is judged.

mod carry;
mod fold;
mod hop;
mod passing;
mod settings;
mod solution;
mod strains;
#[cfg(test)]
mod tests;
mod track;

pub use settings::Settings;
pub use track::Tracking;

use crate::access::Access;
use crate::bounds::OutOfBounds;
use crate::design::Design;
use crate::discretise::{Discretisation, DiscretiseError, discretise};
use crate::ladder::{Ladder, State};
use crate::newton::gaps::{self, Sweep};
use crate::newton::residual::{self, Residual};
use crate::newton::step::{self, Inertia};
use crate::newton::{Hessian, Workspace, lagged};
use crate::object::{Motion, Object, Shape};
use crate::real::{Real, Tolerance};
use crate::size::Size;
use crate::status::Status;
use crate::units::Seen;
pub(crate) use carry::Mark;
use fold::{FOLD_SHIFT, FOLD_STEP};
use hop::Fall;
use passing::Barred;
pub use strains::{Place, Strain};

/// What a call of [`Follower::follow`] did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// Status of the equilibrium at the coordinate asked for.
    pub status: Status,
    /// Newton iterations spent in this call.
    pub iterations: u32,
    /// Steps of the coordinate accepted in this call.
    pub steps: u32,
    /// Snap-throughs to another branch in this call; the status stays `snapped` until the hand is open again.
    pub snaps: u32,
    /// Hops in this call: steep falls of the force on a branch that goes on; they are flagged as `snapped`, too.
    pub hops: u32,
    /// Largest gradient component at the last iterate, N·mm.
    pub gradient: f64,
    /// Largest closure or gap error at the last iterate, mm.
    pub length: f64,
}

/// What the follower is doing between calls.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase<T> {
    /// There is no accepted equilibrium.
    Lost,
    /// At an accepted equilibrium.
    Following,
    /// On the way from the end of a branch to rest.
    Folding { target: T, shift: T, spent: u32 },
    /// The branch cannot be followed beyond the accepted equilibrium and no other was found; the path back is open.
    Ended { forward: bool },
}

/// Newton iterations of one call of [`Follower::follow`]: a motion over many snaps takes a few thousand.
pub const FOLLOW_ITERATIONS: u32 = 20_000;
/// Places at which [`Follower::start`] looks for an open finger, each one evaluation of the gaps.
pub const START_CHECKS: u32 = 8192;
/// Ends of branches that one call looks beyond. Where two branches end into each other, more would go on for ever.
const FOLDS: u32 = 24;
/// Newton iterations after which a step is halved rather than pursued: iterates that wander may end on another branch.
///
/// *Measured* on 10,000 random fingers at steps of 1° (`cargo xtask bench branches`): a closing takes 28 (extended) to 34 (paper)
/// iterations, and none and 4 of them end on another branch than at steps of 0.1°; with the present stiffness in every iteration it
/// were 25 and 31, and 2 and 3; then with 8 iterations here and 5 below 5 and 9, at the same cost.
const PATIENCE: u32 = 5;
/// The same on the way to the coordinate asked for, where the tolerance is looser.
const PATIENCE_ON_THE_WAY: u32 = 4;
/// Part of the largest step below which they may take all that the settings allow: a step this short does not stray.
const PATIENT_BELOW: f64 = 1.0 / 16.0;

/// Follows a finger's equilibrium on an object: model, state and workspace.
///
/// `O` is the object's type: one of the built-in shapes unless it is named.
pub struct Follower<T: Real, S: Size, O: Object<T> = Shape<T>> {
    ladder: Ladder<T, S>,
    state: State<T, S>,
    accepted: State<T, S>,
    /// The accepted state before that, and its coordinate: what the next step is extrapolated from.
    previous: State<T, S>,
    before: T,
    extrapolates: bool,
    work: Workspace<T, S>,
    settings: Settings,
    object: O,
    pub(crate) motion: Motion,
    youngs_modulus: T,
    /// Coordinate of the accepted state.
    at: T,
    /// The next step of the coordinate at most, and any step (see [`Self::allow_steps`]).
    step: T,
    largest_step: T,
    phase: Phase<T>,
    snapped: bool,
    /// The state before is what [`Self::go_back`] returns to: it stays, and nothing is extrapolated.
    is_marked: bool,
    /// Largest difference of an angle between the accepted state and the one whose inertia says that it is stable, rad.
    drift: T,
    /// Why the smallest step failed where the branch could not be followed.
    failed: Status,
    fall: Fall<T>,
    barred: Barred<T>,
    sweep: Sweep<T>,
}

/// Contraction of the residuals by one step below which the next one keeps the stiffness. *Measured* at 170/20: anything from 0.005 to
/// 0.1 costs the same, one count and cold.
const SWIFT: f64 = 0.02;
/// New rows of a short step's first iteration beyond which they are thinned.
const MANY: usize = 7;

/// Residuals at which a step on the way to the coordinate asked for is accepted: single precision's, whatever the precision.
fn on_the_way<T: Real>() -> Tolerance<T> {
    let Tolerance { gradient, length } = f32::TOLERANCE;
    Tolerance { gradient: T::of(f64::from(gradient)), length: T::of(f64::from(length)) }
}

/// Largest difference of an angle, rad, at which one state's inertia is taken for another's (see the module).
pub const NEAR_ENOUGH: f64 = 2e-3;
/// Change of an angle, in units of the precision's [`Real::EPSILON`], below which a Newton step is rounding.
const ROUNDING: f64 = 1e3;

/// Result of Newton's method at one coordinate.
struct Attempt<T> {
    status: Status,
    iterations: u32,
    /// What the last factorisation says, and how far the state has moved from the one that it was made at.
    inertia: Option<Inertia>,
    drift: T,
    /// Some iterate was unstable with contacts that had settled.
    unstable: bool,
    /// Largest change of an angle in the smallest step, rad.
    least_pace: T,
    residual: Residual<T>,
}

impl<T: Real> Attempt<T> {
    /// Why it failed.
    fn cause(&self) -> Status {
        if self.unstable {
            Status::Folded
        } else if self.inertia.is_some_and(|inertia| !inertia.settled) {
            Status::Unsettled
        } else if self.least_pace <= T::of(ROUNDING) * T::EPSILON
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
    /// Size of the states and the workspace: what changes while a motion is followed, bytes.
    pub const STATE_BYTES: usize = 3 * size_of::<State<T, S>>() + size_of::<Workspace<T, S>>();

    /// A follower before [`Self::configure`]: every [`Self::follow`] returns `out-of-range`.
    pub const EMPTY: Self = Self {
        ladder: Ladder::EMPTY,
        state: State::EMPTY,
        accepted: State::EMPTY,
        previous: State::EMPTY,
        before: T::ZERO,
        extrapolates: false,
        work: Workspace::EMPTY,
        // All zeros, as everything here: [`Self::configure`] puts the defaults in.
        settings: Settings::UNSET,
        object: O::BLANK,
        motion: Motion::Rotating { axis: [0.0; 2] },
        youngs_modulus: T::ZERO,
        at: T::ZERO,
        step: T::ZERO,
        largest_step: T::ZERO,
        phase: Phase::Lost,
        snapped: false,
        is_marked: false,
        drift: T::ZERO,
        // Never read; all zeros.
        failed: Status::Converged,
        fall: Fall::NONE,
        barred: Barred::NONE,
        sweep: Sweep { nearest: T::ZERO, normal: [T::ZERO; 2], nearest_free: T::ZERO, overflow: false, crowded: false },
    };

    /// Takes a finger; the motion becomes the rotation about its motor axis, the finger is at rest.
    ///
    /// # Errors
    /// What [`discretise`] refuses; the follower is then empty.
    pub fn configure(&mut self, design: &Design, how: &Discretisation) -> Result<(), DiscretiseError> {
        self.phase = Phase::Lost;
        if self.settings == Settings::UNSET {
            self.settings = Settings::DEFAULT;
        }
        let made = discretise(design, how, &mut self.ladder);
        let fits = made.is_ok()
            && self.state.fit(&self.ladder)
            && self.accepted.fit(&self.ladder)
            && self.previous.fit(&self.ladder)
            && self.work.fit(&self.ladder);
        if !fits {
            self.ladder.reset(0);
            return made.and(Err(DiscretiseError::Capacity));
        }
        self.motion = Motion::Rotating { axis: design.motor_axis };
        self.youngs_modulus = T::of(design.material.youngs_modulus);
        self.refine();
        self.rest();
        Ok(())
    }

    /// Changes how equilibria are followed.
    ///
    /// # Errors
    /// The first value that is not allowed; the old settings then stay.
    pub fn set_settings(&mut self, settings: Settings) -> Result<(), OutOfBounds> {
        settings.validate()?;
        self.settings = settings;
        self.allow_steps();
        Ok(())
    }

    /// Follows with the settings that suit a second derivative, [`Settings::of`].
    pub fn set_hessian(&mut self, hessian: Hessian) {
        self.settings = Settings::of(hessian);
        self.allow_steps();
    }

    /// Takes an object and the motion between finger and object; the finger is at rest again.
    pub fn set_object(&mut self, object: impl Into<O>, motion: Motion) {
        self.object = object.into();
        self.motion = motion;
        self.is_marked = false;
        self.refine();
        self.rest();
    }

    /// The undeformed finger, as if the object were far away.
    #[inline(never)]
    pub fn rest(&mut self) {
        if self.ladder.cells == 0 {
            return;
        }
        self.state.rest();
        self.accepted.rest();
        self.extrapolates = false;
        self.phase = Phase::Following;
        self.snapped = false;
        (self.drift, self.fall) = (T::ZERO, Fall::NONE);
        self.barred = Barred::NONE;
        self.allow_steps();
        self.work.row_count = 0;
        residual::potential(&self.ladder, &self.state, &mut self.work);
    }

    /// Puts a dead load (finger frame, N) on the front beam where lamella `lamella` is joined (from 0; any larger number
    /// is the tip), from the next [`Self::follow`] on; [`Self::rest`] takes it away.
    ///
    /// For tests of the model and for stiffness figures; increase it in steps, as the load itself is not followed.
    pub fn set_dead_load(&mut self, lamella: usize, load: [f64; 2]) {
        let unit = self.ladder.units.force;
        self.state.load = load.map(|force| T::of(force) / unit);
        self.state.load_cell = lamella.min(self.ladder.cells.saturating_sub(1));
        (self.accepted.load, self.accepted.load_cell) = (self.state.load, self.state.load_cell);
    }

    /// Puts the undeformed finger where the following of a motion to `first` can begin: at the largest coordinate not
    /// above `first` at which the object lies clear in front of the finger, searched back over a half turn (or 500 units of
    /// length) at most [`START_CHECKS`] places, a quarter of the largest step apart where that many reach.
    ///
    /// Returns false, and leaves the follower lost, if there is none.
    pub fn start(&mut self, first: f64) -> bool {
        self.phase = Phase::Lost;
        if self.ladder.cells == 0 || !first.is_finite() {
            return false;
        }
        let (step, reach) = match self.motion {
            Motion::Rotating { .. } => (self.settings.max_angle_step, core::f64::consts::PI),
            Motion::Translating { .. } => {
                let unit = self.ladder.units.length.to_f64();
                (self.settings.max_distance_step * unit, 500.0 * unit)
            }
        };
        let pace = (0.25 * step).max(reach / f64::from(START_CHECKS - 1));
        let mut places = (0..START_CHECKS).map(|check| f64::from(check) * pace).take_while(|back| *back <= reach);
        places.any(|back| self.begin(first - back))
    }

    /// Puts the undeformed finger at a coordinate if the object lies clear in front of it there; otherwise the follower is
    /// lost. One evaluation of the gaps.
    pub fn begin(&mut self, coordinate: f64) -> bool {
        self.rest();
        self.phase = Phase::Lost;
        let clear = self.ladder.cells > 0 && self.is_clear(T::of(coordinate));
        if clear {
            self.at = T::of(coordinate);
            self.phase = Phase::Following;
        }
        clear
    }

    /// The finger at rest neither touches the object nor has passed it: the object lies on the front beam's outer side.
    fn is_clear(&mut self, coordinate: T) -> bool {
        self.state.rest();
        let object = self.seen(coordinate);
        let (_, sweep) = step::evaluate(&self.ladder, &self.state, &mut self.work, &object, T::ZERO);
        sweep.nearest >= T::ZERO && !self.rests_behind(&sweep)
    }

    /// Looks for contacts as densely as the object asks.
    #[inline(never)]
    fn refine(&mut self) {
        self.ladder.refine(Seen::new(self.object, &self.ladder.units).sharpest());
    }

    /// Largest step of the coordinate.
    fn max_step(&self) -> T {
        self.largest_step
    }

    /// Allows the largest steps: what the settings say, and on a sharp object less, so that none passes through it unseen.
    fn allow_steps(&mut self) {
        self.largest_step = self.step_on_object();
        self.step = self.largest_step;
    }

    #[inline(never)]
    fn step_on_object(&self) -> T {
        let (allowed, unit) = match self.motion {
            Motion::Rotating { .. } => (T::of(self.settings.max_angle_step), T::one()),
            Motion::Translating { .. } => {
                let unit = self.ladder.units.length;
                (T::of(self.settings.max_distance_step) * unit, unit)
            }
        };
        if self.ladder.fineness <= 1 {
            return allowed;
        }
        let arm = match self.motion {
            Motion::Rotating { axis } => {
                let [x, y] = axis.map(|place| T::of(place) / self.ladder.units.length);
                let [u, v] = self.ladder.base;
                let length = self.ladder.samples.as_ref().at(self.ladder.sample_count.saturating_sub(1)).arc;
                ((x - u) * (x - u) + (y - v) * (y - v)).sqrt() + length
            }
            Motion::Translating { .. } => T::one(),
        };
        allowed.min(T::of(0.5) * self.ladder.sharpest / arm * unit)
    }

    /// The object as the solver sees it at a coordinate: in the finger's frame and units.
    // Every shape's displacement: one copy of it in the flash.
    #[inline(never)]
    fn seen(&self, coordinate: T) -> Seen<T, O> {
        Seen::new(self.object.displaced(&self.motion.world_to_finger(coordinate)), &self.ladder.units)
    }

    /// Reports residuals in N·mm and mm.
    fn note(&self, residual: &Residual<T>, outcome: &mut Outcome) {
        let units = &self.ladder.units;
        outcome.gradient = (residual.gradient * units.moment()).to_f64();
        outcome.length = (residual.length * units.length).to_f64();
    }

    /// Follows the equilibrium to a coordinate (rad or mm), with at most [`FOLLOW_ITERATIONS`] Newton iterations.
    pub fn follow(&mut self, to: f64) -> Outcome {
        self.follow_within(to, FOLLOW_ITERATIONS)
    }

    /// Follows the equilibrium towards a coordinate with at most `budget` Newton iterations and accepted steps.
    ///
    /// With `max-iterations` the coordinate was not reached yet; the next call goes on from where this one stopped.
    pub fn follow_within(&mut self, to: f64, budget: u32) -> Outcome {
        let mut outcome = Outcome {
            status: Status::OutOfRange,
            iterations: 0,
            steps: 0,
            snaps: 0,
            hops: 0,
            gradient: 0.0,
            length: 0.0,
        };
        if self.ladder.cells == 0 || !to.is_finite() {
            return outcome;
        }
        let to = T::of(to);
        let mut folds = 0;
        loop {
            match self.phase {
                Phase::Lost => {
                    // An open hand is a new beginning.
                    if !self.is_clear(to) {
                        outcome.status = Status::OutOfRange;
                        return outcome;
                    }
                    self.rest();
                    self.at = to;
                }
                Phase::Ended { forward } => {
                    if (to > self.at) == forward {
                        outcome.status = self.or_open_hand(to, self.failed);
                        return outcome;
                    }
                    self.phase = Phase::Following;
                }
                Phase::Folding { target, shift, spent } => {
                    let left = budget.saturating_sub(outcome.iterations);
                    if left == 0 {
                        outcome.status = Status::MaxIterations;
                        return outcome;
                    }
                    folds += u32::from(spent == 0);
                    if folds > FOLDS {
                        self.state.copy_from(&self.accepted, &self.ladder);
                        self.phase = Phase::Ended { forward: target > self.at };
                        continue;
                    }
                    self.fold(target, shift, spent, left, &mut outcome);
                }
                Phase::Following => {
                    let done = self.advance(to, budget, &mut outcome);
                    if let Some(status) = done {
                        let failed = !status.is_trustworthy();
                        outcome.status = if failed { self.or_open_hand(to, status) } else { status };
                        return outcome;
                    }
                }
            }
        }
    }

    /// Where no branch leads on but the object lies clear of the undeformed finger, that is the equilibrium: an open hand
    /// is always a new beginning. Otherwise the accepted state is shown with the status that says what failed.
    fn or_open_hand(&mut self, to: T, failed: Status) -> Status {
        // A budget that ran out says nothing about the branch.
        if failed != Status::MaxIterations && self.is_clear(to) {
            self.rest();
            self.accept(to);
            return Status::NoContact;
        }
        self.show_accepted();
        failed
    }

    /// One step towards `to`; the status if the call ends with it.
    fn advance(&mut self, to: T, budget: u32, outcome: &mut Outcome) -> Option<Status> {
        let remaining = to - self.at;
        let untouched = self.accepted.touching_count == 0 && self.accepted.load == [T::ZERO; 2];
        if untouched && remaining.abs() > self.max_step() && self.is_clear(to) {
            // From one open hand to another nothing happens on the way.
            self.accept(to);
            outcome.steps += 1;
            return Some(self.standing());
        }
        let size = self.step.min(self.max_step());
        let reaches = remaining.abs() <= size;
        let target = if reaches {
            to
        } else if remaining > T::ZERO {
            self.at + size
        } else {
            self.at - size
        };
        // A step costs at least an evaluation, also where it needs no iteration.
        let left = budget.saturating_sub(outcome.iterations + outcome.steps);
        if left == 0 && outcome.steps > 0 {
            return Some(Status::MaxIterations);
        }
        self.extrapolate(target);
        let tolerance = if reaches { T::TOLERANCE } else { on_the_way() };
        let allowed = self.patience((target - self.at).abs(), reaches);
        let attempt = self.newton(target, allowed, left, tolerance);
        outcome.iterations += attempt.iterations;
        self.note(&attempt.residual, outcome);
        let stable = self.settings.hessian == Hessian::GaussNewton || attempt.inertia.is_none_or(|i| i.is_stable());
        let converged = attempt.status == Status::Converged && stable;
        let passed = converged && self.presses_from_behind();
        if converged && !passed && !self.leaps(target) {
            self.drift = attempt.drift;
            if untouched && attempt.iterations == 0 {
                // The open hand as it was, and evaluated as it is.
                self.keep(target);
            } else {
                outcome.hops += u32::from(self.hops(target));
                self.accept(target);
            }
            outcome.steps += 1;
            self.step = (size + size).min(self.max_step());
            return (reaches && self.phase == Phase::Following).then(|| self.standing());
        }
        self.state.copy_from(&self.accepted, &self.ladder);
        if left == 0 && attempt.status == Status::MaxIterations {
            // Nothing was tried, so that nothing is known of the step.
            return Some(Status::MaxIterations);
        }
        self.extrapolates = false;
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
            let target = if remaining > T::ZERO { self.at + past } else { self.at - past };
            self.failed = attempt.cause();
            self.phase = Phase::Folding { target, shift: T::of(FOLD_SHIFT), spent: 0 };
        }
        (outcome.iterations >= budget).then_some(Status::MaxIterations)
    }

    /// Newton iterations that a step of this size may take.
    fn patience(&self, size: T, reaches: bool) -> u32 {
        let large = size > self.max_step() * T::of(PATIENT_BELOW);
        if large && self.settings.hessian == Hessian::Newton {
            self.settings.max_iterations.min(if reaches { PATIENCE } else { PATIENCE_ON_THE_WAY })
        } else {
            self.settings.max_iterations
        }
    }

    /// Takes the present state. If it is one without contact whose rest position the object is in the way of, or behind (the
    /// finger has slipped off and past it), there is no equilibrium that the model knows of: the follower is lost.
    fn accept(&mut self, at: T) {
        if self.state.touching_count == 0 && self.state.load == [T::ZERO; 2] {
            // Nothing touches: the rest position exactly, whatever the iterations left behind.
            self.state.rest();
            self.snapped = false;
            (self.drift, self.fall) = (T::ZERO, Fall::NONE);
            let object = self.seen(at);
            (_, self.sweep) = step::evaluate(&self.ladder, &self.state, &mut self.work, &object, T::ZERO);
            if self.sweep.nearest < -T::TOLERANCE.length || self.rests_behind(&self.sweep) {
                self.phase = Phase::Lost;
            }
        }
        self.keep(at);
    }

    fn keep(&mut self, at: T) {
        // A coordinate that has come again tells nothing of the motion.
        if at != self.at && !self.is_marked {
            self.previous.copy_from(&self.accepted, &self.ladder);
            self.before = self.at;
        }
        self.accepted.copy_from(&self.state, &self.ladder);
        self.bar(at);
        self.at = at;
        self.extrapolates = !self.is_marked && self.accepted.touching_count > 0 && self.previous.touching_count > 0;
    }

    /// Moves the state on to a coordinate along the line through the last two accepted ones.
    fn extrapolate(&mut self, target: T) {
        let (step, last) = (target - self.at, self.at - self.before);
        if !self.extrapolates || last == T::ZERO || step.abs() > T::of(4.0) * last.abs() {
            return;
        }
        self.state.extrapolate(&self.previous, step / last, &self.ladder);
    }

    /// Brings the workspace, which results are read from, back to the accepted state.
    #[inline(never)]
    pub(crate) fn show_accepted(&mut self) {
        self.state.copy_from(&self.accepted, &self.ladder);
        let object = self.seen(self.at);
        (_, self.sweep) = step::evaluate(&self.ladder, &self.state, &mut self.work, &object, T::ZERO);
    }

    /// Completes the workspace with the second derivatives at the accepted state, if the last evaluation did without them.
    pub(crate) fn deepen(&mut self) {
        if self.work.shallow {
            self.show_accepted();
        }
    }

    pub(crate) fn standing(&self) -> Status {
        if self.phase == Phase::Lost || self.barred.way != 0 || !self.base_is_free(self.at) {
            Status::OutOfRange
        } else if self.state.touching_count == 0 {
            Status::NoContact
        } else if self.snapped {
            Status::Snapped
        } else {
            Status::Converged
        }
    }

    /// Newton's method at a coordinate from the present state, with at most so many iterations; judging the solution may take one more,
    /// within the budget.
    fn newton(&mut self, coordinate: T, max_iterations: u32, budget: u32, tolerance: Tolerance<T>) -> Attempt<T> {
        let max_iterations = max_iterations.min(budget);
        let object = self.seen(coordinate);
        let margin = T::of(self.settings.margin) / self.ladder.units.length;
        let mut attempt = Attempt {
            status: Status::MaxIterations,
            iterations: 0,
            inertia: None,
            drift: T::ZERO,
            unstable: false,
            least_pace: T::of(1e30),
            residual: Residual { gradient: T::of(1e30), length: T::of(1e30) },
        };
        let small = (coordinate - self.at).abs() <= T::of(0.25) * self.max_step();
        let (mut best, mut last) = (T::of(1e30), T::of(1e30));
        let mut stalled = 0;
        let mut lags = false;
        loop {
            let (residual, sweep) = if lags {
                step::residuals(&self.ladder, &self.state, &mut self.work, &object, margin)
            } else {
                step::evaluate(&self.ladder, &self.state, &mut self.work, &object, margin)
            };
            if attempt.iterations == 0 && small && self.ladder.fineness <= 1 {
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
                    if self.work.shallow {
                        step::evaluate(&self.ladder, &self.state, &mut self.work, &object, margin);
                    }
                    let inertia = step::solve(&self.ladder, &mut self.work, Hessian::Newton, T::ZERO);
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
            let swift = lags && size <= last * T::of(SWIFT) && attempt.drift <= near;
            last = size;
            let inertia = if swift && lagged::align(&self.ladder, &mut self.work) {
                lagged::solve(&self.ladder, &mut self.work)
            } else {
                if lags {
                    step::evaluate(&self.ladder, &self.state, &mut self.work, &object, margin);
                }
                attempt.drift = T::ZERO;
                step::solve(&self.ladder, &mut self.work, self.settings.hessian, T::ZERO)
            };
            attempt.inertia = Some(inertia);
            attempt.unstable |= inertia.is_unstable();
            attempt.iterations += 1;
            let part = step::clip(&self.work);
            attempt.drift += part * self.work.pace;
            attempt.least_pace = attempt.least_pace.min(self.work.pace);
            step::apply(&self.ladder, &mut self.state, &self.work, part);
            lags = lagged::pays::<T>() && part == T::one() && self.settings.hessian == Hessian::Newton;
        }
    }
}
