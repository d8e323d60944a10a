//! A finger that holds an object, as far as measures need to know: solved along the motion, with the derivatives that they use.

use model_core::design::Design;
use model_core::discretise::DiscretiseError;
use model_core::equilibrium::Follower;
use model_core::real::Real;
use model_core::sensitivity::{Neighbours, Side};
use model_core::size::Size;
use model_core::status::Status;

use crate::case::Case;
use crate::heap::Host;
use crate::study::follow::follower;
use crate::study::model::{Options, Precision};
use crate::study::run::MOST_ITERATIONS;

/// How exactly a snap-through is placed, in the case's unit.
const SNAP: f64 = 1e-5;
/// Halvings in search of it.
const HALVINGS: usize = 28;

/// What was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Grasp {
    /// The finger.
    pub design: Design,
    /// Places of the motion in their order; nothing is known at one without a trustworthy status.
    pub places: Vec<(f64, Option<Known>)>,
    /// Where it snaps through first; `None` if it does not, or if nobody asked.
    pub snap: Option<f64>,
}

/// What is known at a place.
#[derive(Clone, Debug, PartialEq)]
pub struct Known {
    /// What is read there.
    pub numbers: Numbers,
    /// Their derivatives with each variable, per its unit; none where there is none. Only where they were asked for.
    pub slopes: Vec<Option<Numbers>>,
}

/// What measures are made of.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Numbers {
    /// Magnitude of the contact force, N.
    pub force: f64,
    /// Largest strain of beams, hinges and ribs.
    pub strain: f64,
    /// √12 σ of the contact force along the front beam, mm: the length of an evenly loaded arc that is spread as far.
    pub spread: f64,
    /// Arc between the outermost touching samples, mm.
    pub length: f64,
    /// What the force grows by per mm that the object is pushed against it, N/mm; zero without contact, and where it was not asked for.
    pub stiffness: f64,
}

impl Numbers {
    fn of<T: Real>(found: [T; 5]) -> Self {
        let [force, strain, spread, length, stiffness] = found.map(T::to_f64);
        Self { force, strain, spread, length, stiffness }
    }
}

/// What is asked beside forces, contacts and strains.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wanted<'a> {
    /// Places where the stiffness is wanted.
    pub stiffness: &'a [f64],
    /// Places where the derivatives are wanted.
    pub slopes: &'a [f64],
    /// The variables: the case with each a little less and a little more; `None` for one that makes no case.
    pub variables: &'a [Option<Line>],
    /// Whether a snap-through is to be placed.
    pub snap: bool,
}

/// A case on both sides of another one, along a variable.
#[derive(Clone, Debug)]
pub struct Line {
    /// Less and more.
    pub cases: [Case; 2],
    /// Half their distance, in the variable's unit.
    pub step: f64,
}

impl Grasp {
    /// What is known at a place.
    pub(super) fn at(&self, place: f64) -> Option<&Known> {
        self.places.iter().find(|(at, _)| *at == place).and_then(|(_, known)| known.as_ref())
    }

    /// Solves a case along its motion.
    ///
    /// # Errors
    /// If the finger cannot be discretised as asked.
    pub fn solve(case: &Case, options: &Options, wanted: Wanted<'_>) -> Result<Self, DiscretiseError> {
        match options.precision {
            Precision::F32 => solve::<f32>(case, options, wanted),
            Precision::F64 => solve::<f64>(case, options, wanted),
        }
    }
}

fn solve<T: Real>(case: &Case, options: &Options, wanted: Wanted<'_>) -> Result<Grasp, DiscretiseError> {
    Ok(walk::<T>(case, options, wanted)?.unwrap_or_else(|| Grasp {
        design: case.finger.design.clone(),
        places: case.path.places.iter().map(|&at| (at, None)).collect(),
        snap: None,
    }))
}

/// At the beginning of the motion, without contact.
fn begin<T: Real>(case: &Case, options: &Options) -> Result<Follower<T, Host>, DiscretiseError> {
    let mut follower = follower(&case.finger.design, case.object, case.path.motion, options)?;
    if let Some(&first) = case.path.places.first() {
        // A start that is not free of contact shows in the status of every place.
        follower.start(case.path.coordinate(first));
    }
    Ok(follower)
}

/// `None` if there is too little room.
fn walk<T: Real>(case: &Case, options: &Options, wanted: Wanted<'_>) -> Result<Option<Grasp>, DiscretiseError> {
    let mut follower = begin::<T>(case, options)?;
    let mut neighbours = Neighbours::EMPTY;
    let (mut places, mut snapped) = (Vec::with_capacity(case.path.places.len()), None);
    for (index, &at) in case.path.places.iter().enumerate() {
        let outcome = follower.follow_within(case.path.coordinate(at), MOST_ITERATIONS);
        if outcome.status == Status::ContactCapacity {
            return Ok(None);
        }
        if outcome.snaps > 0 || !outcome.status.is_trustworthy() {
            snapped = snapped.or(Some(index));
        }
        let known = if outcome.status.is_trustworthy() {
            let Some(known) = read(&mut follower, &mut neighbours, options, wanted, at) else { return Ok(None) };
            Some(known)
        } else {
            None
        };
        places.push((at, known));
    }
    let snap = match snapped.filter(|_| wanted.snap) {
        Some(index) => Some(place_of_snap::<T>(case, options, index)?),
        None => None,
    };
    Ok(Some(Grasp { design: case.finger.design.clone(), places, snap }))
}

/// Between the place before an index and the one there.
fn place_of_snap<T: Real>(case: &Case, options: &Options, index: usize) -> Result<f64, DiscretiseError> {
    let places = &case.path.places;
    let Some(&before) = index.checked_sub(1).and_then(|before| places.get(before)) else { return Ok(places[index]) };
    let (mut low, mut high) = (before, places[index]);
    for _ in 0..HALVINGS {
        if high - low < SNAP {
            break;
        }
        let middle = 0.5 * (low + high);
        let mut follower = begin::<T>(case, options)?;
        let mut way = places.iter().take(index).copied().chain([middle]);
        let holds = way.all(|at| {
            let outcome = follower.follow_within(case.path.coordinate(at), MOST_ITERATIONS);
            outcome.snaps == 0 && outcome.status.is_trustworthy()
        });
        if holds { low = middle } else { high = middle }
    }
    Ok(low)
}

/// What the follower has found; `None` if there is too little room for derivatives.
fn read<T: Real>(
    follower: &mut Follower<T, Host>,
    neighbours: &mut Neighbours<T, Host>,
    options: &Options,
    wanted: Wanted<'_>,
    at: f64,
) -> Option<Known> {
    let [with_stiffness, with_slopes] = [wanted.stiffness, wanted.slopes].map(|places| places.contains(&at));
    // Each touching sample takes two rows of a derivative.
    if (with_stiffness || with_slopes) && 2 * follower.solution().touching() > <Host as Size>::CONTACTS {
        return None;
    }
    let sizes = follower.solution().strains().map(|strain| strain.largest()).enumerate();
    let most_strained = sizes.fold((0, T::ZERO), |most, strain| if strain.1 > most.1 { strain } else { most });
    let numbers = |follower: &mut Follower<T, Host>| numbers(follower, most_strained.0, with_stiffness);
    let found = numbers(follower)?;
    let mut slopes = Vec::new();
    for line in wanted.variables.iter().filter(|_| with_slopes) {
        slopes.push(line.as_ref().and_then(|line| {
            let sides = line.cases.each_ref().map(|case| Side {
                design: &case.finger.design,
                object: case.object.into(),
                motion: case.path.motion,
            });
            let how = &options.discretisation;
            follower.derivative_along(neighbours, sides, how, line.step, numbers).map(Numbers::of)
        }));
    }
    Some(Known { numbers: Numbers::of(found), slopes })
}

/// Reads the [`Numbers`], of the strains that at a place of the finger.
fn numbers<T: Real>(follower: &mut Follower<T, Host>, strained: usize, with_stiffness: bool) -> Option<[T; 5]> {
    let force = follower.solution().force_world();
    let [x, y] = force;
    let size = (x * x + y * y).sqrt();
    let strain = follower.solution().strains().nth(strained).map_or(T::ZERO, |strain| strain.largest());
    let (mut whole, mut mean, mut ends) = (T::ZERO, T::ZERO, None);
    for contact in follower.solution().contacts() {
        whole += contact.force;
        mean += contact.force * contact.arc;
        let (first, _) = ends.unwrap_or((contact.arc, contact.arc));
        ends = Some((first, contact.arc));
    }
    let (first, last) = ends.unwrap_or((T::ZERO, T::ZERO));
    let (mut spread, mut stiffness) = (T::ZERO, T::ZERO);
    if whole > T::ZERO {
        mean /= whole;
        let square = |from: T| (from - mean) * (from - mean);
        let variance =
            follower.solution().contacts().fold(T::ZERO, |sum, contact| sum + contact.force * square(contact.arc));
        spread = (T::of(12.0) * variance / whole).sqrt();
    }
    if with_stiffness && size > T::ZERO {
        // Of the force with the object's place, along the force and against it.
        let [by_x, by_y] = follower.sensitivity()?.centre.map(|derivative| derivative.force);
        let along = |by: [T; 2]| x * by[0] + y * by[1];
        stiffness = -(x * along(by_x) + y * along(by_y)) / (size * size);
    }
    Some([size, strain, spread, last - first, stiffness])
}
