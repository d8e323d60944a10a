//! Beams that are bowed at rest.

use model_core::design::{Attachments, Design};
use model_core::discretise::{Discretisation, Elements, Physics, Scheme};
use model_core::equilibrium::Follower;
use model_core::object::{Motion, ObjectDesign};
use model_core::real::Real;
use model_core::size::Paper;
use model_core::status::Status;
use reference_tests::ladder_80;

fn bowed(sagitta: [f64; 2]) -> Design {
    let mut design = ladder_80();
    [design.front.sagitta, design.back.sagitta] = sagitta;
    design
}

/// Force and tip, finger frame, on a circle that the undeformed front touches at 0° and Mid height.
fn pressed(design: &Design, how: &Discretisation, degrees: f64) -> ([f64; 2], [f64; 2]) {
    let mut follower: Box<Follower<f64, Paper>> = Box::new(Follower::EMPTY);
    follower.configure(design, how).expect("a valid design");
    let arc = design.front.arc_at_height(45.0);
    let ([x, y], [tx, ty]) = (design.front.point(arc), design.front.direction(arc));
    let centre = [x + 41.0 * ty, y - 41.0 * tx];
    follower.set_object(ObjectDesign::Circle { centre, radius: 40.0 }, Motion::Rotating { axis: design.motor_axis });
    assert!(follower.start(0.0));
    let outcome = follower.follow(degrees.to_radians());
    assert_eq!(outcome.status, Status::Converged, "{outcome:?}");
    (follower.solution().force_finger(), follower.solution().tip())
}

#[test]
fn the_undeformed_centreline_is_the_arc() {
    let design = bowed([3.0, -2.0]);
    for how in [Discretisation::fine(Physics::Extended), Discretisation::full(Scheme::Trapezoid, Physics::Paper)] {
        let mut follower: Box<Follower<f64, Paper>> = Box::new(Follower::EMPTY);
        follower.configure(&design, &how).expect("a valid design");
        for (line, beam) in [
            (follower.solution().front().collect::<Vec<_>>(), &design.front),
            (follower.solution().back().collect(), &design.back),
        ] {
            let arc = |p: &[f64; 2]| beam.arc_at_height(p[1]);
            let off = |p: &[f64; 2]| (p[0] - beam.point(arc(p))[0]).abs();
            let worst = line.iter().map(off).fold(0.0, f64::max);
            assert!(worst < 2e-3, "{:?}: {worst} mm off the arc", how.scheme);
        }
    }
}

#[test]
fn a_slight_bow_changes_the_force_slightly_and_a_straight_one_not_at_all() {
    let how = Discretisation::fine(Physics::Extended);
    let (straight, _) = pressed(&ladder_80(), &how, 6.0);
    let (same, _) = pressed(&bowed([1e-12, 0.0]), &how, 6.0);
    let change = |sagitta| {
        let (force, _) = pressed(&bowed([sagitta, sagitta]), &how, 6.0);
        [force[0] - straight[0], force[1] - straight[1]]
    };
    assert!((same[0] - straight[0]).hypot(same[1] - straight[1]) < 1e-9);
    let (half, whole, other) = (change(0.05), change(0.1), change(-0.1));
    for i in 0..2 {
        assert!((whole[i] - 2.0 * half[i]).abs() < 0.1 * whole[i].abs() + 1e-4, "{half:?} {whole:?}");
        assert!((whole[i] + other[i]).abs() < 0.1 * whole[i].abs() + 1e-4, "{whole:?} {other:?}");
    }
}

#[test]
fn schemes_agree_on_a_bowed_finger() {
    let design = bowed([4.0, 4.0]);
    let (fine, tip) = pressed(&design, &Discretisation::fine(Physics::Paper), 8.0);
    let (reduced, _) = pressed(&design, &Discretisation::reduced(Physics::Paper), 8.0);
    let (links, other) = pressed(&design, &Discretisation::full(Scheme::Trapezoid, Physics::Paper), 8.0);
    let size = fine[0].hypot(fine[1]);
    println!("bowed by 4 mm, 8°: fine {fine:?}, trapezoid 170/20 {links:?}, reduced {reduced:?}");
    assert!((fine[0] - links[0]).hypot(fine[1] - links[1]) < 0.01 * size);
    assert!((fine[0] - reduced[0]).hypot(fine[1] - reduced[1]) < 0.02 * size);
    assert!((tip[0] - other[0]).hypot(tip[1] - other[1]) < 0.05);
}

model_core::fixed_size!(
    /// Room for many elements on few spans.
    Few, cells 4, nodes 640, samples 300, contacts 120
);

/// Force, N, finger frame, and the tip of the open finger, of a finger with few lamellae closed on a cylinder of 40 mm.
fn gripped<T: Real>(design: &Design, how: &Discretisation, centre: [f64; 2], degrees: f64) -> ([f64; 2], [f64; 2]) {
    let mut follower: Box<Follower<T, Few>> = Box::new(Follower::EMPTY);
    follower.configure(design, how).expect("a valid design");
    let tip = follower.solution().tip().map(T::to_f64);
    follower.set_object(ObjectDesign::Circle { centre, radius: 20.0 }, Motion::Rotating { axis: design.motor_axis });
    assert!(follower.start(-2_f64.to_radians()));
    assert_eq!(follower.follow(degrees.to_radians()).status, Status::Converged, "{how:?}");
    (follower.solution().force_finger().map(T::to_f64), tip)
}

/// Long spans have enough elements and samples, at the PC's resolution and at the microcontroller's: straight beams, and a line with a bend or two
/// on a single span, which ends where it is drawn.
#[test]
fn few_spans_are_fine_enough() {
    let many = Discretisation {
        elements: Elements::PerBeam { beam: 64, hinge: 4 },
        ..Discretisation::fine(Physics::Extended)
    };
    let mut worst = [0.0_f64; 2];
    let mut compare = |design: &Design, centre: [f64; 2], degrees: f64, within: [f64; 2], what: &str| {
        let (exact, _) = gripped::<f64>(design, &many, centre, degrees);
        let (fine, tip) = gripped::<f64>(design, &Discretisation::fine(Physics::Extended), centre, degrees);
        let (reduced, _) = gripped::<f32>(design, &Discretisation::estimator(Physics::Extended), centre, degrees);
        let size = exact[0].hypot(exact[1]);
        let off = [fine, reduced].map(|found| (found[0] - exact[0]).hypot(found[1] - exact[1]) / size);
        println!("{what}, {degrees}°: {size:.3} N, off by {off:.4?}, tip {tip:.3?}");
        assert!(off[0] < within[0] && off[1] < within[1], "{what}, {degrees}°: {off:?}");
        assert!((tip[0]).hypot(tip[1] - 80.0) < 0.05, "{what}: {tip:?}");
        worst = [worst[0].max(off[0]), worst[1].max(off[1])];
    };
    for heights in [&[][..], &[10.0], &[40.0], &[20.0, 50.0], &[9.0, 18.0, 27.0]] {
        let mut design = ladder_80();
        design.lamellae.attachments = Attachments::Heights(heights.iter().copied().collect());
        for (height, degrees) in [(30.0, 4.0), (45.0, 6.0)] {
            compare(&design, [21.0, height], degrees, [0.02, 0.03], &format!("lamellae at {heights:?}"));
        }
    }
    let mut wavy = ladder_80();
    wavy.lamellae.attachments = Attachments::Heights([].into_iter().collect());
    wavy.front.via = [[2.0, 20.0], [0.0, 40.0], [-2.0, 60.0]].into_iter().collect();
    for degrees in [6.0, 8.0] {
        compare(&wavy, [24.0, 40.0], degrees, [0.02, 0.05], "a wave");
    }
}
