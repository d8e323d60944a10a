//! Beams that are bowed at rest.

use model_core::design::Design;
use model_core::discretise::{Discretisation, Physics, Scheme};
use model_core::equilibrium::Follower;
use model_core::object::{Motion, ObjectDesign};
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
