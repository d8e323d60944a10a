//! The contact's softness is the front beam's own: what it takes from the force is as small a part for every material.

use model_core::discretise::{Discretisation, Physics, Sampling, Softness};
use model_core::equilibrium::Follower;
use model_core::object::{Motion, ObjectDesign};
use model_core::real::Real;
use model_core::size::{Reduced, Size};
use model_core::status::Status;
use reference_tests::{circle_80, ladder_80};

model_core::fixed_size!(
    /// Room for many samples.
    Wide, cells 8, nodes 256, samples 700, contacts 100
);

/// Magnitude of the force over Young's modulus, mm², of `ladder-80` of a modulus (MPa).
fn force<T: Real, S: Size>(modulus: f64, how: &Discretisation, object: ObjectDesign, degrees: f64) -> f64 {
    let mut design = ladder_80();
    design.material.youngs_modulus = modulus;
    let mut finger: Box<Follower<T, S>> = Box::new(Follower::EMPTY);
    finger.configure(&design, how).expect("a valid design");
    finger.set_object(object, Motion::Rotating { axis: design.motor_axis });
    assert!(finger.start(-0.1), "{object:?}: no open hand");
    let status = finger.follow(degrees.to_radians()).status;
    assert_eq!(status, Status::Converged, "{modulus} MPa, {object:?}");
    let [x, y] = finger.solution().force_world().map(Real::to_f64);
    x.hypot(y) / modulus
}

fn objects() -> Vec<(ObjectDesign, f64)> {
    let circles = [circle_80(30.0), circle_80(45.0), circle_80(60.0)].into_iter().flat_map(|o| [(o, 2.0), (o, 8.0)]);
    let pins = [10.0, 27.0, 40.0, 58.7, 76.0].map(|y| (ObjectDesign::Circle { centre: [3.5, y], radius: 1.5 }, 5.0));
    let wall = (ObjectDesign::HalfPlane { point: [4.0, 70.0], normal: [-1.0, -0.25] }, 3.0);
    circles.chain(pins).chain([wall]).collect()
}

#[test]
fn it_takes_as_little_of_the_force_of_every_material() {
    for (object, degrees) in objects() {
        let with = |softness, samples| Discretisation {
            softness,
            sampling: Sampling::PerElement(samples),
            ..Discretisation::fine(Physics::Extended)
        };
        // So many samples that the force does not depend on which of them touch. Without softness it would be larger by as much as it is
        // smaller with twice of it.
        let own = 1.0 / (49.5 * 20.0);
        let [once, twice] =
            [1.0, 2.0].map(|times| force::<f64, Wide>(49.5, &with(Softness::Fixed(times * own), 16), object, degrees));
        let expected = once + (once - twice);
        for modulus in [0.1, 3.0, 49.5, 3.5e3, 210e3] {
            let found = force::<f64, Wide>(modulus, &with(Softness::Local, 16), object, degrees);
            println!("{object:?} {degrees} {modulus} {:+.3} %", 100.0 * (found / expected - 1.0));
            assert!((found / expected - 1.0).abs() < 2e-3, "{modulus} MPa, {object:?}: {found} against {expected} mm²");
            // The gripper's model, in single precision, beside its own in double precision.
            let reduced = Discretisation::estimator(Physics::Extended);
            let single = force::<f32, Reduced>(modulus, &reduced, object, degrees);
            let double = force::<f64, Wide>(modulus, &reduced, object, degrees);
            println!("   {:+.3} %", 100.0 * (single / double - 1.0));
            assert!((single / double - 1.0).abs() < 1e-3, "{modulus} MPa, {object:?}: {single} against {double} mm²");
        }
    }
}
