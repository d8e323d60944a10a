//! Ticks that go on with their estimate while there is time.

use super::derivatives::DIFFERENTIATE_AT_LAST;
use super::tests::COUNT;
use super::*;
use crate::discretise::Physics;
use crate::random_designs::Random;
use crate::size::{Reduced, Rubbing};
use std::boxed::Box;

/// Calls within which a tick of these motions is trustworthy, each with time for one iteration.
const CALLS: u32 = 24;

fn estimator<S: Size>(friction: f64, budget: u32) -> Box<Estimator<f32, S>> {
    let mut estimator: Box<Estimator<f32, S>> = Box::new(Estimator::EMPTY);
    let design = crate::design::ladder_80();
    estimator.configure(&design, &Discretisation::estimator(Physics::Extended)).expect("a valid finger");
    estimator.set_object(ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 }).expect("a valid object");
    estimator.set_friction(friction).expect("a coefficient in range");
    estimator.set_budget(budget);
    estimator
}

/// Estimates at an angle with time for one iteration, and goes on with it until it is trustworthy; in how many calls.
fn until_trustworthy<S: Size>(estimator: &mut Estimator<f32, S>, angle: f64) -> (Estimate, u32) {
    let mut estimate = estimator.update(angle);
    let begun = estimate;
    for call in 1..=CALLS {
        if estimate.status.is_trustworthy() {
            return (estimate, call);
        }
        // It is one tick, however often it goes on.
        assert_eq!((estimate.age, estimate.sensitivity_age), (begun.age, begun.sensitivity_age), "{estimate:?}");
        let iterations = estimate.iterations;
        estimate = estimator.go_on(angle);
        assert!(estimate.iterations <= iterations + 1, "{estimate:?} after {iterations} iterations");
        assert!(estimate.iterations >= begun.iterations && estimate.motor_angle == angle as f32, "{estimate:?}");
    }
    panic!("not trustworthy: {estimate:?}");
}

fn difference(one: &Estimate, other: &Estimate) -> f32 {
    libm::hypotf(one.force[0] - other.force[0], one.force[1] - other.force[1])
}

/// A motion too fast for one iteration per tick, and one in which nothing is left to do but for a few ticks.
#[test]
fn a_tick_that_goes_on_is_as_good_as_one_with_time() {
    for (pace, most) in [(1, 1.1), (3, 2.5)] {
        let (mut stepwise, mut whole) = (estimator::<Reduced>(0.0, 1), estimator::<Reduced>(0.0, 1000));
        let (mut calls, mut touching, mut oldest) = (0, 0, 0);
        for count in (-20..=125).step_by(pace).chain((-20..125).rev().step_by(pace)) {
            let angle = f64::from(count) * COUNT;
            let ((estimate, taken), exact) = (until_trustworthy(&mut stepwise, angle), whole.update(angle));
            assert!(difference(&estimate, &exact) < 0.01, "count {count}: {estimate:?}, {exact:?}");
            if exact.force != [0.0; 2] {
                (calls, touching) = (calls + taken, touching + 1);
                oldest = oldest.max(estimate.sensitivity_age);
            }
        }
        let mean = f64::from(calls) / f64::from(touching);
        assert!(mean < most && touching > 20, "{mean} calls a tick in {touching}");
        // Derivatives have their turn all the same.
        assert!(oldest <= 3 * DIFFERENTIATE_AT_LAST, "{oldest} ticks old");
    }
}

/// With friction the measured angle counts once a tick: the history is where it is with time for everything, also in noise.
#[test]
fn the_path_takes_an_angle_once_a_tick() {
    let (mut stepwise, mut whole) = (estimator::<Rubbing>(0.6, 1), estimator::<Rubbing>(0.6, 1000));
    let mut random = Random::new(3);
    let (mut went_on, mut known, mut calls, mut touching) = (0, 0, 0, 0);
    let mut doubtful = 0;
    for tick in 0_i32..600 {
        let way = f64::from(if tick < 350 { tick } else { 700 - tick }) * 0.35 - 10.0;
        let angle = libm::round(way + 2.0 * random.signed()) * COUNT;
        let ((estimate, taken), exact) = (until_trustworthy(&mut stepwise, angle), whole.update(angle));
        went_on += u32::from(taken > 1);
        if exact.force != [0.0; 2] {
            (calls, touching) = (calls + taken, touching + 1);
        }
        assert_eq!(stepwise.rub().path.at(), whole.rub().path.at(), "tick {tick}");
        if estimate.standard_deviation.is_finite() && exact.standard_deviation.is_finite() {
            // Where so much noise looks like a finger that turns round, the last counts go by slopes of different ticks: within what is said
            // of them.
            let widths = [&estimate, &exact]
                .map(|found| found.interval.map_or(0.0, |interval| interval.magnitude[1] - interval.magnitude[0]));
            let [x, y] = [0, 1].map(|i| estimate.force_per_angle[i] - exact.force_per_angle[i]);
            let doubt = widths[0].max(widths[1]) + 1.5 * COUNT as f32 * libm::hypotf(x, y);
            let bound = 0.02 + 0.02 * exact.force_magnitude() + doubt;
            doubtful += u32::from(doubt > 0.05 * exact.force_magnitude());
            assert!(difference(&estimate, &exact) < bound, "tick {tick}: {estimate:?}, {exact:?}");
            known += 1;
        }
    }
    assert!(went_on > 10 && known > 400, "{went_on} ticks went on, {known} forces known");
    assert!(doubtful < known / 3, "{doubtful} of {known} in doubt");
    std::println!("{doubtful} of {known} in doubt");
    // A call goes on with the step where the one before has stopped.
    let mean = f64::from(calls) / f64::from(touching);
    std::println!("{mean:.2} calls a tick in {touching}");
    assert!(mean < 1.5, "{mean} calls a tick in {touching}");
}
