//! The force alone, faded, against the finger whose every strain remembers: where it holds and where it does not.

use std::boxed::Box;
use std::vec::Vec;

use super::{Fading, Load};
use crate::design::ladder_80;
use crate::discretise::{Discretisation, Physics};
use crate::equilibrium::{Follower, Target};
use crate::object::{Motion, ObjectDesign};
use crate::real::Real;

crate::fixed_size!(
    /// Four terms, with friction.
    Four, cells 8, nodes 126, samples 96, contacts 44, friction, memory 4
);

const TERMS: [[f64; 2]; 3] = [[0.15, 0.1], [0.15, 5.0], [0.1, 100.0]];

/// A finger whose strains remember, and the elastic one whose force fades, on the same way.
struct Pair {
    nodes: Box<Follower<f64, Four>>,
    elastic: Box<Follower<f64, Four>>,
    force: Fading<f64>,
}

fn load<T: Real>(follower: &Follower<T, Four>) -> Load<T> {
    let [x, y] = follower.solution().force_world();
    [x, y, follower.solution().motor_torque()]
}

fn size([x, y, _]: Load<f64>) -> f64 {
    x.hypot(y)
}

impl Pair {
    fn open(height: f64, friction: f64) -> Self {
        Self::of(&TERMS, height, friction)
    }

    fn of(terms: &[[f64; 2]], height: f64, friction: f64) -> Self {
        let [nodes, elastic] = [terms, &[]].map(|terms| {
            let mut follower: Box<Follower<f64, Four>> = Box::new(Follower::EMPTY);
            let design = ladder_80();
            follower.configure(&design, &Discretisation::estimator(Physics::Extended)).expect("a valid finger");
            follower.set_prony(terms).expect("valid terms");
            follower.set_friction(friction).expect("a valid coefficient");
            let object = ObjectDesign::Circle { centre: [41.0, height], radius: 40.0 };
            follower.set_object(object, Motion::Rotating { axis: design.motor_axis });
            assert!(follower.start(0.0));
            follower
        });
        let mut force = Fading::ELASTIC;
        force.set(terms).expect("valid terms");
        Self { nodes, elastic, force }
    }

    /// Goes to an angle within a time; the loads by the nodes and by the force alone.
    fn to(&mut self, degrees: f64, seconds: f64) -> [Load<f64>; 2] {
        let target = Target { coordinate: degrees.to_radians(), time_step_s: seconds };
        for follower in [&mut self.nodes, &mut self.elastic] {
            let outcome = follower.follow(target);
            assert!(outcome.status.is_trustworthy(), "{degrees}°: {}", outcome.status);
        }
        self.force.pass(seconds);
        let elastic = load(&self.elastic);
        if self.elastic.friction() == 0.0 {
            return [load(&self.nodes), self.force.accept(elastic)];
        }
        let normal: f64 = self.elastic.solution().contacts().map(|contact| contact.force).sum();
        let [faded, ..] = self.force.accept([normal, 0.0, 0.0]);
        let part = if normal > 0.0 { faded / normal } else { 0.0 };
        [load(&self.nodes), elastic.map(|x| part * x)]
    }

    /// Goes evenly in steps of a quarter of a degree; angle and loads after each.
    fn sweep(&mut self, from: f64, to: f64, speed: f64) -> Vec<(f64, [Load<f64>; 2])> {
        let steps = ((to - from).abs() / 0.25).round();
        let step = (to - from) / steps;
        (1..=steps as u32)
            .map(|k| {
                let at = from + step * f64::from(k);
                (at, self.to(at, step.abs() / speed))
            })
            .collect()
    }
}

/// Times of a hold, s: as a ladder from a tick to five minutes.
const HOLD: [f64; 8] = [0.002, 0.02, 0.2, 1.0, 5.0, 20.0, 74.0, 200.0];

/// Closing and holding is what the form is for.
#[test]
fn closing_and_holding_for_five_minutes_is_within_half_a_per_cent() {
    for (height, most) in [(30.0, 8.0), (45.0, 8.0), (60.0, 6.0)] {
        for speed in [2.0, 20.0, 100.0] {
            let mut pair = Pair::open(height, 0.0);
            let (mut worst, mut torque) = (0.0_f64, 0.0_f64);
            let mut look = |[nodes, force]: [Load<f64>; 2], from: f64| {
                if size(nodes) > from {
                    worst = worst.max((size(force) / size(nodes) - 1.0).abs());
                    torque = torque.max((force[2] / nodes[2] - 1.0).abs());
                }
            };
            let closed = pair.sweep(0.0, most, speed);
            let peak = closed.iter().map(|(_, [nodes, _])| size(*nodes)).fold(0.0, f64::max);
            closed.iter().for_each(|(_, loads)| look(*loads, 0.2 * peak));
            HOLD.iter().for_each(|&seconds| look(pair.to(most, seconds), 0.0));
            std::println!("{height} mm, {speed} °/s: force {:.3} %, torque {:.3} %", 100.0 * worst, 100.0 * torque);
            assert!(worst < 0.0035 && torque < 0.004, "{height} mm, {speed} °/s: {worst} {torque}");
        }
    }
}

/// Opening is not: the elastic finger has let go where the real one is still bent.
#[test]
fn opening_is_off_by_a_part_of_a_small_force() {
    let (mut of_peak, mut of_force, mut early) = (0.0_f64, 0.0_f64, 0.0_f64);
    for height in [30.0, 45.0] {
        for (speed, hold) in [(2.0, 0.1), (20.0, 0.1), (20.0, 300.0)] {
            let mut pair = Pair::open(height, 0.0);
            let closed = pair.sweep(0.0, 8.0, speed);
            let peak = closed.iter().map(|(_, [nodes, _])| size(*nodes)).fold(0.0, f64::max);
            pair.to(8.0, hold);
            let mut contact = [0.0; 2];
            for (at, loads) in pair.sweep(8.0, 0.0, speed) {
                let [nodes, force] = loads.map(size);
                let off = (force - nodes).abs();
                of_peak = of_peak.max(off / peak);
                if nodes > 0.1 * peak {
                    of_force = of_force.max(off / nodes);
                }
                (0..2).filter(|&i| size(loads[i]) > 0.0).for_each(|i| contact[i] = at);
            }
            std::println!("{height} mm, {speed} °/s after {hold} s: contact ends at {contact:?}°");
            early = early.max(contact[1] - contact[0]);
        }
    }
    std::println!("{:.1} % of the peak, {:.0} % of a small force, {early}° early", 100.0 * of_peak, 100.0 * of_force);
    assert!((0.01..0.05).contains(&of_peak), "{of_peak}");
    assert!((0.1..0.4).contains(&of_force), "{of_force}");
    assert!((0.25..1.5).contains(&early), "{early}°");
}

/// With friction the elastic finger slides other ways while it opens.
#[test]
fn friction_adds_to_it_while_opening_only() {
    let (mut closing, mut opening) = (0.0_f64, 0.0_f64);
    let mut pair = Pair::open(45.0, 0.6);
    let mut held = 0.0;
    for (_, [nodes, force]) in pair.sweep(0.0, 8.0, 20.0) {
        held = size(nodes);
        closing = closing.max((size(force) - held).abs() / 9.0);
    }
    for seconds in HOLD {
        let [nodes, force] = pair.to(8.0, seconds);
        held = size(nodes);
        closing = closing.max((size(force) / held - 1.0).abs());
    }
    for (_, [nodes, force]) in pair.sweep(8.0, 0.0, 20.0) {
        opening = opening.max((size(force) - size(nodes)).abs() / held);
    }
    std::println!("closing and holding {:.2} %, opening {:.1} % of the held force", 100.0 * closing, 100.0 * opening);
    assert!(closing < 0.01 && (0.02..0.25).contains(&opening), "{closing} {opening}");
}

/// Near a fold the shape changes at the same angle: the form knows nothing of that.
#[test]
fn a_fold_is_not_seen() {
    let mut pair = Pair::open(60.0, 0.0);
    let mut off = |from: f64, to: f64| {
        let all = pair.sweep(from, to, 20.0);
        all.iter().map(|(_, [nodes, force])| (size(*force) / size(*nodes) - 1.0).abs()).fold(0.0, f64::max)
    };
    let (before, near) = (off(0.0, 6.0), off(6.0, 11.0));
    std::println!("before {:.2} %, near the fold {:.1} %", 100.0 * before, 100.0 * near);
    assert!(before < 0.0035 && (0.005..0.3).contains(&near), "{before} {near}");
}

/// Slow terms fade by less than the last digit of single precision in a tick.
#[test]
fn single_precision_keeps_slow_terms() {
    let terms = [[0.2, 1e3], [0.2, 1e5]];
    let (mut single, mut double) = (Fading::<f32>::ELASTIC, Fading::<f64>::ELASTIC);
    single.set(&terms).expect("valid");
    double.set(&terms).expect("valid");
    let load = [5.0, -1.5, 400.0];
    single.accept(load.map(|x| x as f32));
    double.accept(load);
    for _ in 0..300_000 {
        single.pass(0.002);
        single.accept(load.map(|x| x as f32));
        double.pass(0.002);
        double.accept(load);
    }
    let (single, double) = (single.faded(load.map(|x| x as f32)), double.faded(load));
    let expected = 1.0 + 0.2 * libm::expm1(-0.6) + 0.2 * libm::expm1(-0.006);
    for i in 0..3 {
        assert!((double[i] / load[i] - expected).abs() < 1e-7, "{double:?} {expected}");
        assert!((f64::from(single[i]) / double[i] - 1.0).abs() < 1e-5, "{single:?} {double:?}");
    }
}

/// Steps of any length give the same, and what is refused is named.
#[test]
fn steps_of_any_length_agree() {
    let ramp = |steps: u32| {
        let mut fading = Fading::<f64>::ELASTIC;
        fading.set(&TERMS).expect("valid");
        let mut last = [0.0; 3];
        for step in 1..=steps {
            fading.pass(3.0 / f64::from(steps));
            last = fading.accept([f64::from(step) / f64::from(steps), 0.0, 0.0]);
        }
        last[0]
    };
    for steps in [1, 7, 3000] {
        assert!((ramp(steps) - ramp(30_000)).abs() < 1e-9, "{steps}");
    }
    let mut fading = Fading::<f32>::ELASTIC;
    assert_eq!(fading.set(&[[0.1, 1.0]; 5]).map_err(|error| error.name), Err("prony terms"));
    assert_eq!(fading.set(&[[0.1, 0.0]]).map_err(|error| error.name), Err("prony τ"));
    assert!(!fading.fades());
}

/// The terms with one number changed: of term k, its part (0) or relatively its time (1).
fn changed(k: usize, number: usize, by: f64) -> Vec<[f64; 2]> {
    let mut terms = TERMS.to_vec();
    terms[k][number] += if number == 0 { by } else { by * terms[k][1] };
    terms
}

/// Against differences of the form itself, over closing, holds, opening and closing again: at the accepted load and some time after it.
#[test]
fn slopes_are_derivatives_of_the_faded_force() {
    let loads =
        [[1.0, 0.2, 0.0], [3.0, -0.4, 0.0], [6.0, -2.0, 0.0], [6.0, -2.0, 0.0], [4.0, -1.0, 0.0], [7.0, -1.5, 0.0]];
    let waits = [0.02, 0.3, 1.0, 40.0, 0.5, 3.0];
    let at = |terms: &[[f64; 2]], steps: usize, later: f64| {
        let mut force = Fading::<f64>::ELASTIC;
        force.set(terms).expect("valid terms");
        for (load, wait) in loads.iter().zip(waits).take(steps) {
            force.pass(wait);
            force.accept(*load);
        }
        force.pass(later);
        let load = loads[steps - 1];
        (size(force.faded(load)), force.slopes(load))
    };
    for steps in 1..=loads.len() {
        for later in [0.0, 0.7] {
            let (_, slopes) = at(&TERMS, steps, later);
            for k in 0..TERMS.len() {
                for number in [0, 1] {
                    let by = 1e-4;
                    let [more, less] = [by, -by].map(|by| at(&changed(k, number, by), steps, later).0);
                    let expected = (more - less) / (2.0 * by);
                    let found = slopes[k][number];
                    assert!((found - expected).abs() < 1e-6, "{steps}, {later}, {k}, {number}: {found} {expected}");
                }
            }
            assert_eq!(slopes[3], [0.0; 2], "no fourth term");
        }
    }
}

/// Against differences of the finger whose strains remember, closed and after every hold.
#[test]
fn slopes_are_those_of_the_finger_within_a_hundredth_of_the_force() {
    for (height, speed) in [(30.0, 20.0), (45.0, 2.0), (60.0, 20.0)] {
        let way = |terms: &[[f64; 2]]| {
            let mut pair = Pair::of(terms, height, 0.0);
            pair.sweep(0.0, 6.0, speed);
            HOLD.map(|seconds| {
                let force = size(pair.to(6.0, seconds)[0]);
                (force, pair.force.slopes(load(&pair.elastic)))
            })
        };
        let held = way(&TERMS);
        for k in 0..TERMS.len() {
            for number in [0, 1] {
                let by = 0.01;
                let [more, less] = [by, -by].map(|by| way(&changed(k, number, by)));
                for ((more, less), (force, slopes)) in more.iter().zip(&less).zip(&held) {
                    let (expected, found) = ((more.0 - less.0) / (2.0 * by), slopes[k][number]);
                    assert!(
                        (found - expected).abs() < 0.01 * force,
                        "{height}, {k}, {number}: {found} {expected} of {force}"
                    );
                }
            }
        }
    }
}

/// Ten minutes of ticks.
#[test]
fn single_precision_keeps_slopes_of_slow_terms() {
    let slopes = |seconds: f64, terms: &[[f64; 2]]| {
        let mut single = Fading::<f32>::ELASTIC;
        single.set(terms).expect("valid terms");
        single.accept([5.0, 0.0, 0.0]);
        for _ in 0..(600.0 / seconds) as u32 {
            single.pass(seconds);
            single.accept([5.0, 0.0, 0.0]);
        }
        single.slopes([5.0, 0.0, 0.0])
    };
    let terms = [[0.2, 30.0], [0.1, 1e4]];
    let found = slopes(0.002, &terms);
    for ([part, time], slope) in terms.iter().zip(found) {
        // A step that is held: F/Fₑ = 1 − g (1 − e^(−t/τ)).
        let ratio = 600.0 / time;
        let expected = [5.0 * (-ratio).exp_m1(), 5.0 * part * ratio * (-ratio).exp()];
        for (found, expected) in slope.into_iter().zip(expected) {
            assert!((f64::from(found) - expected).abs() < 0.005, "{time} s: {found} {expected}");
        }
    }
}
