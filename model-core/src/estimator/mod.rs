//! Motor angle in, contact force out, once per tick of a control loop, in bounded time.
//!
//! The estimator keeps the equilibrium of the last tick and follows it to the new angle with at most
//! [`EstimatorSettings::budget`] Newton iterations. When that is not enough, or when the solver does not vouch for the
//! result, the estimate repeats the last trustworthy numbers with a status that is not trustworthy and an age above zero,
//! and the next tick goes on from where this one stopped, or this one does, for who has time left ([`Estimator::go_on`]). Where the motor turns
//! round meanwhile, the estimate goes by way of that turn. An object set while the finger is on it is approached anew from the open finger, over
//! as many ticks as that takes.
//!
//! With friction the force depends on the way ([`Interval`]): the history follows the measured angle with a play of one count, and the rest
//! of the angle goes into the force by its derivative. While the way is not known, the force is the middle of an interval, whose width is in
//! the standard deviation. An object set while the finger is on it is approached as if there were no friction, since the way is not known then.
//! Where a contact finds no room for a while, fewer samples count and the finger is followed anew.
//!
//! With memory the force depends on time as well: an elastic finger is followed, and its force faded ([`crate::fading`]).
//!
//! Parallel jaws move the base along a line: their [`Drive`] says how far at which motor angle. Everything that goes in or comes out is
//! of the motor angle all the same.

mod beside;
mod derivatives;
mod estimate;
mod friction;
#[cfg(test)]
mod going_on;
#[cfg(test)]
mod holding;
mod interval;
mod memory;
mod path;
#[cfg(test)]
mod relaxing;
#[cfg(test)]
mod tests;
mod turn;

use core::ops::ControlFlow;

use crate::bounds::OutOfBounds;
use crate::design::Design;
use crate::discretise::{Discretisation, DiscretiseError};
use crate::drive::{Drive, DriveError};
use crate::equilibrium::{Follower, Outcome, Settings, Tracking};
use crate::fading::Fading;
use crate::object::{ObjectDesign, ObjectError};
use crate::real::Real;
use crate::size::{Size, Storage};
use crate::status::Status;
use crate::uncertainty::{Slopes, Uncertainty, UncertaintyError};
pub use estimate::{Estimate, EstimatorSettings};
use friction::Rub;
pub use interval::Interval;

/// Estimates the contact force of one finger on one object from the motor angle.
pub struct Estimator<T: Real, S: Size> {
    follower: Follower<T, S>,
    /// What was set, if anything was. (An `Option` of it would not be all zeros: every model would lie in the flash as well.)
    settings: EstimatorSettings,
    has_settings: bool,
    /// Last trustworthy numbers, of an elastic material; the status is set anew every tick.
    last: Estimate,
    object: ObjectDesign,
    has_object: bool,
    drive: Drive,
    axis: [f64; 2],
    /// Derivative of the motion's coordinate with the motor angle at the last tick: 1, or mm per rad.
    ratio: f64,
    configured: bool,
    /// The follower is at an equilibrium.
    placed: bool,
    /// How far back from the measured angle a beginning has been looked for, rad.
    searched: f64,
    /// The angle that was to be followed to in the last tick, and that of a turn which the follower has not reached yet, rad.
    asked: f64,
    due: Option<f64>,
    /// None: the defaults.
    uncertainty: Option<Uncertainty>,
    /// Of the force's magnitude, as last taken.
    slopes: Slopes,
    /// The derivatives are those of this contact and branch.
    differentiated: bool,
    /// The equilibrium was found to be one after the last step: at the same angle there is nothing left to do.
    settled: bool,
    /// The derivatives are those of this equilibrium.
    is_fresh: bool,
    /// In the last tick the motor was where it had been.
    has_rested: bool,
    /// What friction keeps, if there is room for it.
    rub: S::SlipOnce<Rub>,
    /// What the material keeps.
    memory: Fading<f32>,
    /// It has begun.
    is_found: bool,
}

/// Whether a tick has its estimate begun or goes on with it.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Visit {
    First,
    Again,
}

/// Iterations in which a tick of one servo count converges, but for few. With a smaller budget the estimator is content with one step whose residual
/// was small before it ([`EstimatorSettings::budget`]).
pub const CONVERGES_WITHIN: u32 = 3;
/// Angles at which a beginning is looked for in one tick: as many as it may do iterations, but within these.
const CHECKS_PER_TICK: u32 = 8;
const LEAST_CHECKS: u32 = 2;
/// Their distance, rad.
const SEARCH_PACE: f64 = core::f64::consts::PI / 180.0;
/// Derivatives are taken anew after this many ticks: at 500 Hz and 20°/s the finger has then turned by 0.3°.
const DIFFERENTIATE_EVERY: u16 = 8;
/// ... in the next tick that needs no more Newton iterations than this, which bounds the worst tick's cost.
const DIFFERENTIATE_WITHIN: u32 = 2;
/// Ticks with more contact than there is room for with friction, which has half of it, after which fewer samples count.
const CROWDED_FOR: u32 = 16;
/// How far the motor may go in a tick that is for something else than following it, rad: three counts.
const SHORT_WAY: f64 = 3.1 * core::f64::consts::TAU / 4096.0;

fn single<T: Real>(v: [T; 2]) -> [f32; 2] {
    v.map(|x| x.to_f64() as f32)
}

impl<T: Real, S: Size> Estimator<T, S> {
    /// An estimator without finger and object: every estimate is `out-of-range`.
    pub const EMPTY: Self = Self {
        follower: Follower::EMPTY,
        settings: EstimatorSettings { budget: 0, range: [0.0; 2], one_iteration: None },
        has_settings: false,
        // All zeros, as everything here; the status is never read.
        last: Estimate::blank(Status::Converged),
        // An absent object need not be all zeros.
        object: ObjectDesign::Circle { centre: [0.0; 2], radius: 0.0 },
        has_object: false,
        drive: Drive::Rotating,
        axis: [0.0; 2],
        ratio: 0.0,
        configured: false,
        placed: false,
        searched: 0.0,
        asked: 0.0,
        due: None,
        uncertainty: None,
        slopes: Slopes { angle: 0.0, youngs_modulus: 0.0, centre: [0.0; 2], radius: 0.0 },
        differentiated: false,
        settled: false,
        is_fresh: false,
        has_rested: false,
        rub: <S::SlipOnce<Rub> as Storage<Rub>>::EMPTY,
        memory: Fading::ELASTIC,
        is_found: false,
    };

    /// Takes a finger; the state starts anew, object and drive stay.
    ///
    /// # Errors
    /// What the discretisation refuses; the estimator then has no finger.
    pub fn configure(&mut self, design: &Design, how: &Discretisation) -> Result<(), DiscretiseError> {
        self.configured = false;
        self.follower.configure(design, how)?;
        if !self.rub.fit(usize::from(S::RUBS)) {
            return Err(DiscretiseError::Capacity);
        }
        self.configured = true;
        self.axis = design.motor_axis;
        self.start_anew();
        Ok(())
    }

    /// Takes an object; the state starts anew.
    ///
    /// # Errors
    /// What is wrong with the object; the old one then stays.
    pub fn set_object(&mut self, object: ObjectDesign) -> Result<(), ObjectError> {
        object.validate()?;
        (self.object, self.has_object) = (object, true);
        self.start_anew();
        Ok(())
    }

    /// Says how the motor moves the base ([`Drive::Rotating`] by default); the state starts anew, if it is another one.
    ///
    /// # Errors
    /// What is wrong with the drive; the old one then stays.
    pub fn set_drive(&mut self, drive: Drive) -> Result<(), DriveError> {
        drive.validate()?;
        if drive != self.drive {
            self.drive = drive;
            self.start_anew();
        }
        Ok(())
    }

    fn start_anew(&mut self) {
        if self.configured && self.has_object {
            self.follower.set_object(self.object, self.drive.motion(self.axis));
        }
        (self.placed, self.searched, self.differentiated, self.settled) = (false, 0.0, false, false);
        self.keep(Rub::EMPTY);
        self.memory.begin();
        self.is_found = false;
    }

    /// Takes a coefficient of friction between finger and object, 0 for none; the state starts anew, if it is another one.
    ///
    /// # Errors
    /// A coefficient out of range, and any but zero where [`Size::RUBS`] is false; the old one then stays.
    pub fn set_friction(&mut self, coefficient: f64) -> Result<(), OutOfBounds> {
        if self.follower.friction() != T::of(coefficient) {
            self.follower.set_friction(coefficient)?;
            self.start_anew();
        }
        Ok(())
    }

    /// Ticks were lost, or the finger was moved unseen: with friction the force is unknown within an interval until a motion makes it certain.
    pub fn forget_path(&mut self) {
        let mut rub = self.rub();
        rub.path.forget();
        self.keep(rub);
    }

    /// Friction's part of [`Estimate::interval`] of the last estimate, if that was trustworthy.
    pub fn interval(&self) -> Option<Interval> {
        self.last.interval.filter(|_| self.last.age == 0)
    }

    /// Changes the bounds of the estimator and how its solver follows.
    ///
    /// # Errors
    /// The first value that is not allowed; the old settings then stay.
    pub fn set_settings(&mut self, settings: EstimatorSettings, solver: Settings) -> Result<(), OutOfBounds> {
        settings.validate()?;
        self.follower.set_settings(solver)?;
        (self.settings, self.has_settings) = (settings, true);
        Ok(())
    }

    /// Allows so many Newton iterations per tick from now on: what is left of a control loop's period may differ from tick to
    /// tick.
    pub fn set_budget(&mut self, budget: u32) {
        (self.settings, self.has_settings) = (EstimatorSettings { budget, ..self.settings() }, true);
    }

    fn settings(&self) -> EstimatorSettings {
        if self.has_settings { self.settings } else { EstimatorSettings::DEFAULT }
    }

    /// Says how uncertain angle and parameters are.
    ///
    /// # Errors
    /// The first value that is not allowed; the old ones then stay.
    pub fn set_uncertainty(&mut self, uncertainty: Uncertainty) -> Result<(), UncertaintyError> {
        uncertainty.validate()?;
        self.uncertainty = Some(uncertainty);
        Ok(())
    }

    fn given(&self) -> Uncertainty {
        self.uncertainty.unwrap_or(Uncertainty::DEFAULT)
    }

    /// The solver behind the estimate: deformed shape and contacts of the last followed equilibrium.
    pub fn follower(&self) -> &Follower<T, S> {
        &self.follower
    }

    /// There is friction.
    pub fn rubs(&self) -> bool {
        self.follower.rubs()
    }

    /// The last estimate found the motor where it had been, and had nothing to do: what it took says nothing of what others take.
    pub fn has_rested(&self) -> bool {
        self.has_rested
    }

    /// The object as it was set.
    pub fn object(&self) -> Option<&ObjectDesign> {
        self.has_object.then_some(&self.object)
    }

    /// The solver, for who moves the object from where it was set ([`crate::grasp::Grasp::resume`]); [`Self::reread`]
    /// afterwards.
    pub fn follower_mut(&mut self) -> &mut Follower<T, S> {
        self.settled = false;
        &mut self.follower
    }

    /// Takes a measured motor angle, rad, without following it: the coordinate (rad or mm) to which the finger is to go, for who moves finger and
    /// object together ([`crate::grasp::Grasp::advance_within`]); [`Self::reread`] afterwards. `None` for an angle out of range and while there is no
    /// equilibrium to go on from: [`Self::update_after`] says so and looks for one.
    #[inline(never)]
    pub fn head_for(&mut self, motor_angle: f64) -> Option<f64> {
        let settings = self.settings();
        let [least, most] = settings.range;
        if !self.placed
            || !self.follower.has_equilibrium()
            || self.follower.approaches()
            || !(least..=most).contains(&motor_angle)
        {
            return None;
        }
        let followed = if self.follower.rubs() { self.lead_path(motor_angle) } else { motor_angle };
        let [coordinate, ratio] = self.drive.coordinate(followed)?;
        self.ratio = ratio;
        self.set_off(followed);
        let stands = T::of(coordinate).to_f64() == self.follower.solution().coordinate();
        (self.last.motor_angle, self.has_rested, self.settled) = (motor_angle as f32, stands, false);
        let rubs = self.follower.rubs();
        let supposed = if rubs { self.suppose_path(settings.budget) } else { ControlFlow::Continue(0) };
        let (ControlFlow::Continue(spent) | ControlFlow::Break(spent)) = supposed;
        self.last.iterations = spent as u16;
        self.last.sensitivity_age = self.last.sensitivity_age.saturating_add(1);
        // Where no iteration is left, it stays where it is for now.
        Some(if supposed.is_continue() { coordinate } else { self.follower.solution().coordinate() })
    }

    /// The last estimate with the numbers of the place that the object was moved to. Derivatives and standard deviation are for an object that
    /// stands still; without friction they stay those of the estimate.
    #[inline(never)]
    pub fn reread(&mut self) -> Estimate {
        let mut estimate = self.last;
        self.placed &= self.follower.has_equilibrium();
        estimate.status = if self.placed { self.follower.standing() } else { Status::OutOfRange };
        if estimate.status.is_trustworthy() {
            self.read(&mut estimate);
            if self.follower.rubs() {
                let aside = self.left_aside(Some(0));
                self.read_rubbing(&mut estimate, aside, true);
            }
            estimate.age = 0;
        } else {
            estimate.age = self.last.age.saturating_add(1);
        }
        self.last = estimate;
        if self.fades() { self.fade(&estimate) } else { estimate }
    }

    /// Estimates at a measured motor angle, rad. No time passes: a material with memory needs [`Self::update_after`].
    pub fn update(&mut self, motor_angle: f64) -> Estimate {
        self.update_after(motor_angle, 0.0)
    }

    /// Estimates at a motor angle, rad, so many seconds after the estimate before, whatever became of that.
    pub fn update_after(&mut self, motor_angle: f64, seconds: f64) -> Estimate {
        let elastic = self.follow(motor_angle, Visit::First);
        if !self.fades() {
            return elastic;
        }
        self.memory.pass(seconds);
        self.fade(&elastic)
    }

    /// Goes on with an estimate that is not trustworthy, at the angle it was asked for and in its tick, with the budget once more: for who looks
    /// at a clock in between. Its iterations are those of the whole tick; derivatives are left to the next one.
    pub fn go_on(&mut self, motor_angle: f64) -> Estimate {
        let elastic = self.follow(motor_angle, Visit::Again);
        if self.fades() { self.fade(&elastic) } else { elastic }
    }

    /// The estimate of an elastic material.
    fn follow(&mut self, motor_angle: f64, visit: Visit) -> Estimate {
        let settings = self.settings();
        let [least, most] = settings.range;
        let mut estimate = self.last;
        estimate.motor_angle = motor_angle as f32;
        let (is_first, before) = match visit {
            Visit::First => (true, 0),
            Visit::Again => (false, self.last.iterations),
        };
        estimate.iterations = before;
        self.has_rested = false;
        let ready = self.configured && self.has_object && (least..=most).contains(&motor_angle);
        let rubs = self.follower.rubs();
        let followed = match (rubs && ready, visit) {
            (true, Visit::First) => self.follow_path(motor_angle),
            (true, Visit::Again) => self.rub().path.at(),
            (false, _) => motor_angle,
        };
        let place = self.drive.coordinate(followed).filter(|_| ready);
        let [coordinate, ratio] = place.unwrap_or_default();
        self.ratio = ratio;
        if !self.placed {
            self.set_off(followed);
        }
        if place.is_none() {
            estimate.status = Status::OutOfRange;
        } else if !self.placed && !self.place(followed, least) {
            estimate.status =
                if self.placed || self.searched > 0.0 { Status::MaxIterations } else { Status::OutOfRange };
        } else {
            let goal = self.by_way_of_turn(followed, coordinate);
            match self.spend_aside(&mut estimate, motor_angle, coordinate, visit) {
                Some(status) => estimate.status = status,
                None => self.go(&mut estimate, [goal, coordinate], visit),
            }
        }
        let older = u32::from(is_first);
        estimate.age = if estimate.status.is_trustworthy() { 0 } else { self.last.age.saturating_add(older) };
        self.last = estimate;
        estimate
    }

    /// Where a tick has time for one thing and the motion has to wait, does another: the status. `None` if the motion goes on.
    fn spend_aside(
        &mut self,
        estimate: &mut Estimate,
        motor_angle: f64,
        coordinate: f64,
        visit: Visit,
    ) -> Option<Status> {
        if self.due.is_some() {
            return None;
        }
        if self.follower.rubs() {
            return if self.looks_first(coordinate, visit) { self.look_along(estimate) } else { None };
        }
        (self.differentiates_first(coordinate) && self.move_along(estimate, motor_angle)).then_some(Status::Updating)
    }

    /// Follows to a coordinate with so many iterations.
    fn run(&mut self, coordinate: f64, budget: u32) -> Outcome {
        let settings = self.settings();
        // A tick that cannot converge makes do with the steps it has time for.
        let short = (settings.budget < CONVERGES_WITHIN).then_some(Tracking::DEFAULT);
        match settings.one_iteration.or(short) {
            Some(within) => self.follower.track(coordinate, within, budget),
            None => self.follower.follow_within(coordinate, budget),
        }
    }

    /// Follows the motion to a coordinate with the tick's iterations, by way of a goal on the way there, and reads what it finds.
    fn go(&mut self, estimate: &mut Estimate, [goal, coordinate]: [f64; 2], visit: Visit) {
        let (settings, rubs, is_first) = (self.settings(), self.follower.rubs(), visit == Visit::First);
        let before = estimate.iterations;
        let counted = |spent: u32| before.saturating_add(spent.min(u32::from(u16::MAX)) as u16);
        let supposed = if rubs { self.suppose_path(settings.budget) } else { ControlFlow::Continue(0) };
        let supposing = match supposed {
            ControlFlow::Continue(spent) => spent,
            ControlFlow::Break(spent) => {
                (estimate.status, estimate.iterations) = (Status::MaxIterations, counted(spent));
                return;
            }
        };
        let budget = settings.budget - supposing;
        // The same angle again: nothing has moved, and nothing is left to do.
        let stands = if rubs { self.rests(coordinate) } else { self.stands(coordinate) };
        self.has_rested = stands;
        let mut outcome = if stands {
            Outcome::at(self.follower.standing())
        } else {
            let reached = self.run(goal, budget);
            self.leave_turn(reached, coordinate, budget)
        };
        let is_crowded = rubs && outcome.status == Status::ContactCapacity && settings.budget > 0;
        if is_crowded && self.last.age >= CROWDED_FOR && self.follower.spare_contacts() {
            // With fewer samples from the open finger on.
            (self.placed, self.differentiated, self.settled) = (false, false, false);
        }
        if self.follower.approaches() {
            if outcome.status.is_trustworthy() {
                self.follower.arrive();
            } else if outcome.status == Status::Updating {
                // That of a finger without friction.
                outcome.status = Status::MaxIterations;
            }
        }
        // Another branch has other derivatives, and so has the other side of a hop.
        if outcome.snaps > 0 || outcome.hops > 0 {
            self.differentiated = false;
            self.jumped();
        }
        estimate.status = outcome.status;
        estimate.sensitivity_age = self.last.sensitivity_age.saturating_add(u16::from(is_first));
        let spent = supposing + outcome.iterations;
        estimate.iterations = counted(spent);
        // A tick that had to go on leaves derivatives to the next one.
        let spent = is_first.then_some(spent);
        if !stands {
            estimate.residual = outcome.gradient as f32;
            self.is_fresh = false;
            // In one-iteration mode nobody has looked at what the last step left.
            self.settled = outcome.iterations == 0 || outcome.status == Status::Converged;
        }
        let trusted = outcome.status.is_trustworthy();
        if !trusted && outcome.status != Status::Updating {
            return;
        }
        let old = *estimate;
        if rubs || !trusted || !stands {
            self.read(estimate);
        }
        if rubs {
            let aside = if trusted { self.left_aside(spent) } else { 0 };
            self.read_rubbing(estimate, aside, false);
            if estimate.force != [0.0; 2] && !self.is_at_angle() {
                // How the force changes from the finger's place to the measured angle is not known yet: the old numbers stay.
                *estimate = Estimate { status: Status::MaxIterations, iterations: estimate.iterations, ..old };
            }
        } else if trusted {
            self.differentiate(estimate, spent);
        }
    }

    /// Looks for an angle, from the measured one back, at which the open finger can begin; a bounded number per tick. Returns whether the
    /// tick has room for following from there.
    fn place(&mut self, motor_angle: f64, least: f64) -> bool {
        let budget = self.settings().budget;
        let begins = self.searched == 0.0;
        for _ in 0..budget.clamp(LEAST_CHECKS, CHECKS_PER_TICK) {
            let angle = motor_angle - self.searched;
            let place = self.drive.coordinate(angle).filter(|_| angle >= least);
            let Some([coordinate, _]) = place else {
                // Nowhere: say so once, then look again.
                self.searched = 0.0;
                return false;
            };
            if self.follower.begin(coordinate) {
                // The way from there is not the one that the contact has come.
                let at_once = self.searched == 0.0;
                if !at_once && self.follower.rubs() {
                    self.forget_path();
                    self.follower.approach();
                }
                (self.placed, self.searched) = (true, 0.0);
                return at_once || begins && budget >= CONVERGES_WITHIN;
            }
            self.searched += SEARCH_PACE;
        }
        false
    }

    /// The motor is where it was, and there the equilibrium is known: nothing is left to do.
    fn stands(&self, coordinate: f64) -> bool {
        let is_known =
            self.settled && self.last.age == 0 && self.follower.has_equilibrium() && !self.follower.remembers();
        is_known && T::of(coordinate).to_f64() == self.follower.solution().coordinate()
    }

    fn read(&self, estimate: &mut Estimate) {
        let solution = self.follower.solution();
        estimate.interval = None;
        estimate.loaded_rib = solution.loaded_rib();
        estimate.force = single(solution.force_world());
        estimate.torque = (self.ratio * solution.motor_torque().to_f64()) as f32;
        estimate.distance = solution.distance().to_f64() as f32;
        let mut centre = [T::ZERO; 2];
        let mut total = T::ZERO;
        let mut first = None;
        let mut last = T::ZERO;
        for contact in solution.contacts() {
            centre[0] += contact.force * contact.position[0];
            centre[1] += contact.force * contact.position[1];
            total += contact.force;
            first = first.or(Some(contact.arc));
            last = contact.arc;
        }
        estimate.contact_centre = [0.0; 2];
        estimate.contact_extent = 0.0;
        if let Some(first) = first
            && total > T::ZERO
        {
            estimate.contact_centre = single(solution.to_world([centre[0] / total, centre[1] / total]));
            estimate.contact_extent = (last - first).to_f64() as f32;
        }
    }
}
