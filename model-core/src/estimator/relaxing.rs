//! The estimate of a finger that relaxes: held, closed further, opened, and found pressed.

use std::boxed::Box;

use super::tests::COUNT;
use super::*;
use crate::discretise::Physics;
use crate::random_designs::Random;
use crate::size::{Reduced, Rubbing};
use crate::uncertainty::{ALL, MemoryUncertainty, PARAMETERS};

const TERMS: [[f64; 2]; 3] = [[0.15, 0.1], [0.15, 5.0], [0.1, 100.0]];
const TICK: f64 = 0.002;

fn estimator<S: Size>(friction: f64, terms: &[[f64; 2]]) -> Box<Estimator<f32, S>> {
    let mut estimator: Box<Estimator<f32, S>> = Box::new(Estimator::EMPTY);
    let design = crate::design::ladder_80();
    estimator.configure(&design, &Discretisation::estimator(Physics::Extended)).expect("a valid finger");
    estimator.set_object(ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 }).expect("a valid object");
    estimator.set_friction(friction).expect("a coefficient in range");
    estimator.set_prony(terms).expect("valid terms");
    estimator
}

/// What is left of a sudden force after a time, s.
fn left(seconds: f64) -> f64 {
    1.0 - TERMS.iter().map(|[part, time]| -part * libm::expm1(-seconds / time)).sum::<f64>()
}

/// Goes from count to count, a tick each; the last estimate.
fn go<S: Size>(estimator: &mut Estimator<f32, S>, from: i32, to: i32) -> Estimate {
    let mut last = Estimate::blank(Status::NoContact);
    let mut at = from;
    while at != to {
        at += (to - at).signum();
        last = estimator.update_after(f64::from(at) * COUNT, TICK);
        assert!(last.status.is_trustworthy(), "{last:?}");
    }
    last
}

/// Rests at a count for so many ticks.
fn rest<S: Size>(estimator: &mut Estimator<f32, S>, at: i32, ticks: u32, seconds: f64) -> Estimate {
    let tick = |_| estimator.update_after(f64::from(at) * COUNT, seconds);
    (0..ticks).map(tick).last().expect("a tick")
}

/// With friction as without, force, torque and what is uncertain of it fade alike.
fn holds<S: Size>(friction: f64) {
    let mut elastic = estimator::<S>(friction, &[]);
    let mut fading = estimator::<S>(friction, &TERMS);
    let known = Uncertainty { memory: MemoryUncertainty::NONE, ..Uncertainty::DEFAULT };
    fading.set_uncertainty(known).expect("allowed");
    go(&mut elastic, -20, 60);
    let closed = go(&mut fading, -20, 60);
    let sudden = rest(&mut elastic, 60, 50, TICK);
    assert!(closed.force_magnitude() < sudden.force_magnitude());
    let mut time = 0.0;
    for (ticks, seconds) in [(2_500, TICK), (1_000, 0.05), (50, 11.0)] {
        let held = rest(&mut fading, 60, ticks, seconds);
        time += f64::from(ticks) * seconds;
        let found = f64::from(held.force_magnitude() / sudden.force_magnitude());
        // Closing took 0.14 s in contact.
        let expected = left(time + 0.07);
        std::println!("{time} s: {found} against {expected}");
        assert!((found / expected - 1.0).abs() < 5e-3, "{time} s: {found} against {expected}");
        assert!((held.torque / sudden.torque - held.force_magnitude() / sudden.force_magnitude()).abs() < 2e-3);
        let uncertain = held.standard_deviation / sudden.standard_deviation;
        assert!((f64::from(uncertain) / found - 1.0).abs() < 0.05, "{uncertain}");
    }
    let after = rest(&mut fading, 60, 1, 0.0).force_magnitude();
    assert!((f64::from(after / sudden.force_magnitude()) - 0.6).abs() < 2e-3, "{after}");
}

#[test]
fn a_held_finger_relaxes() {
    holds::<Reduced>(0.0);
}

#[test]
fn a_held_finger_relaxes_with_friction() {
    holds::<Rubbing>(0.6);
}

/// Ticks that came to nothing count with their time.
#[test]
fn missed_ticks_count_with_their_time() {
    let [mut all, mut missing] = [0; 2].map(|_| estimator::<Reduced>(0.0, &TERMS));
    for estimator in [&mut all, &mut missing] {
        go(estimator, -20, 60);
    }
    let all = rest(&mut all, 60, 4, 0.5);
    // Out of range.
    rest(&mut missing, 4000, 3, 0.5);
    let missing = rest(&mut missing, 60, 1, 0.5);
    assert!((all.force_magnitude() - missing.force_magnitude()).abs() < 1e-4 * all.force_magnitude());
}

/// An opening finger lets go before its motor is back, and says so; it grips again with less than a fresh one.
#[test]
fn an_opening_finger_lets_go_early() {
    let mut fading = estimator::<Reduced>(0.0, &TERMS);
    let fresh = go(&mut fading, -20, 30);
    go(&mut fading, 30, 80);
    rest(&mut fading, 80, 1_000, 0.3);
    let mut at = 80;
    let open = loop {
        at -= 1;
        let estimate = rest(&mut fading, at, 1, TICK);
        if estimate.status == Status::NoContact {
            break estimate;
        }
        assert!(estimate.force_magnitude() > 0.0 && at > -20, "{estimate:?}");
    };
    assert!(at > 10 && open.force == [0.0; 2] && open.torque == 0.0, "{at}: {open:?}");
    go(&mut fading, at, -20);
    let again = go(&mut fading, -20, 30);
    assert!(again.force_magnitude() < 0.95 * fresh.force_magnitude(), "{again:?} {fresh:?}");
}

/// A finger that is found pressed may have been closed at any time: every such past lies in the interval, which narrows.
fn is_found_pressed<S: Size>(friction: f64) {
    for past in [0.0, 0.3, 3.0, 60.0, 2_000.0] {
        let mut truth = estimator::<S>(friction, &TERMS);
        go(&mut truth, -20, 60);
        rest(&mut truth, 60, 100, past / 100.0);
        let mut blind = estimator::<S>(friction, &TERMS);
        let mut widths = std::vec::Vec::new();
        for (ticks, seconds) in [(100, 1e-4), (1_000, TICK), (1_000, 0.02), (1_000, 0.5)] {
            let held = rest(&mut blind, 60, ticks, seconds);
            let real = rest(&mut truth, 60, ticks, seconds);
            assert!(held.status.is_trustworthy(), "{held:?}");
            let (real, shown) = (real.force_magnitude(), held.force_magnitude());
            let [low, high] = held.interval.map_or([shown; 2], |interval| interval.magnitude);
            // Not wider than needed: the edges are pasts, too.
            std::println!("m = {friction}, {past} s before: {low} to {high}, {real}");
            assert!((0.997 * low..=1.003 * high).contains(&real), "{past} s before: {low} to {high}, but {real}");
            assert!(held.standard_deviation >= (high - low) / 12.0_f32.sqrt() * 0.99, "{held:?}");
            if let Some(interval) = held.interval {
                let share = |[low, high]: [f32; 2]| (high - low) / (high + low);
                assert!((share(interval.magnitude) - share(interval.torque)).abs() < 0.05, "{interval:?}");
                assert!(interval.normal[0] <= interval.normal[1] && interval.normal[1] <= 1.01 * high, "{interval:?}");
            }
            widths.push((high - low) / shown);
        }
        assert!(widths.is_sorted_by(|a, b| a >= b), "{widths:?}");
        if friction == 0.0 {
            // From g(∞) to 1, of their middle; the quickest term is known after two seconds, all but the slowest after twenty.
            assert!((widths[0] - 0.5).abs() < 0.05 && widths[1] < 0.32 && widths[2] < 0.16 && widths[3] < 0.003);
        }
    }
}

#[test]
fn a_finger_found_pressed_has_an_interval() {
    is_found_pressed::<Reduced>(0.0);
}

#[test]
fn a_finger_found_pressed_has_an_interval_with_friction() {
    is_found_pressed::<Rubbing>(0.6);
}

/// A finger that is found open has been open for long; other terms begin anew.
#[test]
fn a_finger_found_open_knows_its_past() {
    let mut fading = estimator::<Reduced>(0.0, &TERMS);
    assert_eq!(go(&mut fading, -20, 60).interval, None);
    fading.set_prony(&TERMS).expect("the same");
    assert_eq!(rest(&mut fading, 60, 10, TICK).interval, None, "nothing has changed");
    fading.set_prony(&TERMS[..2]).expect("valid terms");
    let held = (0..100).map(|_| fading.update_after(60.0 * COUNT, TICK)).last().expect("ticks");
    assert!(held.status.is_trustworthy() && held.interval.is_some(), "{held:?}");
    assert_eq!(fading.set_prony(&[[0.6, 1.0]; 2]).map_err(|error| error.name), Err("sum of prony g"));
    assert!(fading.fades());
}

/// Fingers whose modulus and terms are drawn from a covariance: the spread of their forces, closed and held, is what the estimate of the
/// mean finger states. Modulus and parts go together, as a calibration leaves them.
#[test]
fn the_standard_deviation_is_the_spread_of_fingers_with_uncertain_terms() {
    const DRAWS: usize = 300;
    let mut random = Random::new(11);
    let mut normal = || (0..12).map(|_| random.unit()).sum::<f64>() - 6.0;
    let deviations = ([0.03_f64, 0.02, 0.02, 0.0], [0.2_f64, 0.3, 0.2, 0.0]);
    let modulus = 0.06;
    // What the modulus shares with the parts, and the first part with the second time.
    let mut factor = [[0.0; ALL]; ALL];
    (0..ALL).for_each(|i| factor[i][i] = 1.0);
    for (row, column, entry) in [(5, 1, 0.8), (7, 1, 0.5), (8, 5, -0.6)] {
        factor[row][column] = entry;
    }
    for row in &mut factor {
        let length = row.iter().map(|x| x * x).sum::<f64>().sqrt();
        row.iter_mut().for_each(|x| *x /= length);
    }
    let correlations =
        core::array::from_fn(|i| core::array::from_fn(|j| (0..ALL).map(|k| factor[i][k] * factor[j][k]).sum::<f64>()));
    let memory = MemoryUncertainty::of(deviations.0.map(|x| x as f32), deviations.1.map(|x| x as f32), &correlations);
    let given = Uncertainty { youngs_modulus: modulus as f32, memory, ..Uncertainty::NONE };
    let make = |modulus: f64, terms: &[[f64; 2]]| {
        let mut made = estimator::<Reduced>(0.0, &[]);
        let mut design = crate::design::ladder_80();
        design.material.youngs_modulus *= modulus;
        made.configure(&design, &Discretisation::estimator(Physics::Extended)).expect("a valid finger");
        made.set_uncertainty(given).expect("allowed");
        made.set_prony(terms).expect("valid terms");
        made
    };
    // Closed at 20°/s, then after 1 s and 60 s.
    let way =
        |made: &mut Estimator<f32, Reduced>| [go(made, -20, 60), rest(made, 60, 10, 0.1), rest(made, 60, 59, 1.0)];
    let stated = way(&mut make(1.0, &TERMS)).map(|estimate| f64::from(estimate.standard_deviation));
    let mut sums = [[0.0; 2]; 3];
    for _ in 0..DRAWS {
        let own: [f64; ALL] = core::array::from_fn(|_| normal());
        let drawn: [f64; ALL] = core::array::from_fn(|i| (0..ALL).map(|k| factor[i][k] * own[k]).sum());
        let term = |k: usize| {
            let [part, time] = TERMS[k];
            let at = PARAMETERS + 2 * k;
            [part + deviations.0[k] * drawn[at], time * (1.0 + deviations.1[k] * drawn[at + 1]).max(0.1)]
        };
        let mut made = make(1.0 + modulus * drawn[1], &[term(0), term(1), term(2)]);
        for (sum, estimate) in sums.iter_mut().zip(way(&mut made)) {
            let force = f64::from(estimate.force_magnitude());
            *sum = [sum[0] + force, sum[1] + force * force];
        }
    }
    for ([sum, squares], stated) in sums.into_iter().zip(stated) {
        let mean = sum / DRAWS as f64;
        let spread = (squares / DRAWS as f64 - mean * mean).sqrt();
        std::println!("spread {spread:.4} N of {mean:.3} N, stated {stated:.4} N");
        assert!((stated / spread - 1.0).abs() < 0.12, "{stated} instead of {spread}");
    }
}

/// Terms that were measured elsewhere make the force of a held finger uncertain, and more than an elastic one's.
#[test]
fn terms_that_were_not_calibrated_are_uncertain() {
    let mut known = estimator::<Reduced>(0.0, &TERMS);
    let memory = MemoryUncertainty::NONE;
    known.set_uncertainty(Uncertainty { memory, ..Uncertainty::DEFAULT }).expect("allowed");
    let mut given = estimator::<Reduced>(0.0, &TERMS);
    let [known, given] = [&mut known, &mut given].map(|one| {
        go(one, -20, 60);
        rest(one, 60, 50, 0.5).standard_deviation
    });
    assert!(given > 1.05 * known, "{given} {known}");
    // Without terms there is nothing of them to be uncertain of.
    let [elastic, same] = [MemoryUncertainty::DEFAULT, memory].map(|memory| {
        let mut one = estimator::<Reduced>(0.0, &[]);
        one.set_uncertainty(Uncertainty { memory, ..Uncertainty::DEFAULT }).expect("allowed");
        go(&mut one, -20, 60).standard_deviation
    });
    assert_eq!(elastic, same);
}
