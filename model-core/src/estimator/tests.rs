use std::boxed::Box;

use super::*;
use crate::discretise::Physics;
use crate::drive::{Knots, Travel};
use crate::object::Motion;
use crate::random_designs::{Random, random_case};
use crate::size::{Reduced, Rubbing};

pub(super) const COUNT: f64 = core::f64::consts::TAU / 4096.0;

#[test]
fn slope_and_standard_deviation_come_with_the_force_and_keep_young() {
    let mut estimator: Box<Estimator<f32, Reduced>> = Box::new(Estimator::EMPTY);
    let design = crate::design::ladder_80();
    estimator.configure(&design, &Discretisation::estimator(Physics::Extended)).expect("a valid finger");
    estimator.set_object(ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 }).expect("a valid object");
    // The angle alone is uncertain.
    let given = Uncertainty { quantisation: COUNT as f32, zero_angle: 0.003, ..Uncertainty::NONE };
    estimator.set_uncertainty(given).expect("allowed values");
    let mut forces = [[0.0_f32; 2]; 17];
    let mut compared = 0;
    for tick in -40..=100 {
        let estimate = estimator.update(f64::from(tick) * COUNT);
        assert!(estimate.status.is_trustworthy(), "{estimate:?}");
        if estimate.force == [0.0; 2] {
            assert_eq!((estimate.standard_deviation, estimate.force_per_angle), (0.0, [0.0; 2]));
            continue;
        }
        assert!(estimate.sensitivity_age <= 2 * DIFFERENTIATE_EVERY, "{estimate:?}");
        let [slope_x, slope_y] = estimate.force_per_angle;
        let along = (slope_x * estimate.force[0] + slope_y * estimate.force[1]) / estimate.force_magnitude();
        let expected = along.abs() * libm::sqrtf(0.003 * 0.003 + given.quantisation * given.quantisation / 12.0);
        assert!((estimate.standard_deviation - expected).abs() < 0.05 * expected, "{estimate:?} {expected}");
        forces.rotate_left(1);
        forces[16] = estimate.force;
        // The mean slope over 16 counts, about that in their middle.
        if forces[0] != [0.0; 2] && estimate.sensitivity_age >= DIFFERENTIATE_EVERY - 1 {
            let mean = (forces[16][0] - forces[0][0]) / (16.0 * COUNT as f32);
            assert!((slope_x - mean).abs() < 0.1 * mean.abs(), "count {tick}: {slope_x} {mean}");
            compared += 1;
        }
    }
    assert!(compared >= 3, "{compared}");
    // Opening that far takes several ticks.
    let open = (0..50).map(|_| estimator.update(-0.1)).last().expect("fifty ticks");
    assert_eq!((open.status, open.standard_deviation, open.sensitivity_age), (Status::NoContact, 0.0, 0));
}

/// In one-iteration mode a tick that is pursued to convergence follows one that is not, and the other way round: no reason to take
/// derivatives in the very tick that costs most.
#[test]
fn a_tick_that_is_pursued_to_convergence_takes_no_derivatives() {
    let mut estimator: Box<Estimator<f32, Reduced>> = Box::new(Estimator::EMPTY);
    let design = crate::design::ladder_80();
    estimator.configure(&design, &Discretisation::estimator(Physics::Extended)).expect("a valid finger");
    estimator.set_object(ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 }).expect("a valid object");
    let content = EstimatorSettings { one_iteration: Some(Tracking::DEFAULT), ..EstimatorSettings::DEFAULT };
    estimator.set_settings(content, Settings::DEFAULT).expect("allowed");
    let (mut flips, mut costly, mut last) = (0, 0, Estimate::blank(Status::NoContact));
    // A count at a time, with a leap of 6 counts now and then.
    for tick in -20_i32..150 {
        let count = tick + 6 * (tick + 20).div_euclid(9);
        let estimate = estimator.update(f64::from(count) * COUNT * 0.5);
        assert!(estimate.status.is_trustworthy(), "{estimate:?}");
        let was_known = last.standard_deviation > 0.0 && last.standard_deviation.is_finite();
        let is_flip = estimate.status != last.status && was_known;
        let is_costly = u32::from(estimate.iterations) > DIFFERENTIATE_WITHIN;
        (flips, costly) = (flips + u32::from(is_flip), costly + u32::from(is_costly));
        let is_fresh = estimate.sensitivity_age == 0;
        assert!(!(was_known && is_costly && is_fresh), "tick {tick}: {estimate:?} after {last:?}");
        assert!(estimate.force == [0.0; 2] || estimate.standard_deviation.is_finite(), "{estimate:?}");
        last = estimate;
    }
    assert!(flips > 10 && costly > 3, "{flips} flips, {costly} ticks of many iterations");
}

/// Parallel jaws, in proportion and by a crank's table, against the same model followed along the line: force, torque by the motor's
/// work, slope by differences.
#[test]
fn jaws_that_translate_are_followed_by_the_motor_angle() {
    let object = ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 };
    let knots: std::vec::Vec<[f32; 2]> =
        (0..6).map(|k| -0.4 + 0.3 * k as f32).map(|angle| [angle, 12.0 * libm::sinf(angle)]).collect();
    let table = Travel::Table(Knots::new(&knots).expect("six knots"));
    for travel in [Travel::Linear { mm_per_rad: 10.0 }, table] {
        let drive = Drive::Translating { direction: [2.0, 0.0], travel };
        let mut estimator: Box<Estimator<f64, Reduced>> = Box::new(Estimator::EMPTY);
        let design = crate::design::ladder_80();
        let how = Discretisation::estimator(Physics::Extended);
        estimator.set_drive(drive).expect("an allowed drive");
        estimator.configure(&design, &how).expect("a valid finger");
        estimator.set_object(object).expect("a valid object");
        let given = Uncertainty { zero_angle: 0.003, ..Uncertainty::NONE };
        estimator.set_uncertainty(given).expect("allowed values");
        let mut follower: Box<Follower<f64, Reduced>> = Box::new(Follower::EMPTY);
        follower.configure(&design, &how).expect("a valid finger");
        follower.set_object(object, Motion::Translating { direction: [1.0, 0.0] });
        assert!(follower.start(-1.0));
        let mut compared = 0;
        let mut before: Option<(f64, f64, [f64; 2])> = None;
        for tick in -60..=420 {
            let angle = f64::from(tick) * COUNT;
            let estimate = estimator.update(angle);
            assert!(estimate.status.is_trustworthy() && estimate.motor_angle == angle as f32, "{estimate:?}");
            let [distance, ratio] = drive.coordinate(angle).expect("within the table");
            let exact = follower.follow(distance);
            assert!(exact.status.is_trustworthy());
            let force = follower.solution().force_world();
            for i in 0..2 {
                assert!((f64::from(estimate.force[i]) - force[i]).abs() < 1e-4, "{estimate:?} {force:?}");
            }
            assert!((f64::from(estimate.torque) - ratio * force[0]).abs() < 1e-3, "{estimate:?}");
            // The motor's work is the energy's.
            let potential = follower.solution().potential();
            if let Some((last, torque, then)) = before
                && tick % 16 == 0
                && torque > 5.0
            {
                let work = 0.5 * (torque + f64::from(estimate.torque)) * 16.0 * COUNT;
                assert!((potential - last - work).abs() < 0.02 * work, "{} {work}", potential - last);
                let slope = (force[0] - then[0]) / (16.0 * COUNT);
                let given = f64::from(estimate.force_per_angle[0]);
                assert!((given - slope).abs() < 0.15 * slope.abs() + 0.3, "{given} {slope} at {angle}");
                let along = f64::from(
                    estimate.force_per_angle[0] * estimate.force[0] + estimate.force_per_angle[1] * estimate.force[1],
                ) / f64::from(estimate.force_magnitude());
                let deviation = f64::from(estimate.standard_deviation);
                assert!((deviation - 0.003 * along.abs()).abs() < 0.05 * deviation, "{estimate:?}");
                compared += 1;
            }
            if tick % 16 == 0 {
                before = Some((potential, f64::from(estimate.torque), force));
            }
        }
        assert!(compared > 10, "{compared}");
        // Outside the table nothing is known; in proportion it goes on.
        let outside = estimator.update(1.2).status;
        assert_eq!(outside == Status::OutOfRange, matches!(travel, Travel::Table(_)), "{outside:?}");
    }
    let mut estimator: Box<Estimator<f32, Reduced>> = Box::new(Estimator::EMPTY);
    let refused = estimator.set_drive(Drive::linear([1.0, 0.0], -1.0));
    assert!(matches!(refused, Err(DriveError::Value { name: "mm_per_rad", .. })), "{refused:?}");
}

#[test]
fn an_uncertainty_that_is_none_is_refused() {
    let mut estimator: Box<Estimator<f32, Reduced>> = Box::new(Estimator::EMPTY);
    let refused = estimator.set_uncertainty(Uncertainty { radius: f32::NAN, ..Uncertainty::DEFAULT });
    assert!(matches!(refused, Err(UncertaintyError::Value { name: "radius", .. })), "{refused:?}");
}

crate::fixed_size!(
    /// As [`Rubbing`], with room for all samples.
    Roomy, cells 8, nodes 126, samples 96, contacts 150, friction
);

/// An object that the finger lies against over more samples than there is room for with friction, with time for few iterations and for more: the tick
/// says so, and not that it wants more iterations. Some ticks later fewer samples count, and the force is that of a finger that has room for all.
#[test]
fn more_contact_than_there_is_room_for_is_named_and_spares_samples() {
    let circle = |radius: f64| ObjectDesign::Circle { centre: [radius + 1.0, 45.0], radius };
    let ellipse = ObjectDesign::Ellipse { centre: [22.0, 45.0], semi_axes: [20.0, 60.0], angle: 0.0 };
    for (budget, object) in [(3, circle(100.0)), (8, circle(60.0)), (8, circle(200.0)), (8, ellipse)] {
        let mut estimator: Box<Estimator<f32, Rubbing>> = Box::new(Estimator::EMPTY);
        let how = Discretisation::estimator(Physics::Extended);
        let design = crate::design::ladder_80();
        estimator.configure(&design, &how).expect("a valid finger");
        let settings = EstimatorSettings { budget, ..EstimatorSettings::DEFAULT };
        estimator.set_settings(settings, Settings::DEFAULT).expect("allowed");
        estimator.set_friction(0.3).expect("allowed");
        estimator.set_object(object).expect("a valid object");
        let place = |tick: i32| f64::from(tick.min(260)) * (0.05_f64).to_radians();
        let found: std::vec::Vec<_> = (0..400).map(|tick| estimator.update(place(tick)).status).collect();
        let crowded = found.iter().filter(|&&status| status == Status::ContactCapacity).count();
        let waits = found.iter().filter(|&&status| status == Status::MaxIterations).count();
        std::println!("budget {budget}: {crowded} ticks without room, {waits} for the way from the open hand");
        assert!((1..=18).contains(&crowded) && waits <= 40, "budget {budget}: {crowded}, {waits}");
        // The motor rests from tick 260 on.
        assert!(
            found.iter().skip(300).all(|status| status.is_trustworthy()),
            "budget {budget}: {:?}",
            &found[300..320]
        );
        let open = (0..600).map(|tick| estimator.update(place((260 - tick).max(-20))).status);
        let lost = open.filter(|status| !status.is_trustworthy()).count();
        assert!(lost <= 2, "budget {budget}: {lost} while it opens");
        // The next time it is known from the open hand on.
        let mut follower: Box<Follower<f64, Roomy>> = Box::new(Follower::EMPTY);
        follower.configure(&design, &how).expect("a valid finger");
        follower.set_object(object, Motion::Rotating { axis: design.motor_axis });
        follower.set_friction(0.3).expect("allowed");
        assert!(follower.start(0.0));
        let (mut worst, mut sum, mut compared, mut most) = (0.0_f64, 0.0, 0, 0);
        for tick in 0..260 {
            let estimate = estimator.update(place(tick));
            assert!(
                estimate.status.is_trustworthy() && follower.follow(place(tick)).status.is_trustworthy(),
                "{tick}: {estimate:?}"
            );
            let [x, y] = follower.solution().force_world();
            let size = libm::hypot(x, y);
            if size > 1.0 {
                let force = estimate.force.map(f64::from);
                let apart = libm::hypot(force[0] - x, force[1] - y) / size;
                (worst, sum) = (worst.max(apart), sum + apart);
                (compared, most) = (compared + 1, most.max(follower.solution().touching()));
            }
        }
        let mean = sum / f64::from(compared);
        std::println!(
            "{compared} forces, {:.2} % off in the mean, {:.1} at most; {most} samples touched",
            100.0 * mean,
            100.0 * worst
        );
        assert!(mean < 0.01 && worst < 0.06 && compared > 100 && most > 19, "{mean} {worst} {compared} {most}");
    }
}

/// A finger snaps through, and the motor turns round while the estimator is still on its way over that.
#[test]
fn a_snap_before_a_turn_is_not_missed() {
    let (design, ..) = random_case(&mut Random::new(341));
    let object = ObjectDesign::Ellipse { centre: [25.340, 57.473], semi_axes: [18.719, 23.889], angle: 2.05456 };
    for (budget, pace) in [(8, 1.27), (2, 1.0), (30, 1.27)] {
        let mut estimator: Box<Estimator<f32, Reduced>> = Box::new(Estimator::EMPTY);
        let how = Discretisation::estimator(Physics::Extended);
        estimator.configure(&design, &how).expect("a valid finger");
        estimator.set_object(object).expect("a valid object");
        estimator.set_budget(budget);
        let mut exact: Box<Follower<f64, Reduced>> = Box::new(Follower::EMPTY);
        exact.configure(&design, &how).expect("a valid finger");
        exact.set_object(object, Motion::Rotating { axis: design.motor_axis });
        let [open, closed] = [-2.0, 20.67_f64].map(|degrees: f64| degrees.to_radians() / (pace * COUNT));
        let (mut late, mut snaps) = (0, 0);
        assert!(exact.start(libm::round(open) * pace * COUNT));
        for tick in (open as i32..=closed as i32).chain((open as i32..closed as i32).rev()) {
            let angle = libm::round(f64::from(tick) * pace) * COUNT;
            let (estimate, outcome) = (estimator.update(angle), exact.follow(angle));
            snaps += outcome.snaps;
            if !estimate.status.is_trustworthy() {
                late += 1;
                continue;
            }
            let [found, expected] = [f64::from(estimate.force_magnitude()), magnitude(exact.solution().force_world())];
            let apart = (found - expected).abs();
            assert!(apart < 0.05 * expected.max(1.0), "{budget}, tick {tick}: {found} and {expected}");
        }
        assert!(snaps == 2 && (1..150).contains(&late), "{budget}: {snaps} snaps, {late} ticks without an estimate");
    }
}

/// The estimator on a finger with friction, and a follower with all the time that it needs.
struct Both {
    estimator: Box<Estimator<f32, Rubbing>>,
    exact: Box<Follower<f64, Rubbing>>,
}

impl Both {
    /// At -3°, the hand open.
    fn new(coefficient: f64) -> Self {
        let (design, how) = (crate::design::ladder_80(), Discretisation::estimator(Physics::Extended));
        let object = ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 };
        let (mut estimator, mut exact) = (Box::new(Estimator::EMPTY), Box::new(Follower::EMPTY));
        estimator.configure(&design, &how).expect("a valid finger");
        estimator.set_object(object).expect("a valid object");
        estimator.set_friction(coefficient).expect("allowed");
        exact.configure(&design, &how).expect("a valid finger");
        exact.set_object(object, Motion::Rotating { axis: design.motor_axis });
        exact.set_friction(coefficient).expect("allowed");
        assert!(exact.start(f64::from(counts(-3.0)) * COUNT));
        Self { estimator, exact }
    }

    /// Goes to a count with so many iterations: the estimate, and the force, N.
    fn go(&mut self, count: i32, budget: u32) -> (Estimate, f64) {
        self.estimator.set_budget(budget);
        self.exact.follow(f64::from(count) * COUNT);
        (self.estimator.update(f64::from(count) * COUNT), magnitude(self.exact.solution().force_world()))
    }

    /// Closes to 10°, then goes from angle to angle (degrees) without time for an estimate, and rests at the last one: what is found there.
    fn unseen(&mut self, angles: &[f64]) -> (Estimate, f64) {
        let mut at = counts(10.0);
        (counts(-3.0)..=at).for_each(|count| assert!(self.go(count, 8).0.status.is_trustworthy(), "{count}"));
        let mut missed = 0;
        for &angle in angles {
            let to = counts(angle);
            while at != to {
                at += (to - at).signum();
                missed += u32::from(self.go(at, 0).0.age > 0);
            }
        }
        assert!(missed > 80, "{missed}");
        let (estimate, expected) = (0..60).map(|_| self.go(at, 8)).last().expect("sixty ticks");
        assert!(estimate.status.is_trustworthy(), "{estimate:?}");
        (estimate, expected)
    }
}

fn counts(degrees: f64) -> i32 {
    (degrees.to_radians() / COUNT) as i32
}

/// With friction: the motor turns round while no time is left for an estimate. The force afterwards depends on that turn all the same.
#[test]
fn a_turn_without_time_for_it_is_in_the_history() {
    for coefficient in [0.3, 1.0] {
        for lowest in [5.0, -3.0] {
            let (estimate, expected) = Both::new(coefficient).unseen(&[lowest, 8.0]);
            let found = f64::from(estimate.force_magnitude());
            assert!((found - expected).abs() < 0.005 * expected, "{coefficient}, {lowest}°: {found} and {expected} N");
        }
    }
}

/// A second turn that passes as well is not kept: the force then lies within an interval.
#[test]
fn of_two_turns_without_time_the_way_is_unknown() {
    for coefficient in [0.3, 0.6, 1.0] {
        let (estimate, expected) = Both::new(coefficient).unseen(&[5.0, 8.0, 6.5]);
        let [least, most] = estimate.interval.expect("with friction").magnitude.map(f64::from);
        let is_within = (0.99 * least..=1.01 * most).contains(&expected);
        assert!(is_within && most > 1.05 * least, "{coefficient}: {expected} N, {least} to {most}");
    }
}

fn magnitude([x, y]: [f64; 2]) -> f64 {
    libm::hypot(x, y)
}
