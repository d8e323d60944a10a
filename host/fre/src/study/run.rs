//! Runs a case: one equilibrium per place of its motion, reached by continuation from no contact.

use std::time::Instant;

use model_core::discretise::{Discretisation, DiscretiseError, Elements, Physics, Scheme};
use model_core::equilibrium::Follower;
use model_core::newton::Hessian;
use model_core::object::Motion;
use model_core::real::Real;
use model_core::sensitivity::{Derivative, DesignParameter, Probe};
use model_core::size::Size;
use model_core::status::Status;
use serde::{Deserialize, Serialize};

use crate::case::Case;
use crate::heap::{Host, Wide};
use crate::shape::{Contact, Shape};
use crate::study::branch::{self, FirstBranch, Found};
use crate::study::overlap;
use crate::study::pressure::{Pressure, pressures};
use crate::study::strains::{Beyond, Strains};

/// Newton iterations allowed between two places: several times what a motion with a snap-through takes.
const MOST_ITERATIONS: u32 = 10_000;

/// Floating-point precision of the solver.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Precision {
    /// Single, as on the microcontroller.
    F32,
    /// Double.
    #[default]
    F64,
}

impl Precision {
    /// The word in files and options.
    pub fn word(self) -> &'static str {
        match self {
            Self::F32 => "f32",
            Self::F64 => "f64",
        }
    }
}

/// How a case is solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Scheme, elements, samples, softness and physics.
    pub discretisation: Discretisation,
    /// Second derivative of the Newton step.
    pub hessian: Hessian,
    /// Precision.
    pub precision: Precision,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            discretisation: Discretisation::fine(Physics::Extended),
            hessian: Hessian::default(),
            precision: Precision::default(),
        }
    }
}

/// The model that made a result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Model {
    /// `paper`, `trapezoid` or `simpson`.
    pub scheme: String,
    /// Elements of each beam.
    pub elements_per_beam: u32,
    /// Elements of each hinge.
    pub elements_per_hinge: u32,
    /// Angles and stretches.
    pub unknowns: usize,
    /// `paper` or `extended`.
    pub physics: String,
    /// Precision.
    pub precision: Precision,
}

/// Largest strains (bending plus stretch, at the outer fibre).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MaxStrain {
    /// In the front beam.
    pub front: f64,
    /// In the back beam.
    pub back: f64,
    /// In the hinges.
    pub hinge: f64,
}

/// Derivatives, world frame, the touching samples staying the same: of the force on the object, of the torque that the
/// contact demands of the motor, and of the contact centre.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sensitivity {
    /// Of the force to the motor angle, N per degree; absent for a translated base.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force_per_deg_n: Option<[f64; 2]>,
    /// To the distance, N per mm, of a translated base.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force_per_mm_n: Option<[f64; 2]>,
    /// To the x and the y of the object's centre, N per mm.
    pub force_per_centre_mm_n: [[f64; 2]; 2],
    /// To the object's radius, N per mm.
    pub force_per_radius_mm_n: [f64; 2],
    /// To Young's modulus, N per MPa, the contact softness staying the same.
    pub force_per_youngs_modulus_mpa_n: [f64; 2],
    /// To the front beam's thickness, N per mm; `null` where the dimension cannot be varied.
    pub force_per_front_thickness_mm_n: Option<[f64; 2]>,
    /// To the back beam's thickness, N per mm.
    pub force_per_back_thickness_mm_n: Option<[f64; 2]>,
    /// To the hinges' thickness, N per mm.
    pub force_per_hinge_thickness_mm_n: Option<[f64; 2]>,
    /// To the hinges' length, N per mm.
    pub force_per_hinge_length_mm_n: Option<[f64; 2]>,
    /// To the x and the y of the motor axis, N per mm.
    pub force_per_motor_axis_mm_n: [[f64; 2]; 2],
    /// Stiffness dF/dC that the object meets, N/mm: row i, column j is the change of the i-th component of the force by the
    /// object's j-th. Where the finger pushes the object back, it is negative definite.
    pub stiffness_n_per_mm: [[f64; 2]; 2],
    /// Of the torque to the motor angle, N·mm per degree; absent for a translated base.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torque_per_deg_nmm: Option<f64>,
    /// Of the torque to the x and the y of the object's centre, N·mm per mm (of a translated base: of the force against its
    /// motion, N per mm).
    pub torque_per_centre_mm_nmm: [f64; 2],
    /// To the object's radius.
    pub torque_per_radius_mm_nmm: f64,
    /// Of the contact centre to the motor angle, mm per degree; absent for a translated base.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contact_centre_per_deg_mm: Option<[f64; 2]>,
}

/// The result at one place of a motion. Without a trustworthy status the numbers are absent and the lists empty.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Solution {
    /// Whether the numbers may be used.
    pub status: Status,
    /// Motor angle, degrees; absent for a translated base.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motor_angle_deg: Option<f64>,
    /// Distance, mm, of a translated base.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub distance_mm: Option<f64>,
    /// Force on the object, world frame, N.
    pub force_n: Option<[f64; 2]>,
    /// Its magnitude, N.
    pub force_magnitude_n: Option<f64>,
    /// Force on the object, finger frame, N.
    pub force_finger_frame_n: Option<[f64; 2]>,
    /// Torque that the contact demands of the motor, N·mm, positive when it must push to close. For a translated base:
    /// the force against its motion, N.
    pub motor_torque_nmm: Option<f64>,
    /// Elastic energy, N·mm.
    pub energy_nmm: Option<f64>,
    /// Smallest gap between the finger and the object, mm: the distance before contact, and in contact what the contact's
    /// softness lets the samples sink in (negative).
    #[serde(default)]
    pub gap_mm: Option<f64>,
    /// Tip of the front beam, finger frame, mm.
    pub tip_mm: Option<[f64; 2]>,
    /// Front centreline, base to tip, finger frame, mm.
    pub front_mm: Vec<[f64; 2]>,
    /// Back centreline, base to tip, finger frame, mm.
    pub back_mm: Vec<[f64; 2]>,
    /// Ends of the lamellae (front, back), base to tip, finger frame, mm.
    pub lamellae_mm: Vec<[[f64; 2]; 2]>,
    /// Touching samples, base to tip, finger frame.
    pub contacts: Vec<Contact>,
    /// Largest strains.
    pub max_strain: Option<MaxStrain>,
    /// Derivatives; `null` if more samples touch than the solver has room for.
    pub sensitivity: Option<Sensitivity>,
    /// Newton iterations spent since the previous place.
    pub iterations: u32,
    /// Steps of the coordinate since the previous place.
    pub steps: u32,
    /// Time since the previous place, µs.
    pub elapsed_us: f64,
    /// The model.
    pub model: Model,
    /// Branch, counted from 1: every snap-through begins another; absent once a place had no trustworthy solution.
    #[serde(default)]
    pub branch: Option<u32>,
    /// How far the first branch reaches; the same at every place of a case.
    #[serde(default)]
    pub first_branch: Option<FirstBranch>,
    /// Contact pressure at the touching samples, base to tip.
    #[serde(default)]
    pub contact_pressure: Vec<Pressure>,
    /// Strains along the beams and in the hinges.
    #[serde(default)]
    pub strains: Option<Strains>,
    /// What is strained beyond the material's limit, the worst first; absent if the limit or the strains are not known.
    #[serde(default)]
    pub beyond_max_strain: Option<Vec<Beyond>>,
    /// How far the object reaches into a part of the finger that knows no contact, mm; absent where it stays clear.
    #[serde(default)]
    pub overlap_mm: Option<f64>,
}

impl Solution {
    /// The motor angle in degrees or the distance in mm.
    pub fn place(&self) -> f64 {
        self.motor_angle_deg.or(self.distance_mm).unwrap_or(0.0)
    }

    /// Derivative of the force's magnitude, N per degree or per mm.
    pub fn force_slope(&self) -> Option<f64> {
        let sensitivity = self.sensitivity.as_ref()?;
        let [dx, dy] = sensitivity.force_per_deg_n.or(sensitivity.force_per_mm_n)?;
        let ([x, y], size) = (self.force_n?, self.force_magnitude_n?);
        (size > 0.0).then(|| (x * dx + y * dy) / size)
    }

    /// The deformed finger.
    pub fn shape(&self) -> Shape {
        Shape {
            front: self.front_mm.clone(),
            back: self.back_mm.clone(),
            lamellae: self.lamellae_mm.clone(),
            contacts: self.contacts.clone(),
        }
    }
}

/// Solves a case: one result per place, in the case's order. The path begins without contact and leads through the
/// places one after the other, so results after a turn of the motion belong to the way back.
///
/// # Errors
/// If the finger cannot be discretised as asked.
pub fn solve(case: &Case, options: &Options) -> Result<Vec<Solution>, DiscretiseError> {
    match options.precision {
        Precision::F32 => solve_with_room::<f32>(case, options),
        Precision::F64 => solve_with_room::<f64>(case, options),
    }
}

/// Begins again with more room if more samples touch than usual, or more than have a row of their own for their turning in a
/// derivative.
fn solve_with_room<T: Real>(case: &Case, options: &Options) -> Result<Vec<Solution>, DiscretiseError> {
    let solutions = solve_in::<T, Host>(case, options)?;
    let crowded = |solution: &Solution| {
        solution.status == Status::ContactCapacity
            || (solution.status.is_trustworthy() && solution.sensitivity.is_none())
            || 2 * solution.contacts.len() > <Host as Size>::CONTACTS
    };
    if solutions.iter().any(crowded) { solve_in::<T, Wide>(case, options) } else { Ok(solutions) }
}

/// A follower that stands where the path begins, without contact.
fn begin<T: Real, S: Size>(case: &Case, options: &Options) -> Result<Follower<T, S>, DiscretiseError> {
    let mut follower = <Follower<T, S>>::EMPTY;
    follower.configure(&case.finger.design, &options.discretisation)?;
    follower.set_hessian(options.hessian);
    follower.set_object(case.object, case.path.motion);
    if let Some(&first) = case.path.places.first() {
        // A start that is not free of contact shows in the status of every place.
        follower.start(case.path.coordinate(first));
    }
    Ok(follower)
}

fn solve_in<T: Real, S: Size>(case: &Case, options: &Options) -> Result<Vec<Solution>, DiscretiseError> {
    let mut follower = begin::<T, S>(case, options)?;
    let mut probe = Probe::EMPTY;
    let model = model(case, options, follower.unknowns());
    let samples: Vec<f64> = follower.sample_arcs().map(T::to_f64).collect();
    let mut snaps = Vec::with_capacity(case.path.places.len());
    let at = |&place: &f64| {
        let begin = Instant::now();
        let outcome = follower.follow_within(case.path.coordinate(place), MOST_ITERATIONS);
        let elapsed_us = begin.elapsed().as_secs_f64() * 1e6;
        let (angle, distance) = match case.path.motion {
            Motion::Rotating { .. } => (Some(place), None),
            Motion::Translating { .. } => (None, Some(place)),
        };
        snaps.push(outcome.snaps);
        let known = outcome.status.is_trustworthy();
        let shape = if known { Shape::of(&follower) } else { Shape::default() };
        // Adding zero turns −0 into 0.
        let number = |value: T| known.then(|| value.to_f64() + 0.0);
        let vector = |value: [T; 2]| known.then(|| value.map(|x| x.to_f64() + 0.0));
        let force = vector(follower.force_world());
        let strains = known.then(|| Strains::of(&follower));
        let beyond = strains.as_ref().zip(case.finger.max_strain).map(|(strains, limit)| strains.beyond(limit));
        Solution {
            status: outcome.status,
            motor_angle_deg: angle,
            distance_mm: distance,
            force_n: force,
            force_magnitude_n: force.map(|[x, y]| x.hypot(y)),
            force_finger_frame_n: vector(follower.force_finger()),
            motor_torque_nmm: number(follower.motor_torque()),
            energy_nmm: number(follower.energy()),
            gap_mm: number(follower.distance()),
            tip_mm: vector(follower.tip()),
            front_mm: shape.front,
            back_mm: shape.back,
            lamellae_mm: shape.lamellae,
            contact_pressure: pressures(&case.finger.design, &samples, &shape.contacts),
            contacts: shape.contacts,
            max_strain: known.then(|| max_strain(&follower)),
            sensitivity: if known { sensitivity(&mut follower, &mut probe, case, options) } else { None },
            iterations: outcome.iterations,
            steps: outcome.steps,
            elapsed_us: (elapsed_us * 10.0).round() / 10.0,
            model: model.clone(),
            branch: None,
            first_branch: None,
            strains,
            beyond_max_strain: beyond,
            overlap_mm: None,
        }
    };
    let mut solutions: Vec<Solution> = case.path.places.iter().map(at).collect();
    let found: Vec<Found> = solutions
        .iter()
        .zip(snaps)
        .map(|(s, snaps)| Found {
            place: s.place(),
            status: s.status,
            snaps,
            force: s.force_magnitude_n,
            slope: s.force_slope(),
        })
        .collect();
    let again = || begin::<T, S>(case, options).ok();
    let first_branch = branch::first_branch(&case.path, &found, again, MOST_ITERATIONS);
    for (solution, branch) in solutions.iter_mut().zip(branch::branches(&found)) {
        (solution.branch, solution.first_branch) = (branch, first_branch);
        solution.overlap_mm = overlap::depth(case, solution);
    }
    Ok(solutions)
}

fn max_strain<T: Real, S: Size>(follower: &Follower<T, S>) -> MaxStrain {
    let [front, back, hinge] = follower.max_strain().map(T::to_f64);
    MaxStrain { front, back, hinge }
}

/// Derivatives at the present place; `None` if more samples touch than there is room for.
fn sensitivity<T: Real, S: Size>(
    follower: &mut Follower<T, S>,
    probe: &mut Probe<T, S>,
    case: &Case,
    options: &Options,
) -> Option<Sensitivity> {
    let found = follower.sensitivity()?;
    let mut dimension = |parameter| {
        follower
            .design_sensitivity(probe, &case.finger.design, &options.discretisation, parameter)
            .map(|derivative| vector(derivative.force))
    };
    let force = |derivative: &Derivative<T>| vector(derivative.force);
    let rotating = matches!(case.path.motion, Motion::Rotating { .. });
    let coordinate = force(&found.coordinate);
    let centre = [force(&found.centre[0]), force(&found.centre[1])];
    let per_degree = 1_f64.to_radians();
    Some(Sensitivity {
        force_per_deg_n: rotating.then_some(coordinate.map(|per_radian| per_radian * per_degree)),
        force_per_mm_n: (!rotating).then_some(coordinate),
        force_per_centre_mm_n: centre,
        force_per_radius_mm_n: force(&found.radius),
        force_per_youngs_modulus_mpa_n: force(&found.youngs_modulus),
        force_per_front_thickness_mm_n: dimension(DesignParameter::FrontThickness),
        force_per_back_thickness_mm_n: dimension(DesignParameter::BackThickness),
        force_per_hinge_thickness_mm_n: dimension(DesignParameter::HingeThickness),
        force_per_hinge_length_mm_n: dimension(DesignParameter::HingeLength),
        force_per_motor_axis_mm_n: [force(&found.axis[0]), force(&found.axis[1])],
        stiffness_n_per_mm: [0, 1].map(|i| [centre[0][i], centre[1][i]]),
        torque_per_deg_nmm: rotating.then_some(found.coordinate.torque.to_f64() * per_degree),
        torque_per_centre_mm_nmm: [found.centre[0].torque.to_f64(), found.centre[1].torque.to_f64()],
        torque_per_radius_mm_nmm: found.radius.torque.to_f64(),
        contact_centre_per_deg_mm: rotating.then_some(vector(found.coordinate.contact_centre).map(|x| x * per_degree)),
    })
}

fn vector<T: Real>(v: [T; 2]) -> [f64; 2] {
    // Adding zero turns −0 into 0.
    v.map(|x| x.to_f64() + 0.0)
}

fn model(case: &Case, options: &Options, unknowns: usize) -> Model {
    let how = &options.discretisation;
    let lamellae = case.finger.design.lamella_count() as u32;
    let (beam, hinge) = match how.elements {
        Elements::PerBeam { beam, hinge } => (u32::from(beam), hinge),
        Elements::PerSpan { span, tip_span, hinge } => (lamellae * u32::from(span) + u32::from(tip_span), hinge),
    };
    Model {
        scheme: scheme_word(how.scheme).to_owned(),
        elements_per_beam: beam,
        elements_per_hinge: u32::from(hinge),
        unknowns,
        physics: physics_word(how.physics).to_owned(),
        precision: options.precision,
    }
}

/// The word for a scheme in files and options.
pub fn scheme_word(scheme: Scheme) -> &'static str {
    match scheme {
        Scheme::Paper => "paper",
        Scheme::Trapezoid => "trapezoid",
        Scheme::Simpson => "simpson",
    }
}

/// The word for a physics in files and options.
pub fn physics_word(physics: Physics) -> &'static str {
    match physics {
        Physics::Paper => "paper",
        Physics::Extended => "extended",
    }
}
