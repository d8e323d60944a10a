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

mod advance;
mod approach;
mod attempt;
#[cfg(test)]
mod beams;
mod begin;
mod buckling;
mod carry;
#[cfg(test)]
mod end_gaps;
mod fold;
mod hop;
mod joint;
mod meet;
#[cfg(test)]
mod memory;
mod moved;
mod neighbour;
mod parts;
mod passing;
mod peek;
mod phase;
#[cfg(test)]
mod ribs;
mod settings;
#[cfg(test)]
mod slip_capstan;
#[cfg(test)]
mod slip_elastica;
#[cfg(test)]
mod slip_history;
#[cfg(test)]
mod slip_stability;
mod spin;
mod target;
#[cfg(test)]
mod tests;
mod timeline;
mod track;

pub use buckling::Buckling;
pub use settings::Settings;
pub use target::Target;
pub use track::Tracking;

use crate::bounds::{OutOfBounds, check};
use crate::contact::ContactState;
use crate::design::Design;
use crate::discretise::{Discretisation, DiscretiseError, discretise};
use crate::model::Model;
pub use crate::newton::attempt::NEAR_ENOUGH;
use crate::newton::factored::Factored;
use crate::newton::gaps::Sweep;
use crate::newton::history::Way;
pub use crate::newton::memory::{MOST_TERMS as PRONY_TERMS, PARTS as PRONY_PARTS, TIMES as PRONY_TIMES};
use crate::newton::residual::Largest;
use crate::newton::{Hessian, Workspace};
use crate::object::{Displacement, Motion, Object, Shape};
use crate::real::{Real, Vec2, vec2};
use crate::size::Size;
use crate::state::State;
use crate::status::Status;
pub(crate) use carry::Mark;
use hop::Fall;
pub(crate) use joint::Answer;
pub(crate) use moved::Moved;
pub(crate) use parts::Parts;
use passing::Barred;
pub(crate) use peek::{Aside, Patience, Sought};
use phase::Phase;
use spin::Spin;
use timeline::Timeline;

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

impl Outcome {
    /// Nothing was done.
    pub(crate) const fn at(status: Status) -> Self {
        Self { status, iterations: 0, steps: 0, snaps: 0, hops: 0, gradient: 0.0, length: 0.0 }
    }
}

/// Newton iterations of one call of [`Follower::follow`]: a motion over many snaps takes a few thousand.
pub const FOLLOW_ITERATIONS: u32 = 20_000;
/// A way in which everything slips.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SlipWay {
    /// As after a long closing: the object pulls the finger towards its tip.
    Closing,
    /// As after a long opening.
    Opening,
}

impl SlipWay {
    /// The other way.
    pub(crate) fn other(self) -> Self {
        match self {
            Self::Closing => Self::Opening,
            Self::Opening => Self::Closing,
        }
    }

    /// Sign of the motion's coordinate.
    pub(crate) fn sign(self) -> f64 {
        match self {
            Self::Closing => 1.0,
            Self::Opening => -1.0,
        }
    }

    /// The state of a place that slips so.
    fn state(self) -> ContactState {
        match self {
            Self::Closing => ContactState::SlipUp,
            Self::Opening => ContactState::SlipDown,
        }
    }
}

/// Longest time of one step of a motor that stands, s: no bound but where shorter ones were needed.
const LONGEST_PAUSE: f64 = 1e12;
/// Smallest and largest factor of Young's modulus.
pub const MODULUS_FACTORS: [f64; 2] = [0.01, 100.0];
/// Smallest and largest coefficient of friction.
pub const FRICTIONS: [f64; 2] = [0.0, 3.0];
/// Places at which [`Follower::start`] looks for an open finger, each one evaluation of the gaps.
pub const START_CHECKS: u32 = 8192;
/// Follows a finger's equilibrium on an object: model, state and workspace.
///
/// `O` is the object's type: one of the built-in shapes unless it is named.
pub struct Follower<T: Real, S: Size, O: Object<T> = Shape<T>> {
    model: Model<T, S>,
    timeline: Timeline<T, S>,
    work: Workspace<T, S>,
    settings: Settings,
    object: O,
    pub(crate) motion: Motion,
    spin: Spin<T>,
    youngs_modulus: T,
    /// Factor of Young's modulus.
    modulus: T,
    /// The next step of the coordinate at most, and any step (see [`Self::allow_steps`]).
    step: T,
    largest_step: T,
    /// Longest time of a step of a motor that stands, s.
    pause: T,
    phase: Phase<T>,
    snapped: bool,
    /// Largest difference of an angle between the accepted state and the one whose inertia says that it is stable, rad.
    drift: T,
    factored: Factored<T, S>,
    /// Why the smallest step failed where the branch could not be followed.
    failed: Status,
    /// More touched than there is room for, and no coordinate asked for was reached since.
    crowded: bool,
    fall: Fall<T>,
    barred: Barred<T>,
    sweep: Sweep<T>,
}

impl<T: Real, S: Size, O: Object<T>> Follower<T, S, O> {
    /// Size of the states and the workspace: what changes while a motion is followed, bytes.
    pub const STATE_BYTES: usize =
        3 * size_of::<State<T, S>>() + size_of::<Workspace<T, S>>() + size_of::<Factored<T, S>>();

    /// A follower before [`Self::configure`]: every [`Self::follow`] returns `out-of-range`.
    pub const EMPTY: Self = Self {
        model: Model::EMPTY,
        timeline: Timeline::EMPTY,
        work: Workspace::EMPTY,
        // All zeros, as everything here: [`Self::configure`] puts the defaults in.
        settings: Settings::UNSET,
        object: O::BLANK,
        motion: Motion::Rotating { axis: [0.0; 2] },
        spin: Spin::NONE,
        youngs_modulus: T::ZERO,
        modulus: T::ZERO,
        step: T::ZERO,
        largest_step: T::ZERO,
        pause: T::ZERO,
        phase: Phase::Lost,
        snapped: false,
        drift: T::ZERO,
        factored: Factored::EMPTY,
        // Never read; all zeros.
        failed: Status::Converged,
        crowded: false,
        fall: Fall::NONE,
        barred: Barred::NONE,
        sweep: Sweep::NONE,
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
        let made = discretise(design, how, &mut self.model);
        let fits = made.is_ok() && self.fit();
        if !fits {
            self.model.reset(0);
            return made.and(Err(DiscretiseError::Capacity));
        }
        self.motion = Motion::Rotating { axis: design.motor_axis };
        self.youngs_modulus = T::of(design.material.youngs_modulus);
        if self.modulus == T::ZERO {
            self.modulus = T::one();
        }
        self.model.sudden = (self.model.units.force, self.model.softness);
        self.model.stiffen(self.work.history.memory.stiffness(), self.modulus);
        self.refine();
        self.rest();
        Ok(())
    }

    /// Makes room for the model; false if there is none.
    fn fit(&mut self) -> bool {
        self.timeline.fit(&self.model) && self.work.fit(&self.model) && self.factored.fit(&self.model)
    }

    /// Changes how equilibria are followed.
    ///
    /// # Errors
    /// The first value that is not allowed; the old settings then stay.
    pub fn set_settings(&mut self, settings: Settings) -> Result<(), OutOfBounds> {
        settings.validate()?;
        self.settings = settings;
        self.factored.is_near = false;
        self.allow_steps();
        Ok(())
    }

    /// Follows with the settings that suit a second derivative, [`Settings::of`].
    pub fn set_hessian(&mut self, hessian: Hessian) {
        self.settings = Settings::of(hessian);
        self.factored.is_near = false;
        self.allow_steps();
    }

    /// Sets [`Settings::resolves_contact`].
    pub fn resolve_contact(&mut self, resolves: bool) {
        self.settings.resolves_contact = resolves;
    }

    /// Takes an object and the motion between finger and object; the finger is at rest again.
    pub fn set_object(&mut self, object: impl Into<O>, motion: Motion) {
        self.object = object.into();
        self.motion = motion;
        self.timeline.unmark();
        self.refine();
        self.rest();
    }

    /// The undeformed finger, as if the object were far away.
    #[inline(never)]
    pub fn rest(&mut self) {
        if self.model.cells() == 0 {
            return;
        }
        self.timeline.rest();
        self.phase = Phase::Following;
        self.snapped = false;
        (self.drift, self.fall, self.factored.is_near) = (T::ZERO, Fall::NONE, false);
        (self.barred, self.sweep, self.crowded) = (Barred::NONE, Sweep::NONE, false);
        self.work.history.slip.is_idle = false;
        self.allow_steps();
        self.work.contacts.count = 0;
        self.pause = T::of(LONGEST_PAUSE);
        if self.remembers() {
            self.work.history.memory.begin();
        }
        // The last step's unit may be one of a relaxed material, which this one need not be.
        self.stiffen();
        self.work.kinematics.place_all(&self.model, &self.work.history.memory, &self.timeline.present, &[]);
        self.work.history.begin(&self.model, &self.timeline.present, &self.work.kinematics);
    }

    /// Takes a coefficient of friction between finger and object; the finger is at rest again. Zero, the default, leaves friction out.
    ///
    /// With friction the force depends on the path: on where the hand was open last and how it has moved since.
    ///
    /// # Errors
    /// A coefficient that is not within [`FRICTIONS`], and any but zero where [`Size::RUBS`] is false.
    pub fn set_friction(&mut self, coefficient: f64) -> Result<(), OutOfBounds> {
        check("friction", coefficient, if S::RUBS { FRICTIONS } else { [0.0; 2] })?;
        self.work.history.slip.coefficient = T::of(coefficient);
        self.timeline.unmark();
        self.refine();
        self.rest();
        Ok(())
    }

    /// Lets the object turn about a point of the world by so many rad per unit of the motion's coordinate (rad or mm), counter-clockwise; 0, the
    /// default, for one that does not turn. It is the same wherever it has turned: a cylinder, about its axis. Only friction feels it.
    ///
    /// # Errors
    /// A point or a rate that is not within ±1000.
    pub fn spin_object(&mut self, about: [f64; 2], rate: f64) -> Result<(), OutOfBounds> {
        for (name, value) in [("spin.about", about[0]), ("spin.about", about[1]), ("spin.rate", rate)] {
            check(name, value, [-1e3, 1e3])?;
        }
        self.spin = Spin { about: about.map(T::of), rate: T::of(rate) };
        Ok(())
    }

    /// Lets everything that touches slip one way, whatever the past; the finger is at rest again. `None`, the default, lets the past decide.
    ///
    /// Where the past is unknown, the finger is between the two: normal force and torque lie between those of both ways.
    pub fn force_slip(&mut self, way: Option<SlipWay>) {
        self.work.history.slip.forced = way.map_or(ContactState::Open, SlipWay::state);
        self.timeline.unmark();
        self.rest();
    }

    /// Tells the history what a step from the accepted state to a coordinate goes through.
    fn aim(&mut self, coordinate: T) {
        self.aim_past(coordinate, &self.spin.moved(coordinate - self.timeline.at()));
    }

    /// The same with an object that moves.
    fn aim_past(&mut self, coordinate: T, moved: &Moved<T>) {
        if self.work.history.is_kept() {
            let way = coordinate - self.timeline.at();
            let by = self.motion.world_to_finger(way);
            let (by, turned) = match self.motion {
                // What adds up from step to step must not be a difference of places.
                Motion::Rotating { axis } => (Displacement { translation: Vec2::zeros(), ..by }.about(vec2(axis)), way),
                Motion::Translating { .. } => (by, T::ZERO),
            };
            let here = self.motion.world_to_finger(self.timeline.at());
            let (by, turned) = moved.before(&here, &by, turned);
            let way = Way { by, turned, seconds: self.timeline.taken() };
            self.work.history.aim(&self.model, &self.timeline.accepted, &way);
            self.stiffen();
        }
    }

    /// Computes in the unit of force of the step that the history is aimed at.
    fn stiffen(&mut self) {
        let part = self.model.stiffen(self.work.history.memory.stiffness(), self.modulus);
        if part != T::one() {
            self.timeline.express(part, &self.model);
            self.work.history.slip.express(part);
            self.fall.express(part);
        }
    }

    /// The material remembers.
    #[inline(always)]
    pub(crate) fn remembers(&self) -> bool {
        self.work.history.memory.is_kept()
    }

    /// Takes the terms [gᵢ, τᵢ in s] of a material with memory: of a sudden stress the part gᵢ fades in the time τᵢ, in bending, stretch and
    /// shear alike, and 1 − Σ gᵢ stays. None, the default, is an elastic material. The finger is at rest again.
    ///
    /// Young's modulus is that of a sudden strain. Time comes with the [`Target`]s; a call without one is sudden.
    ///
    /// # Errors
    /// More terms than [`Size::TERMS`], and values out of [`PRONY_PARTS`] and [`PRONY_TIMES`], which Σ gᵢ must not exceed either.
    pub fn set_prony(&mut self, terms: &[[f64; 2]]) -> Result<(), OutOfBounds> {
        self.work.history.memory.set(terms)?;
        if !self.work.history.fit(&self.model) {
            let most = self.work.history.memory.most_nodes();
            check("nodes of a material with memory", self.model.node_count as f64, [0.0, most])?;
        }
        self.timeline.unmark();
        self.rest();
        Ok(())
    }

    /// Multiplies Young's modulus, as a change of temperature does; 1 by default. What is strained already has the new modulus at once.
    ///
    /// # Errors
    /// A factor that is not within [`MODULUS_FACTORS`].
    pub fn set_modulus_factor(&mut self, factor: f64) -> Result<(), OutOfBounds> {
        check("modulus factor", factor, MODULUS_FACTORS)?;
        self.modulus = T::of(factor);
        self.factored.is_near = false;
        if self.model.cells() > 0 {
            // Strains stay, so that forces are the same in the new unit; but a given load is as it was.
            let part = self.model.stiffen(self.work.history.memory.stiffness(), self.modulus);
            self.timeline.reload(part);
        }
        Ok(())
    }

    /// The present state, which the workspace shows, is about to be accepted: what is remembered goes on from there.
    fn remember(&mut self) {
        let Workspace { kinematics, contacts, history, .. } = &mut self.work;
        history.accept(&self.model, &self.timeline.present, &self.timeline.accepted, kinematics, contacts);
    }

    /// Puts a dead load (finger frame, N) on the front beam where lamella `lamella` is joined (from 0; any larger number
    /// is the tip), from the next [`Self::follow`] on; [`Self::rest`] takes it away.
    ///
    /// For tests of the model and for stiffness figures; increase it in steps, as the load itself is not followed.
    pub fn set_dead_load(&mut self, lamella: usize, load: [f64; 2]) {
        let unit = self.model.units.force;
        self.timeline.present.load = load.map(|force| T::of(force) / unit);
        self.timeline.present.load_cell = lamella.min(self.model.cells().saturating_sub(1));
        (self.timeline.accepted.load, self.timeline.accepted.load_cell) =
            (self.timeline.present.load, self.timeline.present.load_cell);
    }

    /// Reports residuals in N·mm and mm.
    fn note(&self, residual: &Largest<T>, outcome: &mut Outcome) {
        let units = &self.model.units;
        outcome.gradient = (residual.gradient * units.moment()).to_f64();
        outcome.length = (residual.length * units.length).to_f64();
    }

    /// Follows the equilibrium to a coordinate (rad or mm), with at most [`FOLLOW_ITERATIONS`] Newton iterations; to a [`Target`] where the
    /// time on the way matters.
    pub fn follow(&mut self, to: impl Into<Target>) -> Outcome {
        self.follow_within(to, FOLLOW_ITERATIONS)
    }

    /// Brings the workspace, which results are read from, back to the accepted state.
    #[inline(never)]
    pub(crate) fn show_accepted(&mut self) {
        self.reject();
        self.aim(self.timeline.at());
        let object = self.seen(self.timeline.at());
        (_, self.sweep) = self.work.evaluate(&self.model, &self.timeline.present, &object, T::ZERO);
    }

    /// Goes back to the accepted state; what was factorised is of another one.
    fn reject(&mut self) {
        self.timeline.reject(&self.model);
        self.factored.is_near = false;
    }

    /// Completes the workspace with the second derivatives at the accepted state, if the last evaluation did without them.
    /// A material with memory answers as to a sudden change.
    pub(crate) fn complete_tangent(&mut self) {
        if self.work.kinematics.lacks_tangent || self.remembers() {
            self.show_accepted();
        }
    }

    pub(crate) fn standing(&self) -> Status {
        if self.phase == Phase::Lost || self.barred.way != 0 || !self.base_is_free(self.timeline.at()) {
            Status::OutOfRange
        } else if self.timeline.present.touching_count == 0 {
            Status::NoContact
        } else if self.snapped {
            Status::Snapped
        } else {
            Status::Converged
        }
    }
}
