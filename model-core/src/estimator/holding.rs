//! Holding with friction: noise, and pasts that are not known.

use super::tests::COUNT;
use super::*;
use crate::discretise::Physics;
use crate::equilibrium::SlipWay;
use crate::random_designs::Random;
use crate::size::Rubbing;
use crate::solution::Reading;
use std::boxed::Box;
use std::vec::Vec;

const DEGREE: f64 = core::f64::consts::PI / 180.0;

fn estimator<T: Real>(coefficient: f64, height: f64) -> Box<Estimator<T, Rubbing>> {
    let mut estimator: Box<Estimator<T, Rubbing>> = Box::new(Estimator::EMPTY);
    let design = crate::design::ladder_80();
    estimator.configure(&design, &Discretisation::estimator(Physics::Extended)).expect("a valid finger");
    estimator.set_object(ObjectDesign::Circle { centre: [41.0, height], radius: 40.0 }).expect("a valid object");
    estimator.set_friction(coefficient).expect("a coefficient in range");
    estimator
}

/// A finger that goes where it is asked to, open at −1°.
fn finger(coefficient: f64, height: f64) -> Box<Follower<f64, Rubbing>> {
    let mut follower: Box<Follower<f64, Rubbing>> = Box::new(Follower::EMPTY);
    let design = crate::design::ladder_80();
    follower.configure(&design, &Discretisation::estimator(Physics::Extended)).expect("a valid finger");
    let object = ObjectDesign::Circle { centre: [41.0, height], radius: 40.0 };
    follower.set_object(object, crate::object::Motion::Rotating { axis: design.motor_axis });
    follower.set_friction(coefficient).expect("in range");
    assert!(follower.start(-DEGREE));
    follower
}

/// A normal number.
fn normal(random: &mut Random) -> f64 {
    let (u, v) = (random.unit().max(1e-12), random.unit());
    libm::sqrt(-2.0 * libm::log(u)) * libm::cos(core::f64::consts::TAU * v)
}

/// Closes to 8°, 20° a second at 500 Hz, and holds for so many ticks, measured with σ = 0.03° and in counts; mean magnitude of the force in the
/// first and the last second of the hold, and what it is without noise.
fn held<T: Real>(coefficient: f64, height: f64, quantisation: f32, ticks: usize) -> [f64; 3] {
    let mut random = Random::new(7);
    let mut estimator = estimator::<T>(coefficient, height);
    estimator.set_uncertainty(Uncertainty { quantisation, ..Uncertainty::DEFAULT }).expect("allowed");
    let mut measure = |angle: f64| libm::round((angle + 0.03 * DEGREE * normal(&mut random)) / COUNT) * COUNT;
    let last = 8.0 * DEGREE;
    let (mut sums, mut exact) = ([0.0; 2], 0.0);
    let mut follower = finger(coefficient, height);
    for tick in 0..200 + ticks {
        let angle = (0.04 * DEGREE * f64::from(tick as u32)).min(last) - if tick < 3 { 0.2 * DEGREE } else { 0.0 };
        if (3..202).contains(&tick) {
            assert!(follower.follow(angle).status.is_trustworthy());
            exact = libm::hypot(follower.solution().force_world()[0], follower.solution().force_world()[1]);
        }
        let estimate = estimator.update(measure(angle));
        assert!(estimate.status.is_trustworthy(), "tick {tick}: {estimate:?}");
        let into = match tick {
            201..=700 => 0,
            _ if tick >= ticks - 300 => 1,
            _ => continue,
        };
        sums[into] += f64::from(estimate.force_magnitude()) / 500.0;
    }
    [sums[0], sums[1], exact]
}

/// Ten minutes of noise at 500 Hz drift by less than 1 %; without the play they pump the contact.
#[test]
fn noise_does_not_pump_a_hold() {
    const TEN_MINUTES: usize = 300_000;
    let count = COUNT as f32;
    for (coefficient, height) in [(0.3, 45.0), (0.6, 30.0)] {
        let [first, last, exact] = held::<f32>(coefficient, height, count, TEN_MINUTES);
        let [double, double_last, _] = held::<f64>(coefficient, height, count, TEN_MINUTES / 10);
        let [_, pumped, _] = held::<f32>(coefficient, height, 0.0, 5_000);
        std::println!(
            "m {coefficient} {height} mm: {exact:.3} N; {first:.3} to {last:.3}; f64 {double:.3} to {double_last:.3}; without play {pumped:.3}"
        );
        assert!((last / first - 1.0).abs() < 0.01, "{first} {last}");
        assert!((double_last / double - 1.0).abs() < 0.01, "{double} {double_last}");
        assert!((last / exact - 1.0).abs() < 0.02, "{exact} {last}");
        assert!(pumped / exact - 1.0 < -0.03, "{exact} {pumped}");
    }
}

/// Moves from angle to angle (degrees) in steps of half a count; the last estimate.
fn go<T: Real>(estimator: &mut Estimator<T, Rubbing>, from: f64, to: f64) -> Estimate {
    let steps = libm::ceil((to - from).abs() * DEGREE / (0.5 * COUNT)).max(1.0);
    let mut last = Estimate::blank(Status::Converged);
    for k in 1..=steps as usize {
        last = estimator.update((from + (to - from) * k as f64 / steps) * DEGREE);
    }
    // The median of the last angles comes after.
    for _ in 0..3 {
        last = estimator.update(to * DEGREE);
    }
    last
}

/// So long at one angle that everything is known that will be.
fn rest<T: Real>(estimator: &mut Estimator<T, Rubbing>, at: f64) -> Estimate {
    (0..60).map(|_| estimator.update(at * DEGREE)).last().expect("sixty ticks")
}

/// Normal force, magnitude and torque lie in an interval, but for this part of it.
fn within(interval: &Interval, truth: &Reading<f32>, slack: f32) -> bool {
    let holds = |[low, high]: [f32; 2], value: f32| (low * (1.0 - slack)..=high * (1.0 + slack)).contains(&value);
    let size = libm::hypotf(truth.force[0], truth.force[1]);
    holds(interval.normal, truth.normal) && holds(interval.magnitude, size) && holds(interval.torque, truth.torque)
}

/// Magnitude of the force at the end of a way of angles, degrees, with the object's centre shifted.
fn arrived(coefficient: f64, height: f64, shift: [f64; 2], way: &[f64]) -> (Box<Estimator<f64, Rubbing>>, f64) {
    let mut estimator = estimator::<f64>(coefficient, height);
    let centre = [41.0 + shift[0], height + shift[1]];
    estimator.set_object(ObjectDesign::Circle { centre, radius: 40.0 }).expect("a valid object");
    let mut from = -1.0;
    for &to in way {
        go(&mut estimator, from, to);
        from = to;
    }
    let last = rest(&mut estimator, from);
    assert!(last.status.is_trustworthy(), "{last:?}");
    let size = f64::from(last.force_magnitude());
    (estimator, size)
}

/// An object that is elsewhere has been there all along: the force changes with its place as of a finger that has come the same way.
#[test]
fn slopes_are_those_of_a_finger_that_has_come_the_same_way() {
    for (coefficient, height) in [(0.3, 45.0), (0.6, 45.0), (0.6, 30.0), (1.0, 60.0)] {
        for way in [&[8.0][..], &[8.0, 6.0], &[8.0, 7.8], &[8.0, 7.6], &[8.0, 7.0, 7.4]] {
            let (estimator, _) = arrived(coefficient, height, [0.0; 2], way);
            let slope = |shift: [f64; 2]| {
                let [less, more] = [-1.0, 1.0].map(|sign| arrived(coefficient, height, shift.map(|x| sign * x), way).1);
                (more - less) / 0.4
            };
            let expected = [slope([0.2, 0.0]), slope([0.0, 0.2])];
            let found = estimator.slopes.centre.map(f64::from);
            std::println!("m {coefficient} {height} {way:?}: {found:.4?} N/mm, by differences {expected:.4?}");
            let [size, reference] = [found, expected].map(|[x, y]| libm::hypot(x, y));
            assert!(
                (0.65..1.5).contains(&(size / reference)),
                "{coefficient} {height} {way:?}: {found:?} {expected:?}"
            );
        }
    }
}

/// Part of the forces by which they differ between two places a count apart: what the play leaves of the angle, which the standard deviation
/// counts by itself.
const ANGLE: f32 = 0.04;

fn an_unknown_past<T: Real>() {
    for (coefficient, height) in [(0.3, 45.0), (0.6, 45.0), (0.6, 30.0)] {
        // The truth has a past: it closed to 10° and opened by more or less.
        for turn in [8.0, 8.3, 9.0, 10.0] {
            let mut truth = estimator::<T>(coefficient, height);
            go(&mut truth, -1.0, turn);
            go(&mut truth, turn, 8.0);
            let mut blind = estimator::<T>(coefficient, height);
            let found = rest(&mut blind, 8.0);
            assert!(found.status.is_trustworthy(), "{found:?}");
            rest(&mut truth, 8.0);
            let interval = blind.interval().expect("both ends are known");
            let real = truth.rub_reading();
            assert!(within(&interval, &real, 0.01), "m {coefficient} {height} from {turn}: {interval:?} {real:?}");
            let [low, high] = interval.magnitude;
            assert!(high - low > 0.02 * high, "{interval:?}");
            assert!(found.standard_deviation >= (high - low) / 12.0_f32.sqrt(), "{found:?}");
            // A motion that is long enough restores what is known, on the way it narrows and holds the truth.
            for end in [5.0, 8.0] {
                let from = if end == 5.0 { 8.0 } else { 5.0 };
                let mut last = f32::INFINITY;
                for k in 1..=24 {
                    let at = |k: f64| from + (end - from) * k / 24.0;
                    go(&mut truth, at(f64::from(k) - 1.0), at(f64::from(k)));
                    let found = go(&mut blind, at(f64::from(k) - 1.0), at(f64::from(k)));
                    assert!(found.status.is_trustworthy(), "{found:?}");
                    let real = truth.rub_reading();
                    if let Some(interval) = blind.interval() {
                        assert!(
                            within(&interval, &real, ANGLE),
                            "m {coefficient} {height} from {turn} at {}: {interval:?} {real:?}",
                            at(f64::from(k))
                        );
                        last = (interval.magnitude[1] - interval.magnitude[0]) / interval.magnitude[1];
                    }
                }
                if end == 8.0 {
                    assert!(last < 0.01, "{last}");
                }
            }
        }
    }
}

#[test]
fn an_unknown_past_is_an_interval_that_a_motion_narrows_in_single_precision() {
    an_unknown_past::<f32>();
}

#[test]
fn an_unknown_past_is_an_interval_that_a_motion_narrows_in_double_precision() {
    an_unknown_past::<f64>();
}

/// Lost ticks, by a leap of the angle or by word, and an object that is set while it is held.
#[test]
fn what_makes_the_past_unknown() {
    let mut estimator = estimator::<f32>(0.6, 45.0);
    go(&mut estimator, -1.0, 8.0);
    let known = rest(&mut estimator, 8.0);
    let width = |estimator: &Estimator<f32, Rubbing>| {
        let [low, high] = estimator.interval().expect("an interval").magnitude;
        high - low
    };
    assert!(width(&estimator) < 1e-6, "{known:?}");
    estimator.forget_path();
    assert!(rest(&mut estimator, 8.0).status.is_trustworthy() && width(&estimator) > 0.5);
    go(&mut estimator, 8.0, -1.0);
    go(&mut estimator, -1.0, 8.0);
    rest(&mut estimator, 8.0);
    assert!(width(&estimator) < 1e-6, "an open hand knows its past");
    estimator.update(6.5 * DEGREE);
    rest(&mut estimator, 6.5);
    assert!(width(&estimator) > 0.1, "a leap of 1.5°");
    go(&mut estimator, 6.5, -1.0);
    go(&mut estimator, -1.0, 8.0);
    estimator.set_object(ObjectDesign::Circle { centre: [41.0, 45.0], radius: 39.9 }).expect("a valid object");
    assert!(rest(&mut estimator, 8.0).status.is_trustworthy() && width(&estimator) > 0.5);
}

/// A reversal that is shorter than the play has not been seen: the finger may have followed, or stayed. Where it is longer, the play has put off
/// its beginning.
#[test]
fn a_reversal_within_the_play_is_an_interval() {
    for (coefficient, height) in [(0.3, 45.0), (0.6, 45.0), (1.0, 30.0), (0.6, 60.0)] {
        let mut estimator = estimator::<f32>(coefficient, height);
        let mut finger = followed_to(coefficient, height, 8.0);
        go(&mut estimator, -1.0, 8.0);
        let turned = rest(&mut estimator, 8.0);
        let interval = estimator.interval().expect("an interval");
        assert!(interval.magnitude[1] - interval.magnitude[0] < 0.01 * turned.force_magnitude(), "{interval:?}");
        for back in [0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5] {
            go(&mut estimator, 8.0 - back + 0.05, 8.0 - back);
            let estimate = rest(&mut estimator, 8.0 - back);
            assert!(finger.follow((8.0 - back) * DEGREE).status.is_trustworthy());
            let truth = finger.solution().reading();
            let truth = Reading {
                force: truth.force.map(|part| part as f32),
                normal: truth.normal as f32,
                torque: truth.torque as f32,
            };
            let interval = estimator.interval().expect("an interval");
            assert!(within(&interval, &truth, 0.01), "m {coefficient}, {height} mm, {back}°: {interval:?} {truth:?}");
            assert!(interval.magnitude[1] > 0.999 * turned.force_magnitude(), "{back}°: {interval:?}, {turned:?}");
            let apart = estimate.force_magnitude() - libm::hypotf(truth.force[0], truth.force[1]);
            assert!(apart.abs() < 3.0 * estimate.standard_deviation, "{back}°: {apart} {estimate:?}");
        }
    }
}

/// An open hand has no past: where it comes into contact is found without the play, and what follows is that of a finger that has come the same way.
#[test]
fn an_open_hand_meets_an_object_at_once() {
    for (coefficient, height) in [(0.3, 45.0), (1.0, 30.0)] {
        let (mut estimator, mut finger) = (estimator::<f64>(coefficient, height), finger(coefficient, height));
        let mut seen = 0;
        for tick in 0..400 {
            let angle = (-1.0 + 0.02 * f64::from(tick)) * DEGREE;
            let estimate = estimator.update(angle);
            let truth = finger.follow(angle);
            let force = finger.solution().force_world();
            let size = libm::hypot(force[0], force[1]);
            assert_eq!(estimate.force == [0.0; 2], truth.status == Status::NoContact, "{tick}: {estimate:?}");
            if (1e-9..0.5).contains(&size) {
                let apart = (f64::from(estimate.force_magnitude()) - size).abs();
                assert!(apart < 0.005, "{apart} of {size} N at {}°", angle / DEGREE);
                seen += 1;
            }
        }
        assert!(seen > 3, "{seen}");
    }
}

/// A finger that lets go of an object never pulls it, wherever between two counts its place is.
#[test]
fn an_opening_finger_does_not_pull() {
    let corners = [[2.0, 15.0], [62.0, 15.0], [62.0, 75.0], [2.0, 75.0]];
    let corners = crate::object::Corners::new(&corners).expect("four corners");
    for (budget, speed) in [(8, 0.02), (8, 0.05), (1, 0.02), (1, 0.05)] {
        let mut estimator = estimator::<f32>(0.6, 45.0);
        estimator.set_budget(budget);
        estimator.set_object(ObjectDesign::Polygon { corners, rounding: 1.0 }).expect("a valid object");
        let ticks = (6.0 / speed) as i32;
        let (mut pushed, mut open) = (0, 0);
        for tick in (-ticks / 3..=ticks).chain((-ticks / 3..ticks).rev()) {
            let angle = libm::round(f64::from(tick) * speed * DEGREE / COUNT) * COUNT;
            let estimate = estimator.update(angle);
            assert!(estimate.force[0] >= 0.0, "budget {budget}, {speed}°, tick {tick}: {estimate:?}");
            pushed += u32::from(estimate.force[0] > 1.0);
            open += u32::from(estimate.force == [0.0; 2]);
        }
        assert!(pushed > 50 && open > 50, "{pushed} {open}");
    }
}

/// A finger that has closed to an angle, degrees.
fn followed_to(coefficient: f64, height: f64, degrees: f64) -> Box<Follower<f64, Rubbing>> {
    let mut follower = finger(coefficient, height);
    for k in 0..=800 {
        assert!(follower.follow((-1.0 + (degrees + 1.0) * f64::from(k) / 800.0) * DEGREE).status.is_trustworthy());
    }
    follower
}

/// A reversal that is shorter than the backlash may not have reached the finger.
#[test]
fn a_reversal_within_the_backlash_is_an_interval() {
    let mut estimator = estimator::<f32>(0.6, 45.0);
    let backlash = f64::from(Uncertainty::DEFAULT.backlash) / DEGREE;
    go(&mut estimator, -1.0, 8.0);
    rest(&mut estimator, 8.0);
    let turned = estimator.rub_reading();
    // The play takes the first count of it.
    go(&mut estimator, 8.0, 7.75);
    rest(&mut estimator, 7.75);
    let interval = estimator.interval().expect("an interval");
    assert!(within(&interval, &turned, 0.01), "{interval:?} {turned:?}");
    assert!(interval.magnitude[1] - interval.magnitude[0] > 0.05, "{interval:?}");
    go(&mut estimator, 7.75, 8.0 - 2.0 * backlash - 0.3);
    rest(&mut estimator, 8.0 - 2.0 * backlash - 0.3);
    let interval = estimator.interval().expect("an interval");
    assert!(interval.magnitude[1] - interval.magnitude[0] < 1e-6, "{interval:?}");
}

/// The derivative with the motor angle is that of the forces.
#[test]
fn derivatives_with_friction_agree_with_differences() {
    let mut estimator = estimator::<f64>(0.6, 45.0);
    go(&mut estimator, -1.0, 6.0);
    let mut compared: Vec<f64> = Vec::new();
    for k in 0..8 {
        let at = 6.0 + 0.25 * f64::from(k);
        go(&mut estimator, at - 0.25, at);
        let before = rest(&mut estimator, at);
        assert!(estimator.follower().slips(SlipWay::Closing));
        let after = go(&mut estimator, at, at + 0.1);
        let slope = f64::from(after.force_magnitude() - before.force_magnitude()) / (0.1 * DEGREE);
        let [x, y] = before.force_per_angle;
        let along = f64::from(x * before.force[0] + y * before.force[1]) / f64::from(before.force_magnitude());
        go(&mut estimator, at + 0.1, at + 0.25);
        compared.push(along / slope - 1.0);
        assert!(before.standard_deviation.is_finite() && before.standard_deviation > 0.0, "{before:?}");
    }
    let mean = compared.iter().sum::<f64>() / compared.len() as f64;
    assert!(mean.abs() < 0.1 && compared.iter().all(|off| off.abs() < 0.3), "{compared:?}");
}
