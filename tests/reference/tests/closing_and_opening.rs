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
    /// Of the force vector from `trapezoid` and `paper` 170/20, relative (of the force that 0.05 N is allowed of, below it).
    trapezoid: f64,
    paper: f64,
}

fn sweep(height: f64, to: i32, allowed: f64) -> Worst {
    let design = ladder_80();
    let reduced = Discretisation::estimator(Physics::Paper);
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
    let mut trapezoid = follower(&Discretisation::full(Scheme::Trapezoid, Physics::Paper));
    let mut paper = follower(&Discretisation::full(Scheme::Paper, Physics::Paper));
    let mut worst = Worst::default();
    let mut iterations = 0;
    for count in (-3..=to).chain((-3..to).rev()) {
        let angle = f64::from(count) * COUNT;
        let estimate = estimator.update(angle);
        assert!(estimate.status.is_trustworthy(), "{height} mm, count {count}: {estimate:?}");
        iterations += u32::from(estimate.iterations);
        let force = estimate.force.map(f64::from);
        let difference = |other: &mut Follower<f64, Paper>| {
            let outcome = other.follow(angle);
            assert!(outcome.status.is_trustworthy(), "{height} mm, count {count}: {outcome:?}");
            let f = other.force_world();
            let off = (force[0] - f[0]).hypot(force[1] - f[1]);
            (off, off / f[0].hypot(f[1]).max(0.05 / allowed))
        };
        worst.twin = worst.twin.max(difference(&mut twin).0);
        worst.trapezoid = worst.trapezoid.max(difference(&mut trapezoid).1);
        worst.paper = worst.paper.max(difference(&mut paper).1);
    }
    println!(
        "{height} mm: f32 to f64 {:.1e} N; to trapezoid 170/20 {:.2} %, to paper 170/20 {:.2} % (forces below {:.1} N: of \
         that); {:.2} iterations per count",
        worst.twin,
        100.0 * worst.trapezoid,
        100.0 * worst.paper,
        0.05 / allowed,
        f64::from(iterations) / f64::from(2 * to)
    );
    worst
}

#[test]
fn the_target_model_follows_its_double_and_the_full_resolution() {
    for (height, allowed) in [(30.0, 0.01), (45.0, 0.01), (60.0, 0.015)] {
        let worst = sweep(height, 125, allowed);
        assert!(worst.twin < 2e-3, "{height} mm: {} N from the double-precision twin", worst.twin);
        assert!(worst.trapezoid < allowed, "{height} mm: {} of the force", worst.trapezoid);
        // The paper scheme's own error at this resolution is up to 3.8 %.
        assert!(worst.paper < 0.05, "{height} mm: {} of the force", worst.paper);
    }
}
