//! What the microcontroller computes, on the PC: the single-precision reduced model over closing and opening at one-count
//! steps, beside its double-precision twin and the full-resolution models at the same quantised angle.

use model_core::discretise::{Discretisation, Physics, Scheme};
use model_core::equilibrium::Follower;
use model_core::estimator::Estimator;
use model_core::object::Motion;
use model_core::size::{Paper, Reduced};
use reference_tests::{COUNT, circle_80, ladder_80};

/// Largest deviations over a sweep.
#[derive(Default)]
struct Worst {
    /// Of the force vector from the double-precision twin, N.
    twin: f64,
    /// Of the force vector from `trapezoid` and `paper` 170/20, relative (of the floor, below it).
    trapezoid: f64,
    paper: f64,
}

fn sweep(physics: Physics, height: f64, floor: f64) -> Worst {
    let to = 125;
    let design = ladder_80();
    let reduced = Discretisation::estimator(physics);
    let object = circle_80(height);
    let mut estimator: Box<Estimator<f32, Reduced>> = Box::new(Estimator::EMPTY);
    estimator.configure(&design, &reduced).expect("a valid design");
    estimator.set_object(object).expect("a valid object");
    let follower = |how: &Discretisation| {
        let mut follower: Box<Follower<f64, Paper>> = Box::new(Follower::EMPTY);
        follower.configure(&design, how).expect("a valid design");
        follower.set_object(object, Motion::Rotating { axis: design.motor_axis });
        assert!(follower.start(-3.0 * COUNT));
        follower
    };
    let mut twin = follower(&reduced);
    let mut trapezoid = follower(&Discretisation::full(Scheme::Trapezoid, physics));
    let mut paper = follower(&Discretisation::full(Scheme::Paper, physics));
    let mut worst = Worst::default();
    let mut iterations = 0;
    for count in (-3..=to).chain((-3..to).rev()) {
        let angle = f64::from(count) * COUNT;
        let estimate = estimator.update(angle);
        assert!(estimate.status.is_trustworthy(), "{physics:?}, {height} mm, count {count}: {estimate:?}");
        iterations += u32::from(estimate.iterations);
        let force = estimate.force.map(f64::from);
        let difference = |other: &mut Follower<f64, Paper>| {
            let outcome = other.follow(angle);
            assert!(outcome.status.is_trustworthy(), "{physics:?}, {height} mm, count {count}: {outcome:?}");
            let f = other.solution().force_world();
            let off = (force[0] - f[0]).hypot(force[1] - f[1]);
            (off, off / f[0].hypot(f[1]).max(floor))
        };
        worst.twin = worst.twin.max(difference(&mut twin).0);
        worst.trapezoid = worst.trapezoid.max(difference(&mut trapezoid).1);
        worst.paper = worst.paper.max(difference(&mut paper).1);
    }
    println!(
        "{physics:?}, {height} mm: f32 to f64 {:.1e} N; to trapezoid 170/20 {:.2} %, to paper 170/20 {:.2} % (forces below {:.1} N: of \
         that); {:.2} iterations per count",
        worst.twin,
        100.0 * worst.trapezoid,
        100.0 * worst.paper,
        floor,
        f64::from(iterations) / f64::from(2 * to)
    );
    worst
}

/// One height: deviations are relative to forces of at least so much (N), and allowed up to so much.
struct Allowed {
    height: f64,
    floor: f64,
    trapezoid: f64,
    paper: f64,
}

fn follows(physics: Physics, heights: [Allowed; 3]) {
    for Allowed { height, floor, trapezoid, paper } in heights {
        let worst = sweep(physics, height, floor);
        assert!(worst.twin < 1e-3, "{physics:?}, {height} mm: {} N from the double-precision twin", worst.twin);
        assert!(worst.trapezoid < trapezoid, "{physics:?}, {height} mm: {} of the force", worst.trapezoid);
        assert!(worst.paper < paper, "{physics:?}, {height} mm: {} of the force", worst.paper);
    }
}

const fn at(height: f64, floor: f64, trapezoid: f64, paper: f64) -> Allowed {
    Allowed { height, floor, trapezoid, paper }
}

#[test]
fn the_paper_physics_follows_its_double_and_the_full_resolution() {
    // Measured: trapezoid 0.26, 0.55, 1.36 %; paper 1.1, 2.8, 3.9 %, which is that scheme's own error at 170/20.
    let allowed = [at(30.0, 5.0, 0.01, 0.05), at(45.0, 5.0, 0.01, 0.05), at(60.0, 10.0 / 3.0, 0.015, 0.05)];
    follows(Physics::Paper, allowed);
}

#[test]
fn the_extended_physics_follows_its_double_and_the_full_resolution() {
    // Measured: trapezoid 0.24, 0.24, 0.60 %; paper 1.07, 0.52, 0.70 %. A ladder that stretches is softer: 13.6
    // instead of 35.7 N at Mid, 11°.
    let allowed = [at(30.0, 5.0, 0.003, 0.012), at(45.0, 5.0, 0.003, 0.006), at(60.0, 10.0 / 3.0, 0.007, 0.008)];
    follows(Physics::Extended, allowed);
}
