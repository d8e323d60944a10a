//! How the cost grows: with elements, with lamellae (both linear: see the fits) and with cores.
//!
//! Double precision: median time of one count of the servo's sensor in contact, closing to 8° and opening again. The batch closes
//! random fingers on random circles, one after the other on each core. Everything that is compared is timed in turn, several times,
//! and its quietest time counts: a virtual machine is now fast, now slow.

use std::fmt;
use std::num::NonZero;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use model_core::design::{Attachments, Design};
use model_core::discretise::{Discretisation, Elements, Physics, Sampling, Scheme, Softness};
use model_core::equilibrium::Follower;
use model_core::object::Motion;
use model_core::size::Paper;
use reference_tests::random::{Case, Cases};
use reference_tests::{COUNT, ladder_80};

use crate::ladder::{counts, follower_of};

const ROUNDS: usize = 20;
const LAST_COUNT: i32 = 91;
const BATCH: usize = 400;

/// Every growth that is measured.
#[derive(Clone, Debug)]
pub struct Scaling {
    pub elements: Fit,
    pub lamellae: Fit,
    pub batch: Batch,
}

/// Times against a size, and the line through them: t = offset + slope·size, µs.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    pub size: &'static str,
    /// Size and time, µs.
    pub points: Vec<(f64, f64)>,
    pub offset_us: f64,
    pub slope_us: f64,
    pub r_squared: f64,
}

/// Random cases on one core and on more.
#[derive(Clone, Debug)]
pub struct Batch {
    /// Cases per second with 1, 2, … threads.
    pub rates: Vec<f64>,
    /// Cases with a trustworthy solution.
    pub solved: usize,
}

/// Times everything.
pub fn measure() -> Result<Scaling> {
    let mut sizes = Vec::new();
    for level in [2, 4, 6, 8, 10] {
        let how = Discretisation {
            scheme: Scheme::Trapezoid,
            elements: Elements::PerBeam { beam: 17 * level, hinge: 2 * level },
            sampling: Sampling::Nodes,
            softness: Softness::Fixed(0.0),
            physics: Physics::Paper,
        };
        // Two beams and both hinges of seven lamellae.
        let elements = 2.0 * 17.0 * f64::from(level) + 14.0 * 2.0 * f64::from(level);
        sizes.push((elements, ladder_80(), how));
    }
    let elements = Fit::of("elements (trapezoid, seven lamellae)", quietest(&sizes)?);

    let mut sizes = Vec::new();
    for lamellae in 3..=10 {
        let mut design = ladder_80();
        let pitch = 60.0 / f64::from(lamellae);
        design.lamellae.attachments = Attachments::Heights((1..=lamellae).map(|k| pitch * f64::from(k)).collect());
        sizes.push((f64::from(lamellae), design, Discretisation::fine(Physics::Paper)));
    }
    let lamellae = Fit::of("lamellae (simpson, 4 elements per span, 2 per hinge)", quietest(&sizes)?);
    Ok(Scaling { elements, lamellae, batch: batch()? })
}

/// Sizes with their times, µs.
fn quietest(sizes: &[(f64, Design, Discretisation)]) -> Result<Vec<(f64, f64)>> {
    let mut points: Vec<(f64, f64)> = sizes.iter().map(|(size, ..)| (*size, f64::INFINITY)).collect();
    for _ in 0..ROUNDS {
        for ((_, design, how), (_, least)) in sizes.iter().zip(&mut points) {
            *least = least.min(warm_us(design, how)?);
        }
    }
    Ok(points)
}

/// Median of a count in contact, µs.
fn warm_us(design: &Design, how: &Discretisation) -> Result<f64> {
    let mut follower = follower_of::<f64, Paper>(design, how)?;
    let mut times = Vec::new();
    follower.start(0.0);
    for count in counts(LAST_COUNT) {
        let clock = Instant::now();
        let outcome = follower.follow(f64::from(count) * COUNT);
        let spent = clock.elapsed();
        if !outcome.status.is_trustworthy() {
            bail!("{how:?}: {} at count {count}", outcome.status);
        }
        if follower.solution().touching() > 0 {
            times.push(spent.as_secs_f64() * 1e6);
        }
    }
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied().context("the finger never touched")
}

impl Fit {
    /// Least squares.
    fn of(size: &'static str, points: Vec<(f64, f64)>) -> Self {
        let n = points.len() as f64;
        let mean = |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / n;
        let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
        let slope_us = mean(&|p| (p.0 - x) * (p.1 - y)) / mean(&|p| (p.0 - x).powi(2));
        let offset_us = y - slope_us * x;
        let spread = mean(&|p| (p.1 - y).powi(2));
        let left = mean(&|p| (p.1 - offset_us - slope_us * p.0).powi(2));
        Self { size, offset_us, slope_us, r_squared: 1.0 - left / spread, points }
    }
}

/// Cases per second on one core and on all.
fn batch() -> Result<Batch> {
    let cases: Vec<_> = Cases::seeded(1).take(BATCH).collect();
    let cores = thread::available_parallelism().map_or(1, NonZero::get);
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pools = (1..=cores).map(pool).collect::<Result<Vec<_>, _>>()?;
    let mut rates = vec![0.0_f64; cores];
    let mut solved: usize = 0;
    for _ in 0..ROUNDS {
        for (pool, most) in pools.iter().zip(&mut rates) {
            let clock = Instant::now();
            let next = AtomicUsize::new(0);
            let counts = pool.broadcast(|_| {
                // One solver per core, which takes the next case when it is through with one.
                let mut follower = Box::new(Follower::EMPTY);
                let cases = std::iter::from_fn(|| cases.get(next.fetch_add(1, Ordering::Relaxed)));
                cases.filter(|case| is_solved(&mut follower, case)).count()
            });
            solved = counts.into_iter().sum();
            *most = most.max(BATCH as f64 / clock.elapsed().as_secs_f64());
        }
    }
    Ok(Batch { rates, solved })
}

/// Whether a random case has a trustworthy solution.
fn is_solved(follower: &mut Box<Follower<f64, Paper>>, case: &Case) -> bool {
    if follower.configure(&case.design, &Discretisation::reduced(Physics::Paper)).is_err() {
        return false;
    }
    follower.set_object(case.object(), Motion::Rotating { axis: case.design.motor_axis });
    follower.start(case.angle);
    follower.follow(case.angle).status.is_trustworthy()
}

impl fmt::Display for Scaling {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}{}", self.elements, self.lamellae, self.batch)
    }
}

impl fmt::Display for Fit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "a count against {}", self.size)?;
        for (size, time) in &self.points {
            let line = self.offset_us + self.slope_us * size;
            writeln!(f, "  {size:>6.0} {time:>8.1} µs, line {line:>8.1} µs ({:+.1} %)", 100.0 * (time / line - 1.0))?;
        }
        writeln!(f, "  {:.1} µs + {:.3} µs each, R² {:.4}", self.offset_us, self.slope_us, self.r_squared)
    }
}

impl fmt::Display for Batch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let one = self.rates.first().copied().unwrap_or(f64::NAN);
        for (threads, rate) in (1..).zip(&self.rates) {
            writeln!(
                f,
                "a batch of {BATCH} random cases, {threads} thread(s): {rate:.0} cases per second, {:.2} times one \
                 thread's ({} solved)",
                rate / one,
                self.solved
            )?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_found() {
        let fit = Fit::of("x", vec![(1.0, 5.0), (2.0, 7.0), (4.0, 11.0)]);
        assert!((fit.offset_us - 3.0).abs() < 1e-12 && (fit.slope_us - 2.0).abs() < 1e-12, "{fit:?}");
        assert!((fit.r_squared - 1.0).abs() < 1e-12, "{fit:?}");
        let rough = Fit::of("x", vec![(1.0, 5.0), (2.0, 9.0), (3.0, 5.0)]);
        assert!(rough.r_squared < 0.1, "{rough:?}");
    }
}
