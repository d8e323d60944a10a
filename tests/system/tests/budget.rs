//! A processor that has time for few iterations a tick, on the estimator itself: it keeps up with the finger, and in its time.

use std::cell::Cell;

use grip::Budget;
use gripper::{Model, steps};
use model_core::estimator::{Estimate, Estimator, EstimatorSettings};
use model_core::size::Reduced;
use model_core::status::Status;
use system_tests::{OBJECT, finger};

const COUNT: f64 = std::f64::consts::TAU / 4096.0;
/// 500 Hz.
const TICK: f64 = 0.002;
/// What an estimate and each of its iterations take with five samples per element, instructions (`cargo xtask bench rates`).
const FIXED: u32 = 70_000;
const EACH: u32 = 130_000;

/// What a closing and an opening have shown.
#[derive(Debug, Default)]
struct Seen {
    ticks: u32,
    /// Trustworthy ones in contact.
    sound: u32,
    touching: u32,
    /// Those that took longer than there was time.
    late: u32,
    oldest: u32,
    /// Largest error of a trustworthy force, N.
    error: f64,
}

/// Closes to 11° and opens at a speed, rad/s, with so much time per tick, instructions.
fn motion(speed: f64, left: u32) -> Seen {
    let finger = finger();
    let mut model: Box<Model> = Box::new(Model::EMPTY);
    model.configure(&finger.design, &finger.how).expect("a valid finger");
    model.set_object(OBJECT).expect("a valid object");
    let mut exact: Box<Estimator<f64, Reduced>> = Box::new(Estimator::EMPTY);
    exact.configure(&finger.design, &finger.how).expect("a valid finger");
    exact.set_object(OBJECT).expect("a valid object");
    // What it is compared with has all the time it needs.
    exact.set_budget(1000);
    let last = 11_f64.to_radians();
    let ticks = (last / (speed * TICK)) as u32;
    let mut budget = Budget::new(EstimatorSettings::DEFAULT.budget);
    let mut seen = Seen::default();
    for tick in (0..=ticks).chain((0..ticks).rev()) {
        let angle = (f64::from(tick) * speed * TICK / COUNT).round() * COUNT;
        // Where the clock is looked at between iterations, each has taken a step.
        let reads = Cell::new(0);
        let clock = || reads.replace(reads.get() + 1) * (FIXED + EACH);
        let (estimate, _) = steps::estimate(&mut model, &budget, angle, TICK, left, clock);
        let iterations = u32::from(estimate.iterations);
        let cost = FIXED + EACH * iterations;
        budget.spent(cost, iterations);
        seen.look(&estimate, &exact.update(angle), cost > left);
    }
    eprintln!("{speed} rad/s, {left} instructions a tick: {seen:?}");
    seen
}

impl Seen {
    fn look(&mut self, estimate: &Estimate, exact: &Estimate, is_late: bool) {
        self.ticks += 1;
        self.late += u32::from(is_late);
        self.oldest = self.oldest.max(estimate.age);
        if exact.status == Status::NoContact {
            return;
        }
        self.touching += 1;
        if estimate.status.is_trustworthy() {
            self.sound += 1;
            let [x, y] = [0, 1].map(|i| f64::from(estimate.force[i]) - f64::from(exact.force[i]));
            self.error = self.error.max(x.hypot(y));
        }
    }
}

/// Time for two steps and for one, slow and fast: hardly a tick late, the force never old.
#[test]
fn few_iterations_keep_up() {
    for (left, speed, sound) in
        [(420_000, 0.1, 0.99), (420_000, 0.35, 0.99), (420_000, 1.0, 0.95), (220_000, 0.1, 0.97), (220_000, 0.35, 0.95)]
    {
        let seen = motion(speed, left);
        assert!(seen.touching > seen.ticks / 2, "{seen:?}");
        assert!(f64::from(seen.sound) > sound * f64::from(seen.touching) && seen.oldest <= 5, "{seen:?}");
        assert!(seen.late == 0 && seen.error < 0.01, "{seen:?}");
    }
}
