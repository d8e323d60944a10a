//! Concave objects: a cylinder from inside, of every radius down to the finger's own.

use model_core::design::Design;
use model_core::discretise::{Discretisation, Physics, Scheme};
use model_core::equilibrium::Follower;
use model_core::object::{Motion, ObjectDesign};
use model_core::real::Real;
use model_core::size::{Reduced, Size};
use model_core::status::Status;
use reference_tests::ladder_80;

model_core::fixed_size!(
    /// Room for a beam that touches all along.
    Wide, cells 8, nodes 704, samples 184, contacts 190
);

/// A bore whose wall has a given place and inward normal.
fn bore(wall: [f64; 2], [nx, ny]: [f64; 2], radius: f64) -> ObjectDesign {
    ObjectDesign::Bore { centre: [wall[0] + radius * nx, wall[1] + radius * ny], radius }
}

fn follower<T: Real, S: Size>(design: &Design, how: &Discretisation, object: ObjectDesign) -> Box<Follower<T, S>> {
    object.validate().expect("a good object");
    let mut follower: Box<Follower<T, S>> = Box::new(Follower::EMPTY);
    follower.configure(design, how).expect("a valid design");
    follower.set_object(object, Motion::Rotating { axis: design.motor_axis });
    follower
}

/// A place of a wall in front of the finger near its tip, and its normal, which leans towards the tip.
fn wall(lean: f64) -> ([f64; 2], [f64; 2]) {
    let (sin, cos) = lean.sin_cos();
    ([4.0, 76.0], [-cos, -sin])
}

#[test]
fn a_finger_in_a_bore_is_stable() {
    // Below the place the wall comes nearer again: it leans so far that the clamped base stays clear.
    for (radius, lean) in [(200.0, 0.4), (200.0, 0.6), (120.0, 0.6), (80.0, 0.75)] {
        let (place, normal) = wall(lean);
        let object = bore(place, normal, radius);
        for how in [Discretisation::fine(Physics::Extended), Discretisation::full(Scheme::Trapezoid, Physics::Extended)]
        {
            let mut finger: Box<Follower<f64, Wide>> = follower(&ladder_80(), &how, object);
            assert!(finger.start(-0.2), "R {radius}: no open hand");
            let mut last = 0.0;
            for half_degrees in -20..=16 {
                let outcome = finger.follow((0.5 * f64::from(half_degrees)).to_radians());
                let [x, y] = finger.solution().force_world();
                assert!(
                    matches!(outcome.status, Status::Converged | Status::NoContact),
                    "R {radius}, {half_degrees}/2°: {outcome:?}"
                );
                last = x.hypot(y);
            }
            assert!(last > 0.5, "R {radius}: {last} N");
        }
    }
}

#[test]
fn a_bore_of_two_kilometres_is_a_wall() {
    let how = Discretisation::estimator(Physics::Extended);
    for lean in [0.05, 0.15, 0.3] {
        let (place, normal) = wall(lean);
        let flat = ObjectDesign::HalfPlane { point: place, normal };
        fn force<T: Real>(how: &Discretisation, object: ObjectDesign) -> [f64; 3] {
            let mut finger: Box<Follower<T, Reduced>> = follower(&ladder_80(), how, object);
            assert!(finger.start(-0.2));
            let status = finger.follow(6.0_f64.to_radians()).status;
            assert_eq!(status, Status::Converged, "{object:?}");
            let [x, y] = finger.solution().force_world().map(Real::to_f64);
            [x, y, finger.solution().motor_torque().to_f64()]
        }
        let (expected, wide) = (force::<f64>(&how, flat), bore(place, normal, 2e6));
        for found in [force::<f64>(&how, wide), force::<f32>(&how, wide)] {
            let size = expected[0].hypot(expected[1]);
            let off = (found[0] - expected[0]).hypot(found[1] - expected[1]);
            assert!(off < 1e-3 * size && (found[2] / expected[2] - 1.0).abs() < 1e-3, "{found:?} against {expected:?}");
        }
    }
}

/// The finger's front is an arc, and the bore's wall the same one: all of it comes near at once.
#[test]
fn a_bore_may_have_the_fingers_own_radius() {
    let mut design = ladder_80();
    (design.front.sagitta, design.back.sagitta) = (4.0, 4.0);
    let own = 1.0 / design.front.curvature() + 1.0;
    let arc = 0.5 * design.front.length();
    let ([x, y], [tx, ty]) = (design.front.point(arc), design.front.direction(arc));
    let mut forces = Vec::new();
    for radius in [0.9 * own, own * (1.0 - 1e-6), own, own * (1.0 + 1e-6), 1.1 * own] {
        // Half a thickness and 2 mm in front of the centreline: turned about the motor axis, the tip comes first.
        let object = bore([x + 3.0 * ty, y - 3.0 * tx], [-ty, tx], radius);
        let how = Discretisation::fine(Physics::Extended);
        let mut finger: Box<Follower<f64, Wide>> = follower(&design, &how, object);
        assert!(finger.start(0.0), "R {radius}: no open hand");
        for step in 0..=30 {
            let outcome = finger.follow((0.1 * f64::from(step)).to_radians());
            assert!(outcome.status.is_trustworthy(), "R {radius}, step {step}: {outcome:?}");
        }
        let [x, y] = finger.solution().force_world();
        forces.push(x.hypot(y));
    }
    assert!(forces.iter().all(|&force| force > 1.0), "{forces:?}");
    // A millionth of the radius is a fraction of a micrometre.
    assert!((forces[1] - forces[2]).abs() < 2e-3 * forces[2], "{forces:?}");
    assert!((forces[3] - forces[2]).abs() < 2e-3 * forces[2], "{forces:?}");
}
