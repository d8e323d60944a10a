//! A case solved: one equilibrium per place of its motion, reached by continuation from no contact.

use std::convert::Infallible;
use std::ops::ControlFlow;
use std::time::Instant;

use model_core::discretise::DiscretiseError;
use model_core::equilibrium::{Follower, Outcome, Target};
use model_core::real::Real;
use model_core::sensitivity::Probe;
use model_core::solution::NEAR_BUCKLING;
use model_core::status::Status;

use crate::case::{Case, Memory};
use crate::heap::Host;
use crate::shape::Shape;
use crate::study::branch::{self, FirstBranch, Found};
use crate::study::fade::Fade;
use crate::study::follow::follower;
use crate::study::friction::{ForceInterval, Friction};
use crate::study::model::{Model, Options, Precision};
use crate::study::overlap;
use crate::study::place::{At, Effort, MaxStrain, Place, State};
use crate::study::pressure::pressures;
use crate::study::self_contact;
use crate::study::sensitivity::sensitivity;
use crate::study::strains::{Limit, Strains};
use crate::study::warnings::{Warning, warnings};

/// Newton iterations allowed between two places: several times what a motion with a snap-through takes.
pub(crate) const MOST_ITERATIONS: u32 = 10_000;

/// The longest way, degrees or mm, on which a force is taken to change evenly as it fades (test `places_between`), and the most of them between
/// two places.
const FADES_WITHIN: f64 = 0.5;
const MOST_FADES: f64 = 1000.0;

/// A case solved along its motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// The model.
    pub model: Model,
    /// How far the first branch reaches; `None` if not even the first place has a trustworthy status.
    pub first_branch: Option<FirstBranch>,
    /// What a designer must not overlook.
    pub warnings: Vec<Warning>,
    /// One result per place, in the case's order.
    pub places: Vec<Place>,
}

impl Run {
    /// True if every place has a trustworthy status.
    pub fn is_trustworthy(&self) -> bool {
        self.places.iter().all(|place| place.status.is_trustworthy())
    }

    /// Index of the last place with a state.
    pub fn last_known(&self) -> Option<usize> {
        self.places.iter().rposition(|place| place.state.is_some())
    }

    /// Time of all places, s.
    pub fn seconds(&self) -> f64 {
        self.places.iter().map(|place| 1e-6 * place.effort.elapsed_us).sum()
    }

    /// The run with one of its places only; `None` if it has no such place.
    pub fn only(&self, index: usize) -> Option<Self> {
        let place = self.places.get(index)?.clone();
        let warnings = self.warnings_at(place.at).copied().collect();
        Some(Self { model: self.model, first_branch: self.first_branch, warnings, places: vec![place] })
    }

    /// The warnings about the finger and those that speak of a place.
    pub fn warnings_at(&self, at: At) -> impl Iterator<Item = &Warning> {
        self.warnings.iter().filter(move |warning| warning.at().is_none_or(|of| of == at))
    }
}

/// How far a case is solved.
#[derive(Clone, Copy, Debug)]
pub struct Progress<'p> {
    /// Places that are done.
    pub done: usize,
    /// All places.
    pub total: usize,
    /// The latest one, without its branch and its overlap, which are known at the end.
    pub latest: &'p Place,
}

/// Why a watched case has no results; `B` is what the watcher stops it with.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Unsolved<B> {
    /// The finger cannot be discretised as asked.
    #[error(transparent)]
    Discretise(#[from] DiscretiseError),
    /// The watcher stopped it.
    #[error("stopped")]
    Stopped(B),
}

/// Solves a case. The path begins without contact and leads through the places one after the other, so results after a turn of
/// the motion are those of the opening hand.
///
/// # Errors
/// If the finger cannot be discretised as asked.
pub fn solve(case: &Case, options: &Options) -> Result<Run, DiscretiseError> {
    solve_watched(case, options, |_| ControlFlow::<Infallible>::Continue(())).map_err(|error| match error {
        Unsolved::Discretise(error) => error,
        Unsolved::Stopped(never) => match never {},
    })
}

/// As [`solve`], calling `watch` after every place; it stops the work by [`ControlFlow::Break`].
///
/// # Errors
/// If the finger cannot be discretised as asked, or the work was stopped.
pub fn solve_watched<B>(
    case: &Case,
    options: &Options,
    mut watch: impl FnMut(Progress<'_>) -> ControlFlow<B>,
) -> Result<Run, Unsolved<B>> {
    match options.precision {
        Precision::F32 => solve_in::<f32, B>(case, options, &mut watch),
        Precision::F64 => solve_in::<f64, B>(case, options, &mut watch),
    }
}

/// What a caller does after every place.
type Watch<'w, B> = &'w mut dyn FnMut(Progress<'_>) -> ControlFlow<B>;

/// A follower at the beginning of the path, without contact.
fn begin<T: Real>(case: &Case, options: &Options) -> Result<Follower<T, Host>, DiscretiseError> {
    let mut follower = follower(&case.finger.design, case.object, case.path.motion, options)?;
    // A case's coefficient and terms are within their ranges, and the sizes on a heap have room.
    let _ = follower.set_friction(case.friction);
    if case.finger.memory == Memory::Nodes {
        let _ = follower.set_prony(&case.finger.prony);
    }
    if let Some(&first) = case.path.places.first() {
        // A start that is not free of contact shows in the status of every place.
        follower.start(case.path.coordinate(first));
    }
    Ok(follower)
}

/// A case on its way: it goes wherever it is sent, from where it is.
pub struct Walk<T: Real> {
    case: Case,
    options: Options,
    follower: Follower<T, Host>,
    /// With friction: followers on which everything slips as while closing, and as while opening.
    bounds: Option<[Box<Follower<T, Host>>; 2]>,
    /// What fades, of a material that remembers by its force alone.
    fade: Option<Fade>,
    probe: Probe<T, Host>,
    samples: Vec<f64>,
    model: Model,
}

impl<T: Real> Walk<T> {
    /// At the beginning of the case's path, without contact.
    ///
    /// # Errors
    /// If the finger cannot be discretised as asked.
    pub fn begin(case: &Case, options: &Options) -> Result<Self, DiscretiseError> {
        let follower = begin::<T>(case, options)?;
        let samples = follower.sample_arcs().map(T::to_f64).collect();
        let model = Model::of(case, options, follower.unknowns());
        let bounds = (case.friction > 0.0).then(|| bounds(case, options)).transpose()?;
        let (case, options, fade) = (case.clone(), *options, Fade::of(case));
        Ok(Self { case, options, follower, bounds, fade, probe: Probe::EMPTY, samples, model })
    }

    /// The model.
    pub fn model(&self) -> Model {
        self.model
    }

    /// Where it is: a motor angle (degrees) or distance (mm).
    pub fn at(&self) -> f64 {
        self.case.path.place(self.follower.solution().coordinate())
    }

    /// Goes to a motor angle (degrees) or distance (mm) within a time, s. The place has no branch yet; the number is that of the
    /// snap-throughs on the way.
    pub fn go(&mut self, value: f64, seconds: f64) -> (Place, u32) {
        let begin = Instant::now();
        let target = Target { coordinate: self.case.path.coordinate(value), time_step_s: seconds };
        let (outcome, last_s) = self.follow(value, seconds);
        let elapsed_us = begin.elapsed().as_secs_f64() * 1e6;
        let known = outcome.status.is_trustworthy();
        let mut state =
            known.then(|| state(&mut self.follower, &mut self.probe, &self.case, &self.options, &self.samples));
        let interval = self.interval(target, outcome.status);
        if let Some(state) = &mut state {
            state.force_interval = interval;
            // Last: it is asked of a factorisation, which the next step makes anew.
            state.buckling = self.follower.buckling(NEAR_BUCKLING);
        }
        let mut place = Place {
            at: At::new(self.case.path.along(), value),
            time_s: None,
            status: outcome.status,
            effort: Effort {
                iterations: outcome.iterations,
                steps: outcome.steps,
                elapsed_us: (elapsed_us * 10.0).round() / 10.0,
            },
            branch: None,
            overlap_mm: None,
            state,
        };
        if let Some(fade) = &mut self.fade {
            fade.take(&mut place, last_s);
        }
        (place, outcome.snaps)
    }

    /// Follows the equilibrium there, and how long the last step on the way took: a material that remembers by its force alone goes through
    /// what lies between, in short steps.
    fn follow(&mut self, value: f64, seconds: f64) -> (Outcome, f64) {
        let from = self.at();
        let steps = match self.fade {
            Some(_) => ((value - from).abs() / FADES_WITHIN).ceil().clamp(1.0, MOST_FADES),
            None => 1.0,
        };
        let time_step_s = seconds / steps;
        let target = |place: f64| Target { coordinate: self.case.path.coordinate(place), time_step_s };
        let (mut iterations, mut taken, mut snaps) = (0, 0, 0);
        for step in 1..steps as usize {
            let on_the_way = target(from + (value - from) * step as f64 / steps);
            let outcome = self.follower.follow_within(on_the_way, MOST_ITERATIONS);
            (iterations, taken, snaps) =
                (iterations + outcome.iterations, taken + outcome.steps, snaps + outcome.snaps);
            if let Some(fade) = &mut self.fade {
                let solution = self.follower.solution();
                let normal = solution.contacts().map(|contact| contact.force.to_f64()).sum();
                let found = (solution.force_world().map(T::to_f64), normal, solution.motor_torque().to_f64());
                fade.pass(outcome.status.is_trustworthy().then_some(found), time_step_s);
            }
        }
        let last = self.follower.follow_within(target(value), MOST_ITERATIONS);
        let outcome = Outcome {
            iterations: iterations + last.iterations,
            steps: taken + last.steps,
            snaps: snaps + last.snaps,
            ..last
        };
        (outcome, time_step_s)
    }
}

impl<T: Real> Walk<T> {
    /// What the forces at a place lie between if the path is unknown. `None` where a bound is on another branch than the case, which has this
    /// status: it says nothing about it.
    fn interval(&mut self, target: Target, own: Status) -> Option<ForceInterval> {
        let bounds = self.bounds.as_mut()?;
        let found = bounds.each_mut().map(|follower| follower.follow_within(target, MOST_ITERATIONS).status);
        let has_snapped = |status| status == Status::Snapped;
        let is_alike = |status: &Status| status.is_trustworthy() && has_snapped(*status) == has_snapped(own);
        let [closing, opening] = &*bounds;
        found.iter().all(is_alike).then(|| ForceInterval::over([&self.follower, closing, opening]))
    }
}

/// Followers at the beginning of the path on which everything slips one way.
fn bounds<T: Real>(case: &Case, options: &Options) -> Result<[Box<Follower<T, Host>>; 2], DiscretiseError> {
    let one = |way| -> Result<_, DiscretiseError> {
        let mut follower = Box::new(begin::<T>(case, options)?);
        follower.force_slip(Some(way));
        if let Some(&first) = case.path.places.first() {
            follower.start(case.path.coordinate(first));
        }
        Ok(follower)
    };
    let [closing, opening] = ForceInterval::WAYS.map(one);
    Ok([closing?, opening?])
}

fn solve_in<T: Real, B>(case: &Case, options: &Options, watch: Watch<'_, B>) -> Result<Run, Unsolved<B>> {
    let mut walk = Walk::<T>::begin(case, options)?;
    let total = case.path.places.len();
    let (mut places, mut found) = (Vec::with_capacity(total), Vec::with_capacity(total));
    let (seconds, times) = (case.path.time_steps(walk.at()), case.path.times());
    for (index, (&value, seconds)) in case.path.places.iter().zip(seconds).enumerate() {
        let (mut place, snaps) = walk.go(value, seconds);
        place.time_s = times.as_ref().and_then(|times| times.get(index)).copied();
        found.push(Found {
            place: value,
            seconds,
            status: place.status,
            snaps,
            force: place.force_magnitude_n(),
            slope: place.state.as_ref().and_then(State::force_slope),
        });
        places.push(place);
        if let Some(latest) = places.last() {
            let done = places.len();
            if let ControlFlow::Break(with) = watch(Progress { done, total, latest }) {
                return Err(Unsolved::Stopped(with));
            }
        }
    }
    let again = || begin::<T>(case, options).ok();
    let first_branch = branch::first_branch(&case.path, &found, again, MOST_ITERATIONS);
    for (place, branch) in places.iter_mut().zip(branch::branches(&found)) {
        place.branch = branch;
        place.overlap_mm = overlap::depth(case, place);
    }
    Ok(Run { model: walk.model(), first_branch, warnings: warnings(case, options, &places), places })
}

/// What a follower has found at its place.
fn state<T: Real>(
    follower: &mut Follower<T, Host>,
    probe: &mut Probe<T, Host>,
    case: &Case,
    options: &Options,
    samples: &[f64],
) -> State {
    let solution = follower.solution();
    // Adding zero turns −0 into 0.
    let number = |value: T| value.to_f64() + 0.0;
    let shape = Shape::of(follower);
    let strains = Strains::of(follower);
    let self_contact = self_contact::deepest(&case.finger.design, &shape);
    let [front, back, hinge, rib] = solution.max_strain().map(T::to_f64);
    State {
        force_n: solution.force_world().map(number),
        force_finger_frame_n: solution.force_finger().map(number),
        motor_torque_nmm: number(solution.motor_torque()),
        energy_nmm: case.finger.prony.is_empty().then(|| number(solution.energy())),
        gap_mm: number(solution.distance()),
        tip_mm: solution.tip().map(number),
        contact_pressure: pressures(&case.finger.design, samples, &shape.contacts),
        shape,
        max_strain: MaxStrain { front, back, hinge, rib },
        beyond_max_strain: strains.beyond(Limit::of(case.finger.max_strain)),
        strains,
        self_contact,
        buckling: None,
        friction: (case.friction > 0.0).then(|| Friction::of(follower)),
        force_interval: None,
        sensitivity: if case.finger.prony.is_empty() { sensitivity(follower, probe, case, options) } else { None },
    }
}
