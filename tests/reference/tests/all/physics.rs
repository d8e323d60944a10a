//! What must hold whatever the numbers: torque identity, proportionality to E, derivatives, orders of convergence.

use model_core::design::Design;
use model_core::discretise::{Discretisation, Elements, Physics, Sampling, Scheme, Softness};
use model_core::equilibrium::Follower;
use model_core::object::{Motion, ObjectDesign};
use model_core::status::Status;
use reference_tests::ladder_80;

model_core::fixed_size!(
    /// Room for many elements and lamellae at once.
    Large, cells 13, nodes 1536, samples 184, contacts 40
);

type Solver = Box<Follower<f64, Large>>;

const MID: ObjectDesign = ObjectDesign::Circle { centre: MID_CENTRE, radius: 40.0 };
const MID_CENTRE: [f64; 2] = [41.0, 45.0];
const HIGH: ObjectDesign = ObjectDesign::Circle { centre: HIGH_CENTRE, radius: 40.0 };
const HIGH_CENTRE: [f64; 2] = [41.0, 60.0];

fn solver(design: &Design, how: &Discretisation, object: ObjectDesign) -> Solver {
    let mut follower: Solver = Box::new(Follower::EMPTY);
    follower.configure(design, how).expect("a valid design");
    follower.set_object(object, Motion::Rotating { axis: design.motor_axis });
    assert!(follower.start(0.0));
    follower
}

fn go(follower: &mut Solver, degrees: f64) {
    let outcome = follower.follow(degrees.to_radians());
    assert_eq!(outcome.status, Status::Converged, "at {degrees}°: {outcome:?}");
}

/// V + ½ ε Σ μ².
fn potential(follower: &Solver) -> f64 {
    let softness = follower.softness();
    follower.solution().energy()
        + follower.solution().contacts().map(|c| 0.5 * softness * c.force * c.force).sum::<f64>()
}

#[test]
fn the_torque_is_the_derivative_of_the_potential() {
    for physics in [Physics::Paper, Physics::Extended] {
        let how = Discretisation::reduced(physics);
        for object in [MID, HIGH] {
            for degrees in [2.0, 5.3, 9.1] {
                let mut follower = solver(&ladder_80(), &how, object);
                go(&mut follower, degrees);
                let (torque, touching) = (follower.solution().motor_torque(), follower.solution().touching());
                let h = 0.002;
                let mut side = [0.0; 4];
                for (value, by) in side.iter_mut().zip([h, -h, 2.0 * h, -2.0 * h]) {
                    go(&mut follower, degrees + by);
                    assert_eq!(
                        follower.solution().touching(),
                        touching,
                        "the difference must not cross a change of contact"
                    );
                    *value = potential(&follower);
                }
                let rate = (8.0 * (side[0] - side[1]) - (side[2] - side[3])) / (12.0 * h.to_radians());
                assert!((rate / torque - 1.0).abs() < 1e-6, "{physics:?} {object:?} {degrees}°: {rate} and {torque}");
            }
        }
    }
}

#[test]
fn the_force_is_proportional_to_youngs_modulus_and_the_shape_independent_of_it() {
    for physics in [Physics::Paper, Physics::Extended] {
        let how = Discretisation::reduced(physics);
        let mut soft = solver(&ladder_80(), &how, MID);
        go(&mut soft, 9.0);
        let mut design = ladder_80();
        design.material.youngs_modulus *= 3.0;
        // Its contact is as soft beside it.
        let mut stiff = solver(&design, &how, MID);
        go(&mut stiff, 9.0);
        for i in 0..2 {
            assert!((stiff.solution().force_world()[i] / soft.solution().force_world()[i] - 3.0).abs() < 1e-8);
        }
        for (a, b) in stiff.solution().front().zip(soft.solution().front()) {
            assert!((a[0] - b[0]).abs() < 1e-9 && (a[1] - b[1]).abs() < 1e-9);
        }
    }
}

#[test]
fn derivatives_of_the_force_agree_with_differences() {
    for physics in [Physics::Paper, Physics::Extended] {
        let how = Discretisation::reduced(physics);
        for (centre, degrees) in [(MID_CENTRE, 4.2), (MID_CENTRE, 9.1), (HIGH_CENTRE, 5.0), (HIGH_CENTRE, 9.0)] {
            let (radius, object) = (40.0, ObjectDesign::Circle { centre, radius: 40.0 });
            let force = |centre: [f64; 2], radius: f64, degrees: f64| {
                let mut follower = solver(&ladder_80(), &how, ObjectDesign::Circle { centre, radius });
                // The circle moved towards the finger may touch at 0 already: the follower begins further back.
                assert!(follower.start(0.0));
                go(&mut follower, degrees);
                (follower.solution().force_world(), follower.solution().touching())
            };
            let mut follower = solver(&ladder_80(), &how, object);
            go(&mut follower, degrees);
            let before = follower.solution().force_world();
            let exact = follower.sensitivity().expect("room for the rows");
            // What is read off afterwards may be of another evaluation of the same state: residuals are within 1e-9 N·mm.
            let same = |now: [f64; 2]| (0..2).all(|i| (now[i] - before[i]).abs() < 1e-10);
            assert!(same(follower.solution().force_world()), "asking for derivatives changes nothing");
            go(&mut follower, degrees);
            assert!(same(follower.solution().force_world()), "neither the way on");

            let differ = |by: &dyn Fn(f64) -> ([f64; 2], usize), h: f64| {
                let sides = [by(h), by(-h), by(2.0 * h), by(-2.0 * h)];
                assert!(
                    sides.iter().all(|s| s.1 == follower.solution().touching()),
                    "no change of contact in the difference"
                );
                [0, 1].map(|i| (8.0 * (sides[0].0[i] - sides[1].0[i]) - (sides[2].0[i] - sides[3].0[i])) / (12.0 * h))
            };
            let size = exact.coordinate.force[0].hypot(exact.coordinate.force[1]);
            let close = |found: [f64; 2], exact: [f64; 2], size: f64, what: &str| {
                for i in 0..2 {
                    assert!(
                        (found[i] - exact[i]).abs() < 1e-5 * size,
                        "{physics:?} {degrees}° {what}: {found:?} {exact:?}"
                    );
                }
            };
            let h = 2e-4;
            let found = differ(&|d| force(centre, radius, degrees + d), h).map(f64::to_degrees);
            close(found, exact.coordinate.force, size, "α");
            let size = exact.centre[0].force[0].hypot(exact.centre[0].force[1]);
            close(differ(&|d| force([centre[0] + d, centre[1]], radius, degrees), h), exact.centre[0].force, size, "x");
            close(differ(&|d| force([centre[0], centre[1] + d], radius, degrees), h), exact.centre[1].force, size, "y");
            close(differ(&|d| force(centre, radius + d, degrees), h), exact.radius.force, size, "r");
        }
    }
}

/// Front end of the fifth lamella under a dead load there, applied in steps.
fn loaded_point(how: &Discretisation) -> [f64; 2] {
    let design = ladder_80();
    let far = ObjectDesign::Circle { centre: [500.0, 45.0], radius: 10.0 };
    let mut follower = solver(&design, how, far);
    for step in 1..=10 {
        follower.set_dead_load(4, [-1.2 * f64::from(step), 0.4 * f64::from(step)]);
        let outcome = follower.follow(0.0);
        assert!(outcome.status.is_trustworthy(), "{outcome:?}");
    }
    follower.solution().lamellae().nth(4).expect("seven lamellae")[0]
}

#[test]
fn the_ladder_under_a_dead_load_converges_at_the_schemes_orders() {
    let how = |scheme, level: u16| Discretisation {
        scheme,
        elements: Elements::PerSpan { span: 2 * level, tip_span: 4 * level, hinge: level },
        sampling: Sampling::Nodes,
        softness: Softness::Fixed(0.0),
        physics: Physics::Paper,
    };
    let limit = loaded_point(&how(Scheme::Simpson, 8));
    for (scheme, levels, range) in
        [(Scheme::Paper, [4, 8], 0.9..1.1), (Scheme::Trapezoid, [4, 8], 1.9..2.1), (Scheme::Simpson, [2, 4], 3.5..4.5)]
    {
        let error = levels.map(|level| {
            let tip = loaded_point(&how(scheme, level));
            (tip[0] - limit[0]).hypot(tip[1] - limit[1])
        });
        let order = (error[0] / error[1]).log2() / (f64::from(levels[1]) / f64::from(levels[0])).log2();
        println!("{scheme:?}: errors {error:?} mm, order {order:.3}");
        assert!(range.contains(&order), "{scheme:?}: order {order}");
    }
}
