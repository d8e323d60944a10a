//! Derivatives of random fingers on random objects against differences of equilibria, each found anew from the open finger.
//!
//! Where a sample comes into contact or leaves it within the difference, a central difference means nothing: the side on
//! which the same samples touch is then compared, one-sided and less sharply, and a case with no such side is counted as
//! not comparable. The counts are asserted.

use std::boxed::Box;
use std::string::String;
use std::vec::Vec;

use super::{Derivative, DesignParameter, Probe};
use crate::design::{Attachments, Beam, Design, MAX_LAMELLAE, Profile, ladder_80};
use crate::discretise::{Discretisation, Physics, Sampling, Scheme, Softness};
use crate::equilibrium::{Follower, Tracking};
use crate::object::{Corners, Motion, ObjectDesign};
use crate::random_designs::{Random, Round, first_contact, random_case};
use crate::size::Reduced;
use crate::status::Status;

crate::fixed_size!(
    /// Room for many elements and lamellae at once.
    Large, cells 13, nodes 1536, samples 184, contacts 40
);

crate::fixed_size!(
    /// As [`Large`], but with room for few contact rows.
    Narrow, cells 13, nodes 1536, samples 184, contacts 16
);

pub(super) type Solver = Follower<f64, Large>;

/// What can be changed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Parameter {
    Coordinate,
    Centre(usize),
    Radius,
    YoungsModulus,
    Axis(usize),
    Design(DesignParameter),
    Line(Line),
}

/// What a designer changes beyond the dimensions with names of their own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Line {
    /// The back beam's base, along x: the base's width.
    BaseWidth,
    /// One lamella's height.
    Height(usize),
    /// One lamella's end on the back beam alone: its angle.
    BackArc(usize),
    /// One lamella's hinges, longer.
    Hinge(usize),
    /// The front beam's thickness at its tip.
    FrontTaper,
    /// The back beam's thickness at its base.
    BackTaper,
    /// The finger's width, on which its own contact softness depends.
    Width,
    Modulus,
    TipHeight,
}

impl Line {
    pub(super) const ALL: [Self; 9] = [
        Self::BaseWidth,
        Self::Height(1),
        Self::BackArc(2),
        Self::Hinge(0),
        Self::FrontTaper,
        Self::BackTaper,
        Self::Width,
        Self::Modulus,
        Self::TipHeight,
    ];

    fn shift(self, design: &mut Design, by: f64) {
        let taper = |beam: &mut Beam, end: usize| {
            let value = beam.thickness.at(0.0);
            let mut knots = [[0.0, value], [beam.length(), value]];
            knots[end][1] += by;
            beam.thickness.knots = heapless::Vec::from_iter(knots);
        };
        match self {
            Self::BaseWidth => design.back.base[0] -= by,
            Self::Height(k) => {
                if let Attachments::Heights(heights) = &mut design.lamellae.attachments {
                    heights[k] += by;
                }
            }
            Self::BackArc(k) => {
                let arcs: Vec<[f64; 2]> = (0..design.lamella_count()).map(|k| design.attachment_arcs(k)).collect();
                let on = |side: usize| arcs.iter().map(|arc| arc[side]).collect();
                let mut back: heapless::Vec<f64, MAX_LAMELLAE> = on(1);
                back[k] += by;
                design.lamellae.attachments = Attachments::Arcs { front: on(0), back };
            }
            Self::Hinge(k) => {
                let count = design.lamella_count();
                design.hinge.length = (0..count).map(|k| design.hinge.length_of(k)).collect();
                design.hinge.length[k] += by;
            }
            Self::FrontTaper => taper(&mut design.front, 1),
            Self::BackTaper => taper(&mut design.back, 0),
            Self::Width => design.width = Profile::constant(design.width.at(0.0) + 10.0 * by),
            Self::Modulus => design.material.youngs_modulus *= 1.0 + by,
            Self::TipHeight => {
                for tip in [&mut design.front.tip, &mut design.back.tip] {
                    tip[1] += by;
                }
            }
        }
    }
}

#[derive(Clone)]
pub(super) struct Case {
    pub(super) design: Design,
    pub(super) object: ObjectDesign,
    pub(super) motion: Option<[f64; 2]>,
    pub(super) at: f64,
}

/// An object somewhere else, its outline grown on all sides (which makes no ellipse of an ellipse).
fn moved(object: ObjectDesign, shift: [f64; 2], growth: f64) -> ObjectDesign {
    let go = |p: [f64; 2]| [p[0] + shift[0], p[1] + shift[1]];
    match object {
        ObjectDesign::Circle { centre, radius } => ObjectDesign::Circle { centre: go(centre), radius: radius + growth },
        ObjectDesign::Ellipse { centre, semi_axes, angle } => {
            ObjectDesign::Ellipse { centre: go(centre), semi_axes, angle }
        }
        ObjectDesign::Polygon { corners, rounding } => {
            ObjectDesign::Polygon { corners: corners.map(go), rounding: rounding + growth }
        }
        ObjectDesign::HalfPlane { point, normal } => {
            let part = growth / normal[0].hypot(normal[1]);
            let point = go(point);
            ObjectDesign::HalfPlane { point: [point[0] + part * normal[0], point[1] + part * normal[1]], normal }
        }
        ObjectDesign::Bore { centre, radius } => ObjectDesign::Bore { centre: go(centre), radius: radius - growth },
    }
}

impl Case {
    pub(super) fn shifted(&self, parameter: Parameter, by: f64) -> Self {
        let mut case = self.clone();
        match parameter {
            Parameter::Coordinate => case.at += by,
            Parameter::Centre(i) => {
                let mut shift = [0.0; 2];
                shift[i] = by;
                case.object = moved(case.object, shift, 0.0);
            }
            Parameter::Radius => case.object = moved(case.object, [0.0; 2], by),
            Parameter::YoungsModulus => case.design.material.youngs_modulus += by,
            Parameter::Axis(i) => case.design.motor_axis[i] += by,
            Parameter::Design(dimension) => dimension.shift(&mut case.design, by),
            Parameter::Line(line) => line.shift(&mut case.design, by),
        }
        case
    }

    /// Puts the follower at the equilibrium; false unless it came there without a snap and in contact.
    pub(super) fn solve(&self, follower: &mut Solver, how: &Discretisation) -> bool {
        follower.configure(&self.design, how).expect("a valid design");
        let motion = match self.motion {
            Some(direction) => Motion::Translating { direction },
            None => Motion::Rotating { axis: self.design.motor_axis },
        };
        follower.set_object(self.object, motion);
        follower.start(self.at) && follower.follow(self.at).status == Status::Converged
    }
}

/// Force, torque and contact centre, world frame; and the arcs of the touching samples.
type Seen = ([f64; 5], Vec<f64>);

fn seen(follower: &Solver) -> Seen {
    let (mut centre, mut total, mut arcs) = ([0.0; 2], 0.0, Vec::new());
    for contact in follower.solution().contacts() {
        total += contact.force;
        centre[0] += contact.force * contact.position[0];
        centre[1] += contact.force * contact.position[1];
        arcs.push(contact.arc);
    }
    let c = follower.solution().to_world([centre[0] / total, centre[1] / total]);
    let f = follower.solution().force_world();
    ([f[0], f[1], follower.solution().motor_torque(), c[0], c[1]], arcs)
}

fn flat(d: &Derivative<f64>) -> [f64; 5] {
    [d.force[0], d.force[1], d.torque, d.contact_centre[0], d.contact_centre[1]]
}

fn combine(weights: &[(f64, &Seen)], h: f64) -> [f64; 5] {
    let mut sum = [0.0; 5];
    for (weight, (values, _)) in weights {
        for i in 0..5 {
            sum[i] += weight * values[i] / h;
        }
    }
    sum
}

#[derive(Debug, Default)]
struct Count {
    central: usize,
    one_sided: usize,
    not_comparable: usize,
    worst: f64,
    wrong: Vec<String>,
}

/// Compares force, torque and centre, each with the size of its own derivative.
fn error(found: &[f64; 5], exact: &[f64; 5], scale: f64) -> f64 {
    let mut worst = 0.0_f64;
    for (part, least) in [(0..2, 0.05), (2..3, 2.0), (3..5, 0.05)] {
        let size = exact[part.clone()].iter().map(|x| x * x).sum::<f64>().sqrt();
        for i in part {
            worst = worst.max((found[i] - exact[i]).abs() / (size + least * scale));
        }
    }
    worst
}

fn compare(
    follower: &mut Solver,
    how: &Discretisation,
    case: &Case,
    parameter: Parameter,
    exact: &Derivative<f64>,
    here: &Seen,
    count: &mut Count,
) {
    // Units of the parameter that change the force by about 1 N.
    let (h, scale) = match parameter {
        Parameter::Coordinate if case.motion.is_none() => (1e-5, 60.0),
        Parameter::YoungsModulus => (2e-3, 0.1),
        _ => (2e-4, 1.0),
    };
    let mut at = |by: f64| -> Option<Seen> {
        case.shifted(parameter, by * h).solve(follower, how).then(|| seen(follower)).filter(|side| {
            // The same samples, which a thickness may shift a little along a beam.
            side.1.len() == here.1.len() && side.1.iter().zip(&here.1).all(|(a, b)| (a - b).abs() < 1e-3)
        })
    };
    let (plus, minus) = ([at(1.0), at(2.0)], [at(-1.0), at(-2.0)]);
    let exact = flat(exact);
    match (plus, minus) {
        ([Some(a), Some(b)], [Some(c), Some(d)]) => {
            let found = combine(&[(8.0, &a), (-8.0, &c), (-1.0, &b), (1.0, &d)], 12.0 * h);
            let error = error(&found, &exact, scale);
            count.central += 1;
            count.worst = count.worst.max(error);
            if error >= 1e-5 {
                count.wrong.push(std::format!("{parameter:?}: {found:?} and {exact:?}, error {error:e}"));
            }
        }
        ([Some(a), Some(b)], _) => {
            let found = combine(&[(4.0, &a), (-1.0, &b), (-3.0, here)], 2.0 * h);
            count.one_sided += 1;
            let error = error(&found, &exact, scale);
            if error >= 1e-3 {
                count.wrong.push(std::format!("{parameter:?}, greater side: {found:?} and {exact:?}, error {error:e}"));
            }
        }
        (_, [Some(c), Some(d)]) => {
            let found = combine(&[(-4.0, &c), (1.0, &d), (3.0, here)], 2.0 * h);
            count.one_sided += 1;
            let error = error(&found, &exact, scale);
            if error >= 1e-3 {
                count.wrong.push(std::format!("{parameter:?}, lesser side: {found:?} and {exact:?}, error {error:e}"));
            }
        }
        _ => count.not_comparable += 1,
    }
}

/// A random case, every other one moved by a translated base, and a discretisation.
pub(super) fn random(random: &mut Random, index: usize) -> (Case, Discretisation) {
    let (mut design, round, indentation) = random_case(random);
    let Round { centre, radius } = round;
    // Other shapes lie within the circle and touch it where it is nearest to the finger.
    let object = match index % 7 {
        2 => ObjectDesign::Ellipse { centre, semi_axes: [radius, 0.6 * radius], angle: 0.1 },
        3 => {
            let (half, rounding) = (0.7 * radius, 0.3 * radius);
            let corners = [[-half, -0.3 * half], [half, -half], [half, half], [-0.9 * half, 0.5 * half]];
            let corners = Corners::new(&corners.map(|[x, y]| [centre[0] + x, centre[1] + y])).expect("four corners");
            ObjectDesign::Polygon { corners, rounding }
        }
        4 => ObjectDesign::HalfPlane { point: [centre[0] - radius, centre[1]], normal: [-1.0, 0.4] },
        _ => ObjectDesign::Circle { centre, radius },
    };
    let angle = first_contact(&design, centre, radius) + 0.7 * indentation;
    let physics = if index.is_multiple_of(3) { Physics::Paper } else { Physics::Extended };
    let how = match index % 8 {
        4 => Discretisation {
            sampling: Sampling::Nodes,
            softness: Softness::Fixed(0.0),
            ..Discretisation::full(Scheme::Trapezoid, physics)
        },
        6 => Discretisation { sampling: Sampling::PerElement(2), ..Discretisation::fine(physics) },
        _ => Discretisation::reduced(physics),
    };
    if index % 4 == 1 {
        design.hinge.from = crate::design::HingeFrom::Face;
        design.rigid_above = Some(0.92 * design.front.tip[1]);
    }
    let motion = (index % 4 == 3).then_some([0.8, 0.6]);
    let at = if motion.is_some() { 2.0 + 8.0 * indentation } else { angle };
    (Case { design, object, motion, at }, how)
}

#[test]
fn derivatives_of_random_designs_agree_with_differences() {
    let mut numbers = Random::new(35);
    let mut follower: Box<Solver> = Box::new(Follower::EMPTY);
    let mut probe: Box<Probe<f64, Large>> = Box::new(Probe::EMPTY);
    let mut count = Count::default();
    let mut cases = 0;
    for index in 0..64 {
        let (case, how) = random(&mut numbers, index);
        if case.design.validate().is_err() || !case.solve(&mut follower, &how) {
            continue;
        }
        let Some(exact) = follower.sensitivity() else { continue };
        cases += 1;
        let here = seen(&follower);
        let mut all = Vec::from([
            (Parameter::Coordinate, exact.coordinate),
            (Parameter::Centre(0), exact.centre[0]),
            (Parameter::Centre(1), exact.centre[1]),
            (Parameter::YoungsModulus, exact.youngs_modulus),
            (Parameter::Axis(0), exact.axis[0]),
            (Parameter::Axis(1), exact.axis[1]),
        ]);
        if !matches!(case.object, ObjectDesign::Ellipse { .. }) {
            all.push((Parameter::Radius, exact.radius));
        }
        for dimension in DesignParameter::ALL {
            let derivative = follower.design_sensitivity(&mut probe, &case.design, &how, dimension);
            all.push((Parameter::Design(dimension), derivative.expect("room, as before")));
        }
        for line in Line::ALL {
            let step = 6e-6;
            let designs = [-step, step].map(|by| case.shifted(Parameter::Line(line), by).design);
            let derivative = follower.design_derivative(&mut probe, [&designs[0], &designs[1]], &how, step);
            all.push((Parameter::Line(line), derivative.expect("room, as before")));
        }
        for (parameter, exact) in all {
            let before = count.wrong.len();
            compare(&mut follower, &how, &case, parameter, &exact, &here, &mut count);
            for wrong in &mut count.wrong[before..] {
                *wrong = std::format!("case {index} ({:?}, {:?}, {:?}): {wrong}", how.scheme, how.physics, case.object);
            }
        }
    }
    for wrong in &count.wrong {
        std::println!("{wrong}");
    }
    std::println!(
        "{cases} cases: {} central (worst error {:.1e}), {} one-sided, {} not comparable",
        count.central,
        count.worst,
        count.one_sided,
        count.not_comparable
    );
    assert!(count.wrong.is_empty(), "{} derivatives are wrong", count.wrong.len());
    assert!(cases >= 40, "{cases} cases");
    let total = count.central + count.one_sided + count.not_comparable;
    assert!(count.central * 100 >= total * 90, "{count:?}");
}

/// Just beyond a change of contact the derivatives are those of the side the equilibrium is on.
#[test]
fn beside_a_change_of_contact_derivatives_are_one_sided() {
    let how = Discretisation::reduced(Physics::Extended);
    let mut follower: Box<Solver> = Box::new(Follower::EMPTY);
    let design = ladder_80();
    let object = ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 };
    let mut case = Case { design, object, motion: None, at: 0.0 };
    let mut arcs = |at: f64| {
        case.at = at;
        assert!(case.solve(&mut follower, &how), "at {at}");
        seen(&follower).1
    };
    let mut changes = Vec::new();
    let spacing = 0.25_f64.to_radians();
    for step in 8..36 {
        let (mut low, mut high) = (f64::from(step) * spacing, f64::from(step + 1) * spacing);
        let (before, after) = (arcs(low), arcs(high));
        if before == after || changes.len() == 4 {
            continue;
        }
        // The change nearest to the beginning of the step.
        while high - low > 1e-7 {
            let middle = 0.5 * (low + high);
            if arcs(middle) == before { low = middle } else { high = middle }
        }
        changes.push([low, high]);
    }
    assert_eq!(changes.len(), 4);
    let mut count = Count::default();
    for at in changes.into_iter().flat_map(|[low, high]| [low - 2e-6, high + 2e-6]) {
        case.at = at;
        assert!(case.solve(&mut follower, &how));
        let (here, exact) = (seen(&follower), follower.sensitivity().expect("room"));
        compare(&mut follower, &how, &case, Parameter::Coordinate, &exact.coordinate, &here, &mut count);
    }
    assert!(count.wrong.is_empty(), "{:?}", count.wrong);
    assert!(count.one_sided >= 6 && count.central == 0, "{count:?}");
}

/// Where there is no room for two rows per sample, neighbours share a turning row: less exact, and told all the same.
#[test]
fn neighbours_share_a_turning_row_where_room_is_short() {
    let how = Discretisation { sampling: Sampling::PerElement(5), ..Discretisation::reduced(Physics::Extended) };
    let design = ladder_80();
    let mut wide: Box<Solver> = Box::new(Follower::EMPTY);
    let mut narrow: Box<Follower<f64, Narrow>> = Box::new(Follower::EMPTY);
    wide.configure(&design, &how).expect("a valid design");
    narrow.configure(&design, &how).expect("a valid design");
    let (mut alike, mut shared) = (0, 0);
    for (height, radius) in [(30.0, 40.0), (45.0, 40.0), (60.0, 25.0)] {
        let object = ObjectDesign::Circle { centre: [radius + 1.0, height], radius };
        let motion = Motion::Rotating { axis: design.motor_axis };
        wide.set_object(object, motion);
        narrow.set_object(object, motion);
        assert!(wide.start(0.0) && narrow.start(0.0));
        for step in 1..44 {
            let at = (0.25 * f64::from(step)).to_radians();
            let both = [wide.follow(at).status, narrow.follow(at).status];
            let touching = wide.solution().touching();
            // One sample must be left room for besides those that touch.
            if both != [Status::Converged; 2] || touching > 15 {
                continue;
            }
            let (exact, found) = (wide.sensitivity().expect("room"), narrow.sensitivity().expect("room for some"));
            let pairs = [
                (exact.coordinate, found.coordinate),
                (exact.centre[0], found.centre[0]),
                (exact.centre[1], found.centre[1]),
                (exact.radius, found.radius),
                (exact.youngs_modulus, found.youngs_modulus),
            ];
            for (exact, found) in pairs {
                let [x, y] = exact.force;
                let off = (x - found.force[0]).hypot(y - found.force[1]) / x.hypot(y);
                let allowed = if touching <= 8 { 1e-9 } else { 0.03 };
                assert!(off <= allowed, "{touching} touch at {height} mm: {off:e}, {exact:?} against {found:?}");
            }
            if touching <= 8 { alike += 1 } else { shared += 1 }
        }
    }
    assert!(alike >= 80 && shared >= 20, "{alike} alike, {shared} shared");
}

/// The estimator's derivatives take the last step's factorisation: within a few per cent, and the factorisation is not made anew.
#[test]
fn derivatives_on_the_factorisation_of_a_step_are_near() {
    let how = Discretisation::estimator(Physics::Extended);
    let design = ladder_80();
    let mut stepped: Box<Follower<f32, Reduced>> = Box::new(Follower::EMPTY);
    stepped.configure(&design, &how).expect("a valid design");
    stepped.set_object(
        ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 },
        Motion::Rotating { axis: design.motor_axis },
    );
    assert!(stepped.start(0.0));
    let mut compared = 0;
    for count in 0..125 {
        let at = f64::from(count) * core::f64::consts::TAU / 4096.0;
        let status = stepped.track(at, Tracking::DEFAULT, 1).status;
        if status != Status::Tracking || count % 8 > 0 {
            continue;
        }
        let before = stepped.effort();
        let found = stepped.sensitivity_of_step().expect("in contact");
        assert_eq!(stepped.effort().since(before).solves, 0);
        let exact = stepped.sensitivity().expect("in contact");
        for (exact, found) in [(exact.coordinate, found.coordinate), (exact.radius, found.radius)] {
            let [x, y] = exact.force;
            let off = (x - found.force[0]).hypot(y - found.force[1]) / x.hypot(y);
            assert!(off < 0.05, "count {count}: {off}");
        }
        compared += 1;
    }
    assert!(compared >= 10, "{compared}");
}

#[test]
fn a_design_at_the_edge_of_what_is_allowed_has_no_derivative_there() {
    let mut design = ladder_80();
    // The room that the topmost lamella leaves: the beams are 28 mm apart at the base and meet at 80 mm.
    let room = 0.5 * 28.0 * (1.0 - 63.0 / 80.0);
    design.hinge.length = heapless::Vec::from_iter([room * (1.0 - 1e-9)]);
    let how = Discretisation::reduced(Physics::Extended);
    let mut follower: Box<Solver> = Box::new(Follower::EMPTY);
    follower.configure(&design, &how).expect("a valid design");
    let object = ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 };
    follower.set_object(object, Motion::Rotating { axis: design.motor_axis });
    assert!(follower.start(0.1));
    assert_eq!(follower.follow(0.1).status, Status::Converged);
    let mut probe: Box<Probe<f64, Large>> = Box::new(Probe::EMPTY);
    let mut derivative = |parameter| follower.design_sensitivity(&mut probe, &design, &how, parameter);
    assert!(derivative(DesignParameter::HingeLength).is_none(), "longer hinges have no room");
    assert!(derivative(DesignParameter::HingeThickness).is_some());
}
