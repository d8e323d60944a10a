//! One Newton iteration per count (`Follower::track`) against the converged solution of the same model, over closing and opening.

use model_core::design::{Attachments, Profile};
use model_core::discretise::{Discretisation, Physics, Sampling};
use model_core::equilibrium::{Follower, Tracking};
use model_core::estimator::Estimator;
use model_core::object::{Corners, Motion, ObjectDesign};
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

/// A corner turns the force as the contact slides over it. With time for one iteration in every tick, closing and opening by a few counts in each, no
/// `tracking` force is off by more than 10 mN and 0.4 %, and no `updating` one by more than 1 % or 0.05 N.
#[test]
fn a_status_says_as_much_on_a_corner() {
    // Thinner and softer than most, so that a corner is in the middle of what touches.
    let mut slender = ladder_80();
    (slender.front.tip, slender.back.tip, slender.back.base) = ([0.0, 65.6], [0.0, 65.6], [-35.6, 0.0]);
    slender.lamellae.attachments = Attachments::Heights([8.3, 16.3, 22.5, 30.3, 39.0, 45.3].into_iter().collect());
    (slender.front.thickness, slender.back.thickness) = (Profile::constant(1.54), Profile::constant(1.86));
    (slender.material.youngs_modulus, slender.motor_axis) = (42.1, [-16.0, -25.7]);
    let pentagon = [[12.67, 31.08], [42.84, 26.17], [56.84, 53.35], [35.32, 75.06], [8.02, 61.3]];
    let square = |height: f64, turn: f64| {
        let (sin, cos) = libm::sincos(turn);
        let corners = [[0.0, 0.0], [14.0, -12.0], [28.0, 0.0], [14.0, 12.0]];
        corners.map(|[x, y]| [3.2 + cos * x - sin * y, height + sin * x + cos * y])
    };
    let squares = [(30.0, 0.1), (45.0, 0.3), (45.0, -0.2), (60.0, 0.5)].map(|(height, turn)| square(height, turn));
    let mut places = vec![(slender, Corners::new(&pentagon).expect("five"))];
    places.extend(squares.map(|corners| (ladder_80(), Corners::new(&corners).expect("four"))));
    let mut counts = [0_u32; 2];
    for ((design, corners), step) in places.iter().flat_map(|place| [1.0, 2.0, 3.2, 5.0].map(|step| (place, step))) {
        let object = ObjectDesign::Polygon { corners: *corners, rounding: 1.5 };
        let how = Discretisation::reduced(Physics::Extended);
        let mut short: Box<Estimator<f32, Reduced>> = Box::new(Estimator::EMPTY);
        short.configure(design, &how).expect("a valid design");
        short.set_object(object).expect("a valid object");
        short.set_budget(1);
        let mut exact: Box<Follower<f64, Reduced>> = Box::new(Follower::EMPTY);
        exact.configure(design, &how).expect("a valid design");
        exact.set_object(object, Motion::Rotating { axis: design.motor_axis });
        assert!(exact.start(0.0));
        let ticks = (200.0 / step) as i32;
        for tick in (0..ticks).chain((0..ticks).rev()) {
            let angle = libm::round(f64::from(tick) * step) * COUNT;
            let estimate = short.update(angle);
            let outcome = exact.follow(angle);
            let [x, y] = exact.solution().force_world();
            let [found_x, found_y] = estimate.force.map(f64::from);
            let off = (found_x - x).hypot(found_y - y);
            let (kind, most) = match estimate.status {
                Status::Tracking if outcome.status == Status::Converged => (0, 0.01 + 0.004 * x.hypot(y)),
                Status::Updating if outcome.status == Status::Converged => (1, (0.01 * x.hypot(y)).max(0.05)),
                _ => continue,
            };
            counts[kind] += 1;
            assert!(off < most, "{object:?}, {step} counts, tick {tick}: {estimate:?} against ({x}, {y})");
        }
    }
    println!("{counts:?} ticks tracking, updating");
    assert!(counts[0] > 1000, "{counts:?}");
}
