//! One Newton iteration per count (`Follower::track`) against the converged solution of the same model, over closing and opening.

use model_core::discretise::{Discretisation, Physics, Sampling};
use model_core::equilibrium::{Follower, Tracking};
use model_core::object::Motion;
use model_core::size::Reduced;
use model_core::status::Status;
use reference_tests::{COUNT, circle_80, ladder_80};

/// Newton iterations allowed where one is not enough.
const BUDGET: u32 = 8;

fn ready(how: &Discretisation, height: f64) -> Box<Follower<f32, Reduced>> {
    let design = ladder_80();
    let mut follower: Box<Follower<f32, Reduced>> = Box::new(Follower::EMPTY);
    follower.configure(&design, how).expect("a valid design");
    follower.set_object(circle_80(height), Motion::Rotating { axis: design.motor_axis });
    assert!(follower.start(0.0));
    follower
}

/// Largest error of the force, N, ticks in contact, and those of them that were content with one iteration.
fn closing_and_opening(how: &Discretisation, height: f64, last: i32) -> (f64, u32, u32) {
    let (mut tracked, mut converged) = (ready(how, height), ready(how, height));
    let (mut worst, mut ticks, mut single) = (0.0_f64, 0, 0);
    let mut residual = (0.0_f64, 0.0_f64);
    for count in (0..=last).chain((0..last).rev()) {
        let angle = f64::from(count) * COUNT;
        let outcome = tracked.track(angle, Tracking::DEFAULT, BUDGET);
        let reference = converged.follow(angle);
        assert!(outcome.status.is_trustworthy() && reference.status.is_trustworthy(), "{angle}: {outcome:?}");
        if converged.solution().touching() == 0 {
            continue;
        }
        ticks += 1;
        if outcome.status == Status::Tracking {
            single += 1;
            residual = (residual.0.max(outcome.gradient), residual.1.max(outcome.length));
        }
        let (found, exact) = (tracked.solution().force_world(), converged.solution().force_world());
        worst = worst.max(f64::from((found[0] - exact[0]).hypot(found[1] - exact[1])));
    }
    println!(
        "height {height} mm, {:?}: largest error {:.2} mN, {single} of {ticks} ticks with one iteration, residuals to {:.2} N·mm, {:.4} mm",
        how.sampling,
        1e3 * worst,
        residual.0,
        residual.1
    );
    (worst, ticks, single)
}

#[test]
fn one_iteration_per_count_stays_within_10_millinewtons() {
    for samples in [2, 4, 5] {
        let how =
            Discretisation { sampling: Sampling::PerElement(samples), ..Discretisation::reduced(Physics::Extended) };
        for (height, last) in [(20.0, 125), (45.0, 125), (60.0, 110)] {
            let (worst, ticks, single) = closing_and_opening(&how, height, last);
            assert!(worst < 0.01, "{samples} samples, height {height} mm: off by {worst} N");
            assert!(single * 2 > ticks, "{single} of {ticks} ticks only");
        }
    }
}

#[test]
fn a_jump_of_the_angle_is_followed_to_convergence() {
    let how = Discretisation::estimator(Physics::Extended);
    let mut follower = ready(&how, 45.0);
    let outcome = follower.track(0.1, Tracking::DEFAULT, 1000);
    assert_eq!(outcome.status, Status::Converged);
    let outcome = follower.track(f64::NAN, Tracking::DEFAULT, BUDGET);
    assert_eq!(outcome.status, Status::OutOfRange);
}
