//! A finger that holds an object, as far as measures need to know: solved along the motion, with the derivatives that they use.

use model_core::design::Design;
use model_core::discretise::DiscretiseError;
use model_core::equilibrium::Follower;
use model_core::object::{Motion, ObjectDesign};
use model_core::real::Real;
use model_core::sensitivity::{Derivative, Probe, Sensitivity};
use model_core::size::Size;
use model_core::status::Status;

use crate::case::Case;
use crate::heap::{Host, Wide};
use crate::study::follow::follower;
use crate::study::model::{Options, Precision};
use crate::study::run::MOST_ITERATIONS;

/// How exactly a snap-through is placed, in the case's unit.
const SNAP: f64 = 1e-4;
/// Halvings in search of it.
const HALVINGS: usize = 24;

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
    /// Force on the object, world frame, N.
    pub force: [f64; 2],
    /// Touching samples, base to tip: arc along the front beam, mm, and force, N.
    pub contacts: Vec<[f64; 2]>,
    /// Largest strain of beams and hinges.
    pub strain: f64,
    /// dF/dC of the object's place C, N/mm: row i is the derivative of the i-th component. Only where it was asked for.
    pub stiffness: Option<[[f64; 2]; 2]>,
    /// Derivative of the force with each variable, N per its unit; none where there is none. Only where they were asked for.
    pub slopes: Vec<Option<[f64; 2]>>,
}

impl Known {
    /// Magnitude of the force, N.
    pub fn size(&self) -> f64 {
        self.force[0].hypot(self.force[1])
    }
}

/// What is asked beside forces, contacts and strains.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wanted<'a> {
    /// Places where the object's stiffness is wanted.
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

/// Begins again with more room if more samples touch than usual.
fn solve<T: Real>(case: &Case, options: &Options, wanted: Wanted<'_>) -> Result<Grasp, DiscretiseError> {
    match walk::<T, Host>(case, options, wanted)? {
        Some(grasp) => Ok(grasp),
        None => Ok(walk::<T, Wide>(case, options, wanted)?.unwrap_or_else(|| Grasp {
            design: case.finger.design.clone(),
            places: case.path.places.iter().map(|&at| (at, None)).collect(),
            snap: None,
        })),
    }
}

/// At the beginning of the motion, without contact.
fn begin<T: Real, S: Size>(case: &Case, options: &Options) -> Result<Follower<T, S>, DiscretiseError> {
    let mut follower = follower(&case.finger.design, case.object, case.path.motion, options)?;
    if let Some(&first) = case.path.places.first() {
        // A start that is not free of contact shows in the status of every place.
        follower.start(case.path.coordinate(first));
    }
    Ok(follower)
}

/// `None` if there is too little room.
fn walk<T: Real, S: Size>(
    case: &Case,
    options: &Options,
    wanted: Wanted<'_>,
) -> Result<Option<Grasp>, DiscretiseError> {
    let mut follower = begin::<T, S>(case, options)?;
    let mut probe = Probe::EMPTY;
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
            let Some(known) = read(&mut follower, &mut probe, case, options, wanted, at) else { return Ok(None) };
            Some(known)
        } else {
            None
        };
        places.push((at, known));
    }
    let snap = match snapped.filter(|_| wanted.snap) {
        Some(index) => Some(place_of_snap::<T, S>(case, options, index)?),
        None => None,
    };
    Ok(Some(Grasp { design: case.finger.design.clone(), places, snap }))
}

/// Between the place before an index and the one there.
fn place_of_snap<T: Real, S: Size>(case: &Case, options: &Options, index: usize) -> Result<f64, DiscretiseError> {
    let places = &case.path.places;
    let Some(&before) = index.checked_sub(1).and_then(|before| places.get(before)) else { return Ok(places[index]) };
    let (mut low, mut high) = (before, places[index]);
    for _ in 0..HALVINGS {
        if high - low < SNAP {
            break;
        }
        let middle = 0.5 * (low + high);
        let mut follower = begin::<T, S>(case, options)?;
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
fn read<T: Real, S: Size>(
    follower: &mut Follower<T, S>,
    probe: &mut Probe<T, S>,
    case: &Case,
    options: &Options,
    wanted: Wanted<'_>,
    at: f64,
) -> Option<Known> {
    let [wants_stiffness, wants_slopes] = [wanted.stiffness, wanted.slopes].map(|places| places.contains(&at));
    let found = if wants_stiffness || wants_slopes { Some(follower.sensitivity()?) } else { None };
    let stiffness = found.filter(|_| wants_stiffness).map(|found| {
        let [x, y] = found.centre.map(|derivative| derivative.force.map(T::to_f64));
        [[x[0], y[0]], [x[1], y[1]]]
    });
    let mut slopes = Vec::new();
    if let Some(found) = found.filter(|_| wants_slopes) {
        for line in wanted.variables {
            slopes.push(line.as_ref().and_then(|line| slope(follower, probe, &found, case, options, line)));
        }
    }
    Some(Known {
        force: follower.force_world().map(T::to_f64),
        contacts: follower.contacts().map(|contact| [contact.arc.to_f64(), contact.force.to_f64()]).collect(),
        strain: follower.max_strain().map(T::to_f64).into_iter().fold(0.0, f64::max),
        stiffness,
        slopes,
    })
}

/// Derivative of the force along a variable: that of the design, of the motor axis and of the object, whichever it moves. `None` for
/// an object's shape, or where the model changes its size.
fn slope<T: Real, S: Size>(
    follower: &mut Follower<T, S>,
    probe: &mut Probe<T, S>,
    found: &Sensitivity<T>,
    case: &Case,
    options: &Options,
    line: &Line,
) -> Option<[f64; 2]> {
    let [below, above] = &line.cases;
    let rate = |below: f64, above: f64| 0.5 * (above - below) / line.step;
    let rates = |below: [f64; 2], above: [f64; 2]| [rate(below[0], above[0]), rate(below[1], above[1])];
    let mut sum = [0.0; 2];
    let mut add = |derivative: &Derivative<T>, part: f64| {
        for (sum, force) in sum.iter_mut().zip(derivative.force) {
            *sum += part * force.to_f64();
        }
    };
    let axis = match (below.path.motion, above.path.motion) {
        (Motion::Rotating { axis: below }, Motion::Rotating { axis: above }) => rates(below, above),
        (below, above) if below == above => [0.0; 2],
        _ => return None,
    };
    let (shift, growth) = change(below.object, above.object, rate)?;
    for i in 0..2 {
        add(&found.axis[i], axis[i]);
        add(&found.centre[i], shift[i]);
    }
    add(&found.radius, growth);
    // The motor axis belongs to the motion.
    let designs = [&below.finger.design, &above.finger.design];
    if designs.iter().any(|design| **design != (Design { motor_axis: design.motor_axis, ..case.finger.design.clone() }))
    {
        add(&follower.design_derivative(probe, designs, &options.discretisation, line.step)?, 1.0);
    }
    Some(sum)
}

/// How fast an object moves and grows; `None` if its shape changes.
fn change(below: ObjectDesign, above: ObjectDesign, rate: impl Fn(f64, f64) -> f64) -> Option<([f64; 2], f64)> {
    use ObjectDesign::{Bore, Circle, Ellipse, HalfPlane};
    let rates = |below: [f64; 2], above: [f64; 2]| [0, 1].map(|i| rate(below[i], above[i]));
    match (below, above) {
        _ if below == above => Some(([0.0; 2], 0.0)),
        (Circle { centre: a, radius: r }, Circle { centre: b, radius: q }) => Some((rates(a, b), rate(r, q))),
        // Its surface is on the other side.
        (Bore { centre: a, radius: r }, Bore { centre: b, radius: q }) => Some((rates(a, b), rate(q, r))),
        (Ellipse { centre: a, semi_axes, angle }, Ellipse { centre: b, semi_axes: other_axes, angle: other_angle })
            if semi_axes == other_axes && angle == other_angle =>
        {
            Some((rates(a, b), 0.0))
        }
        (HalfPlane { point: a, normal }, HalfPlane { point: b, normal: other }) if normal == other => {
            Some((rates(a, b), 0.0))
        }
        _ => None,
    }
}
