//! Fingers of every length and stiffness: single precision against double, and scaled fingers against the one they are scaled from.

use model_core::design::{Attachments, Design, Profile};
use model_core::discretise::{Discretisation, Physics};
use model_core::equilibrium::Follower;
use model_core::object::{Motion, ObjectDesign};
use model_core::real::Real;
use model_core::size::Paper;
use model_core::status::Status;
use reference_tests::ladder_80;
use reference_tests::twins::Solvers;
use reference_tests::wide::WideCases;

fn closed<T: Real>(design: &Design, how: &Discretisation, object: ObjectDesign, degrees: f64) -> (Status, [f64; 2]) {
    let mut follower: Box<Follower<T, Paper>> = Box::new(Follower::EMPTY);
    follower.configure(design, how).expect("a valid finger");
    follower.set_object(object, Motion::Rotating { axis: design.motor_axis });
    assert!(follower.start(degrees.to_radians()), "the object lies clear of the open finger");
    let status = follower.follow(degrees.to_radians()).status;
    (status, follower.solution().force_world().map(Real::to_f64))
}

/// Distance of the forces in single and in double precision as a part of the latter; both must be trustworthy.
fn single_against_double(design: &Design, object: ObjectDesign, degrees: f64) -> f64 {
    let how = Discretisation::fine(Physics::Extended);
    let (single, f) = closed::<f32>(design, &how, object, degrees);
    let (double, d) = closed::<f64>(design, &how, object, degrees);
    println!("{degrees}°: f32 {single} {:.4} N, f64 {double} {:.4} N", f[0].hypot(f[1]), d[0].hypot(d[1]));
    assert!(single.is_trustworthy() && double.is_trustworthy(), "{single} {double}");
    (f[0] - d[0]).hypot(f[1] - d[1]) / d[0].hypot(d[1])
}

fn mid() -> ObjectDesign {
    ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 }
}

#[test]
fn a_stiff_finger_with_a_thin_foot_converges_in_single_precision() {
    let mut design = ladder_80();
    design.material.youngs_modulus = 2000.0;
    let taper = Profile { knots: heapless::Vec::from_iter([[0.0, 0.5], [5.0, 3.5], [80.0, 3.5]]) };
    (design.front.thickness, design.back.thickness) = (taper.clone(), taper);
    let off = single_against_double(&design, mid(), 4.0);
    assert!(off < 1e-3, "{off:e}");
}

#[test]
fn hinges_that_are_almost_welds_converge_in_single_precision() {
    let mut design = ladder_80();
    design.hinge.length = heapless::Vec::from_iter([0.01]);
    design.hinge.thickness = 3.0;
    for degrees in [7.0, 9.0] {
        let off = single_against_double(&design, mid(), degrees);
        assert!(off < 1e-3, "{degrees}°: {off:e}");
    }
}

/// A finger `times` as long, and everything else in it, of another modulus.
fn scaled(design: &Design, times: f64, youngs_modulus: f64) -> Design {
    let mut design = design.clone();
    let profile = |profile: &mut Profile| profile.knots.iter_mut().flatten().for_each(|x| *x *= times);
    profile(&mut design.width);
    for beam in [&mut design.front, &mut design.back] {
        beam.base.iter_mut().chain(&mut beam.tip).for_each(|x| *x *= times);
        profile(&mut beam.thickness);
    }
    if let Attachments::Heights(heights) = &mut design.lamellae.attachments {
        heights.iter_mut().for_each(|x| *x *= times);
    }
    design.lamellae.thickness.iter_mut().flatten().for_each(|thickness| *thickness *= times);
    design.hinge.length.iter_mut().for_each(|x| *x *= times);
    design.hinge.thickness *= times;
    design.motor_axis.iter_mut().for_each(|x| *x *= times);
    design.material.youngs_modulus = youngs_modulus;
    design
}

#[test]
fn a_tiny_soft_finger_is_as_exact_as_a_large_one() {
    let tiny = scaled(&ladder_80(), 0.1, 1.0);
    for height in [3.0, 4.5, 6.0] {
        let object = ObjectDesign::Circle { centre: [4.1, height], radius: 4.0 };
        for degrees in [0.2, 0.5, 1.0, 2.0, 4.0, 8.0] {
            let off = single_against_double(&tiny, object, degrees);
            assert!(off < 1e-3, "{height} mm, {degrees}°: {off:e}");
        }
    }
}

/// Force goes with E L², whatever the length and the modulus: to the last bit where both scales are powers of two, for the solver sees
/// the same numbers.
#[test]
fn forces_scale_with_modulus_and_length_squared() {
    let how = Discretisation::reduced(Physics::Extended);
    let (status, force) = closed::<f32>(&ladder_80(), &how, mid(), 8.0);
    assert_eq!(status, Status::Converged);
    for (times, modulus) in [(0.25, 49.5 / 16.0), (16.0, 49.5 * 1024.0), (0.06, 5.0), (25.0, 210e3), (1.3, 70.0)] {
        let object = ObjectDesign::Circle { centre: [41.0 * times, 45.0 * times], radius: 40.0 * times };
        let (status, scaled) = closed::<f32>(&scaled(&ladder_80(), times, modulus), &how, object, 8.0);
        assert_eq!(status, Status::Converged);
        let back = scaled.map(|f| f / (times * times * modulus / 49.5));
        println!("{times} times as long, {modulus} MPa: {scaled:?} N, that is {back:?}");
        let exact = times.log2().fract() == 0.0 && (modulus / 49.5).log2().fract() == 0.0;
        let allowed = if exact { 0.0 } else { 2e-4 * force[0].abs() };
        for i in 0..2 {
            assert!((back[i] - force[i]).abs() <= allowed, "{times}, {modulus}: {back:?} {force:?}");
        }
    }
}

/// The large run is `cargo xtask bench scales`.
#[test]
fn random_fingers_of_every_scale_agree_in_both_precisions() {
    let mut solvers = Solvers::new();
    for physics in [Physics::Paper, Physics::Extended] {
        let (mut trustworthy, mut apart) = (0, 0);
        const CASES: usize = 400;
        for (number, case) in WideCases::seeded(80).take(CASES).enumerate() {
            let twins = solvers.close(&case, physics);
            let single = twins.single.status.is_trustworthy();
            trustworthy += usize::from(single);
            let fold = twins.single.status == Status::Folded && twins.double.status != Status::Folded;
            assert!(!fold, "rounding is no fold: case {number}, {physics:?}: {twins}");
            let agrees = single && twins.double.status.is_trustworthy() && twins.difference() <= 1e-3;
            if !agrees {
                println!("case {number}, {physics:?}: {twins}");
                apart += usize::from(single);
            }
        }
        assert!(trustworthy * 100 >= CASES * 98, "{trustworthy} of {CASES}");
        // Where a step of 1° may land on either of two branches.
        assert!(apart * 100 <= CASES, "{apart} of {CASES}");
    }
}
