//! Material with memory against closed forms of a standard linear solid and of several terms.

use std::boxed::Box;

use super::{Follower, Target};
use crate::design::tests::ribs;
use crate::design::{Design, LamellaKind, RibEnds, Ribs, ladder_80};
use crate::discretise::{Discretisation, Elements, Physics, Sampling, Scheme, Softness};
use crate::object::{Motion, ObjectDesign};
use crate::real::Real;
use crate::sensitivity::{DesignParameter, Probe};
use crate::size::Size;

crate::fixed_size!(
    /// Four terms, with friction.
    Four, cells 8, nodes 302, samples 184, contacts 60, friction, memory 4
);

type Solver<T> = Follower<T, Four>;

const TERMS: [[f64; 2]; 3] = [[0.15, 0.1], [0.15, 5.0], [0.1, 100.0]];

/// What is left of a sudden stress after a time.
fn left(terms: &[[f64; 2]], seconds: f64) -> f64 {
    1.0 - terms.iter().map(|[part, time]| -part * libm::expm1(-seconds / time)).sum::<f64>()
}

fn start<T: Real>(how: &Discretisation, terms: &[[f64; 2]], friction: f64) -> Box<Solver<T>> {
    start_of(&ladder_80(), how, terms, friction)
}

fn start_of<T: Real>(design: &Design, how: &Discretisation, terms: &[[f64; 2]], friction: f64) -> Box<Solver<T>> {
    let mut follower: Box<Solver<T>> = Box::new(Follower::EMPTY);
    follower.configure(design, how).expect("a valid finger");
    follower.set_prony(terms).expect("valid terms");
    follower.set_friction(friction).expect("a valid coefficient");
    let object = ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 };
    follower.set_object(object, Motion::Rotating { axis: design.motor_axis });
    assert!(follower.start(0.0));
    follower
}

fn how(scheme: Scheme, softness: Softness) -> Discretisation {
    let sampling = if scheme == Scheme::Simpson { Sampling::PerElement(4) } else { Sampling::Nodes };
    let elements = match scheme {
        Scheme::Simpson => Elements::PerSpan { span: 2, tip_span: 3, hinge: 1 },
        _ => Elements::PerBeam { beam: 60, hinge: 4 },
    };
    Discretisation { scheme, elements, sampling, softness, physics: Physics::Extended }
}

fn to<T: Real>(follower: &mut Solver<T>, degrees: f64, seconds: f64) {
    let outcome = follower.follow(Target { coordinate: degrees.to_radians(), time_step_s: seconds });
    assert!(outcome.status.is_trustworthy(), "{degrees}°: {}", outcome.status);
}

fn size<T: Real>(follower: &Solver<T>) -> f64 {
    let [x, y] = follower.solution().force_world().map(Real::to_f64);
    x.hypot(y)
}

/// A finger that is closed at once and held relaxes as its material does, whatever the steps of time; one that never was closed does nothing.
#[test]
fn a_held_finger_relaxes_as_its_material() {
    for (scheme, softness, tolerance) in [
        (Scheme::Trapezoid, Softness::Fixed(0.0), 1e-7),
        (Scheme::Simpson, Softness::Fixed(1e-9), 1e-6),
        (Scheme::Simpson, Softness::Local, 2e-3),
    ] {
        let mut follower = start::<f64>(&how(scheme, softness), &TERMS, 0.0);
        to(&mut follower, 0.0, 30.0);
        to(&mut follower, 6.0, 0.0);
        let sudden = size(&follower);
        let mut elastic = start::<f64>(&how(scheme, softness), &[], 0.0);
        to(&mut elastic, 6.0, 0.0);
        assert!((sudden / size(&elastic) - 1.0).abs() < 1e-7, "{sudden} N");
        let mut time = 0.0;
        for step in [0.01, 0.03, 0.3, 1.0, 7.0, 40.0, 300.0] {
            to(&mut follower, 6.0, step);
            time += step;
            let found = size(&follower) / sudden;
            let expected = left(&TERMS, time);
            std::println!("{scheme:?} {softness:?} {time} s: {found} against {expected}");
            assert!(
                (found / expected - 1.0).abs() < tolerance,
                "{scheme:?} {softness:?} {time} s: {found} against {expected}"
            );
        }
    }
}

/// Ticks that are never as long as the one before, and pauses among them, in both precisions.
#[test]
fn uneven_ticks_relax_as_even_ones() {
    fn worst<T: Real>() -> f64 {
        let softness = if T::EPSILON.to_f64() < 1e-10 { Softness::Fixed(1e-9) } else { Softness::Local };
        let mut follower = start::<T>(&how(Scheme::Simpson, softness), &TERMS, 0.0);
        to(&mut follower, 6.0, 0.0);
        let (sudden, mut time, mut worst) = (size(&follower), 0.0, 0.0_f64);
        for tick in 0..2000_u32 {
            let step = if tick % 400 == 399 { 20.0 } else { 2e-3 * (1.0 + 0.1 * f64::from(tick % 7)) };
            to(&mut follower, 6.0, step);
            time += step;
            worst = worst.max((size(&follower) / sudden / left(&TERMS, time) - 1.0).abs());
        }
        worst
    }
    let (double, single) = (worst::<f64>(), worst::<f32>());
    std::println!("off by {double:.1e} in double, {single:.1e} in single precision");
    assert!(double < 1e-6 && single < 2e-3, "{double:e} {single:e}");
}

/// A step that is looked at and not made, however long, leaves what is remembered.
#[test]
fn a_step_that_is_not_made_changes_nothing() {
    fn off<T: Real>(scheme: Scheme, seconds: f64) -> f64 {
        let [mut one, mut other] = [0; 2].map(|_| start::<T>(&how(scheme, Softness::Local), &TERMS, 0.0));
        for follower in [&mut one, &mut other] {
            to(follower, 6.0, 0.6);
        }
        let at = other.timeline.at();
        for seconds in [seconds, -seconds] {
            other.timeline.pass(T::of(seconds));
            other.timeline.take(at, at);
            other.aim(at);
        }
        other.show_accepted();
        for follower in [&mut one, &mut other] {
            to(follower, 6.0, 0.05);
        }
        (size(&other) / size(&one) - 1.0).abs()
    }
    for scheme in [Scheme::Simpson, Scheme::Trapezoid] {
        for seconds in [1e-4, 0.05, 2.0, 500.0] {
            let (double, single) = (off::<f64>(scheme, seconds), off::<f32>(scheme, seconds));
            std::println!("{scheme:?}, {seconds} s: off by {double:.1e} in double, {single:.1e} in single precision");
            assert!(double < 1e-6 && single < 1e-3, "{scheme:?}, {seconds} s: {double:e} {single:e}");
        }
    }
}

/// The same in single precision and with friction, whose softness along the object does not relax.
#[test]
fn in_single_precision_and_with_friction() {
    for friction in [0.0, 0.6] {
        let mut follower = start::<f32>(&how(Scheme::Simpson, Softness::Local), &TERMS, friction);
        to(&mut follower, 6.0, 0.0);
        let sudden = size(&follower);
        for tick in 1..=600 {
            to(&mut follower, 6.0, 0.02);
            if tick % 200 == 0 {
                let (found, expected) = (size(&follower) / sudden, left(&TERMS, 0.02 * f64::from(tick)));
                std::println!("m = {friction}, tick {tick}: {found} against {expected}");
                assert!(
                    (found / expected - 1.0).abs() < 5e-3,
                    "m = {friction}, tick {tick}: {found} against {expected}"
                );
            }
        }
    }
}

/// Ribs relax as beams and hinges do, in both precisions, welded and with necks.
#[test]
fn ribs_relax_as_their_material() {
    let mut welded = ladder_80();
    ribs(&mut welded, 1.2);
    let mut necked = welded.clone();
    necked.hinge = ladder_80().hinge;
    necked.lamellae.kind = LamellaKind::Rib(Ribs { ends: RibEnds::Hinged, ..Ribs::WELDED });
    for design in [&welded, &necked] {
        let how = how(Scheme::Simpson, Softness::Fixed(1e-9));
        let mut double = start_of::<f64>(design, &how, &TERMS, 0.0);
        let mut single = start_of::<f32>(design, &self::how(Scheme::Simpson, Softness::Local), &TERMS, 0.0);
        to(&mut double, 6.0, 0.0);
        to(&mut single, 6.0, 0.0);
        let sudden = (size(&double), size(&single));
        let mut time = 0.0;
        for step in [0.03, 1.0, 40.0] {
            to(&mut double, 6.0, step);
            to(&mut single, 6.0, step);
            time += step;
            let expected = left(&TERMS, time);
            let found = (size(&double) / sudden.0, size(&single) / sudden.1);
            std::println!("{:?} {time} s: {found:?} against {expected}", design.lamellae.kind);
            assert!((found.0 / expected - 1.0).abs() < 1e-6, "{time} s: {found:?} against {expected}");
            assert!((found.1 / expected - 1.0).abs() < 5e-3, "{time} s: {found:?} against {expected}");
        }
    }
}

/// A function of time.
type Law<'a> = &'a dyn Fn(f64) -> f64;

/// A beam under a small load that is put on at once, that grows evenly, and that swings: a standard linear solid's compliance.
#[test]
fn a_beam_creeps_as_a_standard_linear_solid() {
    let (part, time) = (0.4, 2.0);
    let stays = 1.0 - part;
    // Retardation is slower than relaxation.
    let slow = time / stays;
    let creep = |t: f64| (1.0 - part * libm::exp(-t / slow)) / stays;
    let ramp = |t: f64| (t + part * slow * libm::expm1(-t / slow)) / stays;
    let speed = 1.3;
    let swing = |t: f64| {
        // J(t) convolved with the rate of sin ωt.
        let x = speed * slow;
        let under = part * x / (1.0 + x * x);
        (libm::sin(speed * t) - under * (libm::cos(speed * t) + x * libm::sin(speed * t) - libm::exp(-t / slow)))
            / stays
    };
    let (away, load, step) = (-60.0_f64, 3e-4, 0.002);
    for scheme in [Scheme::Simpson, Scheme::Trapezoid] {
        // Under opposite loads, so that what is not linear in a small one cancels.
        let mut both =
            [1.0, -1.0].map(|sign| (sign, start::<f64>(&how(scheme, Softness::Local), &[[part, time]], 0.0)));
        let mut bend = |begins: bool, by: f64, seconds: f64| {
            let [above, below] = both.each_mut().map(|(sign, follower)| {
                if begins {
                    assert!(follower.begin(away.to_radians()));
                }
                follower.set_dead_load(usize::MAX, [*sign * by * load, 0.0]);
                to(follower, away, seconds);
                follower.solution().tip()[0]
            });
            above - below
        };
        let sudden = bend(true, 1.0, 0.0);
        let laws: [(&str, f64, Law<'_>, Law<'_>); 3] = [
            ("creep", 1.0, &|_| 1.0, &creep),
            ("ramp", 0.0, &|t| t, &ramp),
            ("sine", 0.0, &|t| libm::sin(speed * t), &swing),
        ];
        for (name, first, force, answer) in laws {
            bend(true, first, 0.0);
            let worst = (1..=1000).fold(0.0_f64, |worst, tick| {
                let t = step * f64::from(tick);
                worst.max((bend(false, force(t), step) / sudden - answer(t)).abs())
            });
            std::println!("{scheme:?}, {name}: off by {worst:.1e} of the sudden deflection");
            assert!(worst < 1e-6, "{scheme:?}, {name}: {worst:e}");
        }
    }
}

/// Steps of half a degree give what fine ones do, closing and opening, at any speed.
#[test]
fn coarse_steps_agree_with_fine_ones() {
    for speed in [1.0, 10.0, 100.0] {
        let path = |parts: u32| {
            let mut follower = start::<f64>(&how(Scheme::Simpson, Softness::Local), &TERMS, 0.0);
            let mut forces = std::vec::Vec::new();
            for half in (1..=16).chain((8..16).rev()) {
                let from = follower.solution().coordinate().to_degrees();
                let to_degrees = 0.5 * f64::from(half);
                for part in 1..=parts {
                    let at = from + (to_degrees - from) * f64::from(part) / f64::from(parts);
                    to(&mut follower, at, (to_degrees - from).abs() / speed / f64::from(parts));
                }
                forces.push(size(&follower));
            }
            forces
        };
        let (coarse, fine) = (path(1), path(16));
        let most = fine.iter().fold(0.0_f64, |most, &force| most.max(force));
        let worst = coarse.iter().zip(&fine).fold(0.0_f64, |worst, (a, b)| worst.max((a - b).abs()));
        std::println!("{speed}°/s: {:.4} % of the largest force", 100.0 * worst / most);
        assert!(worst < 2e-4 * most, "{speed}°/s: {worst} N of {most} N");
    }
}

/// The time of calls that came to nothing is not lost.
#[test]
fn missed_ticks_count_with_their_time() {
    let mut all = start::<f64>(&how(Scheme::Simpson, Softness::Local), &TERMS, 0.0);
    let mut missing = start::<f64>(&how(Scheme::Simpson, Softness::Local), &TERMS, 0.0);
    for follower in [&mut all, &mut missing] {
        to(follower, 6.0, 0.6);
    }
    to(&mut all, 6.0, 2.0);
    for _ in 0..3 {
        missing.follow_within(Target { coordinate: 6.0_f64.to_radians(), time_step_s: 0.5 }, 0);
    }
    to(&mut missing, 6.0, 0.5);
    assert!((size(&all) - size(&missing)).abs() < 1e-6 * size(&all), "{} {}", size(&all), size(&missing));
}

/// Derivatives are those of a sudden change.
#[test]
fn derivatives_agree_with_sudden_differences() {
    let mut follower = start::<f64>(&how(Scheme::Simpson, Softness::Local), &TERMS, 0.0);
    to(&mut follower, 6.0, 3.0);
    to(&mut follower, 6.0, 10.0);
    let derivative = follower.sensitivity().expect("in contact").coordinate.force;
    let step = 1e-4;
    let beside = |sign: f64| {
        let mut other = start::<f64>(&how(Scheme::Simpson, Softness::Local), &TERMS, 0.0);
        to(&mut other, 6.0, 3.0);
        to(&mut other, 6.0, 10.0);
        to(&mut other, 6.0 + sign * step, 0.0);
        other.solution().force_world()
    };
    let (above, below) = (beside(1.0), beside(-1.0));
    for i in 0..2 {
        let difference = (above[i] - below[i]) / (2.0 * step.to_radians());
        assert!((derivative[i] - difference).abs() < 1e-3 * difference.abs(), "{derivative:?} {difference}");
    }
}

/// With friction or memory there are no derivatives with respect to the design, whichever way they are asked for.
#[test]
fn designs_derivatives_are_refused() {
    let (design, how) = (ladder_80(), how(Scheme::Simpson, Softness::Local));
    let mut probe: Box<Probe<f64, Four>> = Box::new(Probe::EMPTY);
    for (terms, friction, is_given) in [(&[][..], 0.0, true), (&[], 0.6, false), (&TERMS, 0.0, false)] {
        let mut follower = start::<f64>(&how, terms, friction);
        to(&mut follower, 6.0, 1.0);
        let line = follower.design_derivative(&mut probe, [&design, &design], &how, 1e-5);
        let named = follower.design_sensitivity(&mut probe, &design, &how, DesignParameter::FrontThickness);
        assert_eq!((line.is_some(), named.is_some()), (is_given, is_given), "{} terms, m = {friction}", terms.len());
    }
}

/// A finger that has relaxed and is then made elastic is one that never had a memory.
#[test]
fn memory_that_is_taken_away_leaves_an_elastic_finger() {
    let mut follower = start::<f64>(&how(Scheme::Simpson, Softness::Local), &TERMS, 0.0);
    to(&mut follower, 6.0, 30.0);
    follower.set_prony(&[]).expect("no terms");
    assert!(follower.start(0.0));
    to(&mut follower, 6.0, 0.0);
    let mut elastic = start::<f64>(&how(Scheme::Simpson, Softness::Local), &[], 0.0);
    to(&mut elastic, 6.0, 0.0);
    assert!((size(&follower) / size(&elastic) - 1.0).abs() < 1e-9, "{} {}", size(&follower), size(&elastic));
}

/// A warmer finger is softer in all that it does, and what it cannot take is refused by name.
#[test]
fn the_modulus_follows_the_temperature() {
    let mut follower = start::<f64>(&how(Scheme::Simpson, Softness::Local), &TERMS, 0.0);
    to(&mut follower, 6.0, 1.0);
    let cold = size(&follower);
    follower.set_modulus_factor(0.5).expect("allowed");
    to(&mut follower, 6.0, 0.0);
    assert!((size(&follower) / cold - 0.5).abs() < 1e-9);
    assert_eq!(follower.set_modulus_factor(0.0).map_err(|error| error.name), Err("modulus factor"));
    assert_eq!(follower.set_prony(&[[0.1, 1.0]; 5]).map_err(|error| error.name), Err("prony terms"));
    assert_eq!(follower.set_prony(&[[1.0, 1.0]]).map_err(|error| error.name), Err("prony g"));
    assert_eq!(follower.set_prony(&[[0.6, 1.0]; 2]).map_err(|error| error.name), Err("sum of prony g"));
    assert_eq!(follower.set_prony(&[[0.1, 0.0]]).map_err(|error| error.name), Err("prony τ"));
    assert_eq!(Four::TERMS, 4);
}
