//! Derivatives along lines of random fingers, objects and motions against differences of equilibria, each found anew from the open finger.

use std::boxed::Box;
use std::string::String;
use std::vec::Vec;

use super::tests::{Case, Large, Line, Parameter, Solver, random};
use super::{Neighbours, Probe, Side};
use crate::design::ladder_80;
use crate::discretise::{Discretisation, Physics};
use crate::equilibrium::Follower;
use crate::object::{Corners, Motion, ObjectDesign, Shape};
use crate::random_designs::Random;
use crate::status::Status;

/// Names of what is read: see [`read`].
const READ: [&str; 6] = ["force x", "force y", "torque", "strain", "spread", "stiffness"];

/// Force, torque, the strain at one place, the spread of the contact force along the beam, and the stiffness that the object meets.
fn read(follower: &mut Solver, strained: usize) -> Option<[f64; 6]> {
    let ([x, y], torque) = (follower.solution().force_world(), follower.solution().motor_torque());
    let strain = follower.solution().strains().nth(strained)?.largest();
    let whole: f64 = follower.solution().contacts().map(|contact| contact.force).sum();
    let mean = follower.solution().contacts().map(|contact| contact.force * contact.arc).sum::<f64>() / whole;
    let square =
        follower.solution().contacts().map(|contact| contact.force * (contact.arc - mean).powi(2)).sum::<f64>();
    let spread = (square / whole).sqrt();
    let [along_x, along_y] = follower.sensitivity()?.centre.map(|derivative| derivative.force);
    let stiffness = -(x * (along_x[0] * x + along_y[0] * y) + y * (along_x[1] * x + along_y[1] * y)) / (x * x + y * y);
    Some([x, y, torque, strain, spread, stiffness])
}

/// What is changed: what a line of designs changes, or the object's shape.
#[derive(Clone, Copy, Debug)]
enum Along {
    Parameter(Parameter),
    Shape(usize),
}

impl Along {
    fn all(case: &Case) -> Vec<Self> {
        let lines = Line::ALL.into_iter().map(Parameter::Line);
        let motions = [Parameter::Axis(0), Parameter::Axis(1), Parameter::Centre(0), Parameter::Centre(1)];
        let mut all: Vec<Self> = lines.chain(motions).map(Self::Parameter).collect();
        if !matches!(case.object, ObjectDesign::Ellipse { .. }) {
            all.push(Self::Parameter(Parameter::Radius));
        }
        if !matches!(case.object, ObjectDesign::Circle { .. } | ObjectDesign::Bore { .. }) {
            all.extend([Self::Shape(0), Self::Shape(1)]);
        }
        all
    }

    fn shifted(self, case: &Case, by: f64) -> Case {
        let mut case = match self {
            Self::Parameter(parameter) => return case.shifted(parameter, by),
            Self::Shape(_) => case.clone(),
        };
        let Self::Shape(which) = self else { return case };
        match &mut case.object {
            ObjectDesign::Ellipse { semi_axes, angle, .. } => {
                if which == 0 {
                    semi_axes[1] += by
                } else {
                    *angle += 0.05 * by
                }
            }
            ObjectDesign::Polygon { corners, .. } => {
                // Both of the side next to the finger.
                let mut moved = corners.to_vec();
                moved[3 * which][0] -= by;
                *corners = Corners::new(&moved).expect("as many");
            }
            ObjectDesign::HalfPlane { normal, .. } => normal[which] += 0.05 * by,
            ObjectDesign::Circle { .. } | ObjectDesign::Bore { .. } => {}
        }
        case
    }
}

impl Case {
    fn side(&self) -> Side<'_, Shape<f64>> {
        let motion = match self.motion {
            Some(direction) => Motion::Translating { direction },
            None => Motion::Rotating { axis: self.design.motor_axis },
        };
        Side { design: &self.design, object: self.object.into(), motion }
    }
}

fn arcs(follower: &Solver) -> Vec<f64> {
    follower.solution().contacts().map(|contact| contact.arc).collect()
}

fn most_strained(follower: &Solver) -> usize {
    let order = |a: &(usize, f64), b: &(usize, f64)| a.1.total_cmp(&b.1);
    let sizes = follower.solution().strains().map(|strain| strain.largest()).enumerate();
    sizes.max_by(order).expect("members that bend").0
}

#[test]
fn derivatives_along_lines_agree_with_differences() {
    let mut numbers = Random::new(35);
    let mut follower: Box<Solver> = Box::new(Follower::EMPTY);
    let mut neighbours: Box<Neighbours<f64, Large>> = Box::new(Neighbours::EMPTY);
    let (mut compared, mut cases, mut worst, mut wrong) = ([0; 6], 0, [0.0_f64; 6], Vec::<String>::new());
    let mut shapes = 0;
    for index in 0..64 {
        let (case, how) = random(&mut numbers, index);
        if case.design.validate().is_err() || !case.solve(&mut follower, &how) {
            continue;
        }
        let strained = most_strained(&follower);
        let Some(here) = read(&mut follower, strained) else { continue };
        cases += 1;
        let touching = arcs(&follower);
        for along in Along::all(&case) {
            assert!(case.solve(&mut follower, &how));
            let step = 5e-5;
            let sides = [-step, step].map(|by| along.shifted(&case, by));
            let sides = [sides[0].side(), sides[1].side()];
            let reading = |follower: &mut Solver| read(follower, strained);
            let found = follower.derivative_along(&mut neighbours, sides, &how, step, reading).expect("room");
            let again = read(&mut follower, strained).expect("as before");
            assert!(again.iter().zip(here).all(|(a, b)| (a - b).abs() <= 1e-9 * b.abs() + 1e-9), "{again:?}, {here:?}");
            let h = 2e-4;
            let mut at = |by: f64| {
                let solved = along.shifted(&case, by * h).solve(&mut follower, &how);
                let same = solved && arcs(&follower).len() == touching.len();
                let same = same && arcs(&follower).iter().zip(&touching).all(|(a, b)| (a - b).abs() < 1e-3);
                if same { read(&mut follower, strained) } else { None }
            };
            let [Some(a), Some(b), Some(c), Some(d)] = [-2.0, -1.0, 1.0, 2.0].map(&mut at) else { continue };
            shapes += usize::from(matches!(along, Along::Shape(_)));
            for i in 0..READ.len() {
                let expected = (a[i] - 8.0 * b[i] + 8.0 * c[i] - d[i]) / (12.0 * h);
                // Of a vector both components have one scale.
                let size = if i < 2 { here[0].hypot(here[1]) } else { here[i].abs() };
                // One touching sample has no spread but for rounding, and how two neighbours share the force is the rounding of gaps.
                let size = if READ[i] == "spread" { size.max(1.0) } else { size };
                let error = (found[i] - expected).abs() / (expected.abs() + 0.05 * size);
                compared[i] += 1;
                worst[i] = worst[i].max(error);
                if error >= 1e-5 {
                    wrong.push(std::format!(
                        "case {index} ({:?}, {:?}, {:?}), {along:?}: {} {} and {expected}, {error:e}",
                        how.scheme,
                        how.physics,
                        case.object,
                        READ[i],
                        found[i]
                    ));
                }
            }
        }
    }
    for wrong in &wrong {
        std::println!("{wrong}");
    }
    std::println!("{cases} cases, {shapes} shapes");
    for ((name, compared), worst) in READ.iter().zip(compared).zip(worst) {
        std::println!("{name}: {compared} derivatives, worst error {worst:.1e}");
    }
    assert!(wrong.is_empty(), "{} derivatives are wrong", wrong.len());
    assert!(cases >= 40 && compared[0] >= 450 && shapes >= 20, "{cases} cases, {compared:?}, {shapes}");
}

/// The factor of Young's modulus belongs to both: the derivative is that of the warmer finger.
#[test]
fn a_factor_of_youngs_modulus_scales_derivatives() {
    let how = Discretisation::reduced(Physics::Extended);
    let design = ladder_80();
    let object = ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 };
    let case = Case { design, object, motion: None, at: 0.1 };
    let mut follower: Box<Solver> = Box::new(Follower::EMPTY);
    let mut neighbours: Box<Neighbours<f64, Large>> = Box::new(Neighbours::EMPTY);
    let mut probe: Box<Probe<f64, Large>> = Box::new(Probe::EMPTY);
    let mut found = [1.0, 0.5].map(|factor| {
        follower.set_modulus_factor(factor).expect("in range");
        assert!(case.solve(&mut follower, &how));
        assert_eq!(follower.follow(case.at).status, Status::Converged);
        let step = 1e-5;
        let sides = [-step, step].map(|by| case.shifted(Parameter::Line(Line::FrontTaper), by));
        let designs = [&sides[0].design, &sides[1].design];
        let design = follower.design_derivative(&mut probe, designs, &how, step).expect("room").force;
        let sides = [sides[0].side(), sides[1].side()];
        let read = |follower: &mut Solver| Some(follower.solution().force_world());
        let line = follower.derivative_along(&mut neighbours, sides, &how, step, read).expect("room");
        [design, line]
    });
    for force in found[1].as_flattened_mut() {
        *force *= 2.0;
    }
    let [[whole, line], [half, half_line]] = found;
    for i in 0..2 {
        for other in [line[i], half[i], half_line[i]] {
            assert!((other / whole[i] - 1.0).abs() < 1e-6, "{found:?}");
        }
    }
}
