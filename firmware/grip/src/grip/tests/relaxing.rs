//! A grip on a finger that relaxes: it holds its force, goes on and never back, and noise does not lead it.

use super::{Bench, COUNT, LIMITS, Phase, TICK, Target};

/// What is left of a force that fades by 40 %: a tenth of a second, five seconds and 100 s.
#[derive(Clone, Debug)]
pub(super) struct Relaxing {
    pub relaxes: bool,
    /// Shares, times and what is left of the force's past changes.
    terms: [[f64; 3]; 3],
    elastic: f64,
    /// Greatest error of the reported force, counts, and the state of its random numbers.
    noise: f64,
    seed: u64,
}

impl Relaxing {
    pub const NONE: Self = Self { relaxes: false, terms: [[0.0, 1.0, 0.0]; 3], elastic: 0.0, noise: 0.0, seed: 1 };
    const TPU: Self =
        Self { relaxes: true, terms: [[0.15, 0.1, 0.0], [0.15, 5.0, 0.0], [0.1, 100.0, 0.0]], ..Self::NONE };

    /// The force at a place where an elastic one has this.
    pub fn faded(&self, elastic: f64) -> f64 {
        let missing = |[part, _, left]: &[f64; 3]| part * (self.elastic - left);
        elastic - self.terms.iter().map(missing).sum::<f64>()
    }

    /// A tick passes.
    pub fn pass(&mut self, elastic: f64) -> f64 {
        let change = elastic - self.elastic;
        for [_, time, left] in &mut self.terms {
            *left += change - (1.0 - (-TICK / *time).exp()) * (*left + change);
        }
        self.elastic = elastic;
        self.faded(elastic)
    }

    /// An error of the reported force, N.
    pub fn noise(&mut self, angle: f64) -> f64 {
        self.seed = self.seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let unit = (self.seed >> 40) as f64 / f64::from(1 << 24);
        self.noise * (2.0 * unit - 1.0) * COUNT * Bench::slope(angle)
    }
}

/// Ticks of ten minutes.
const TEN_MINUTES: usize = 300_000;

/// Ten minutes within 3 % or the nearest count, with a servo that follows and with one that sags and has friction.
#[test]
fn a_grip_holds_its_force_while_the_finger_relaxes() {
    for (sags, noise) in [(false, 0.0), (false, 0.5), (true, 0.0), (true, 0.5)] {
        for force in [5.0, 30.0] {
            let mut bench = if sags { Bench::sagging() } else { Bench { knows_slope: true, ..Bench::new(1) } };
            bench.relaxing = Relaxing { noise, ..Relaxing::TPU };
            bench.grip.grip(&Target::of(force), &LIMITS);
            let ticks = (0..5_000).find(|_| {
                bench.tick();
                bench.grip.phase() == Phase::Gripped
            });
            let what = format!("{force} N, sags {sags}, noise {noise}");
            assert!(ticks.is_some(), "no grip: {what}");
            let force = f64::from(force);
            let (mut worst, mut waits, mut back) = (0.0_f64, 0_u32, 0.0_f64);
            let (mut before, first) = (bench.grip.goal(), bench.grip.goal());
            for tick in 0..TEN_MINUTES {
                let now = bench.tick();
                let goal = bench.grip.goal();
                // The first second is the grip's: what relaxes in a tenth of a second still does.
                if tick > 500 {
                    worst = worst.max((now / force - 1.0).abs());
                    waits += u32::from(bench.grip.phase() != Phase::Gripped);
                    back = back.max(before - goal);
                }
                before = goal;
            }
            // At the end, where the elastic force is larger by two thirds.
            let count = Bench::slope(0.05 + force / 210.0) * COUNT / force;
            println!("{what}: within {:.2} %, a count is {:.2} %", 100.0 * worst, 100.0 * count);
            assert!(worst < f64::max(0.03, 0.8 * count), "{what}: {worst}, a count is {count}");
            assert!(back < 1e-9 && before > first, "{what}: back by {back}");
            assert!(waits < 500, "{what}: {waits} ticks not gripped");
        }
    }
}

/// A finger that might relax and does not: noise of a count leads it nowhere.
#[test]
fn noise_does_not_ratchet() {
    let mut bench = Bench { knows_slope: true, ..Bench::new(1) };
    bench.relaxing = Relaxing { relaxes: true, noise: 1.0, ..Relaxing::NONE };
    bench.grip.grip(&Target::of(5.0), &LIMITS);
    bench.run(1_000);
    assert_eq!(bench.grip.phase(), Phase::Gripped);
    let goal = bench.grip.goal();
    bench.run(TEN_MINUTES);
    assert!((bench.grip.goal() - goal).abs() < 1.01 * COUNT, "{} counts", (bench.grip.goal() - goal) / COUNT);
}
