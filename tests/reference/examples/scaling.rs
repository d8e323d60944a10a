//! How the cost grows: with elements, with lamellae (both linear: see the fits) and with cores. `cargo xtask bench` prints it.
//!
//! Ladder-80, cylinder of 80 mm at Mid height, double precision: median time of one count of the servo's sensor in contact, closing
//! to 8° and opening again. The batch closes random fingers on random circles, one after the other on each core.

use std::num::NonZero;
use std::thread;
use std::time::Instant;

use model_core::design::{Attachments, Design};
use model_core::discretise::{Discretisation, Elements, Physics, Sampling, Scheme};
use model_core::equilibrium::{Follower, Settings};
use model_core::object::Motion;
use model_core::size::Paper;
use rayon::prelude::*;
use reference_tests::random::Cases;
use reference_tests::{COUNT, circle_80, ladder_80};

type Problem = Box<dyn std::error::Error>;

const SWEEPS: usize = 5;
const LAST_COUNT: i32 = 91;
const BATCH: usize = 400;

fn main() -> Result<(), Problem> {
    let mut points = Vec::new();
    for level in [2, 4, 6, 8, 10] {
        let how = Discretisation {
            scheme: Scheme::Trapezoid,
            elements: Elements::PerBeam { beam: 17 * level, hinge: 2 * level },
            sampling: Sampling::Nodes,
            softness: 0.0,
            physics: Physics::Paper,
        };
        // Two beams and both hinges of seven lamellae.
        let elements = 2.0 * 17.0 * f64::from(level) + 14.0 * 2.0 * f64::from(level);
        points.push((elements, warm_us(&ladder_80(), &how)?));
    }
    print_fit("elements (trapezoid, seven lamellae)", &points);

    let mut points = Vec::new();
    for lamellae in 3..=10 {
        let mut design = ladder_80();
        let pitch = 60.0 / f64::from(lamellae);
        design.lamellae.attachments = Attachments::Heights((1..=lamellae).map(|k| pitch * f64::from(k)).collect());
        points.push((f64::from(lamellae), warm_us(&design, &Discretisation::fine(Physics::Paper))?));
    }
    print_fit("lamellae (simpson, 4 elements per span, 2 per hinge)", &points);
    batch()
}

/// Median of a count in contact, µs.
fn warm_us(design: &Design, how: &Discretisation) -> Result<f64, Problem> {
    let mut follower: Box<Follower<f64, Paper>> = Box::new(Follower::EMPTY);
    follower.configure(design, how)?;
    follower.set_settings(Settings::DEFAULT);
    follower.set_object(circle_80(45.0), Motion::Rotating { axis: design.motor_axis });
    let mut times = Vec::new();
    for _ in 0..SWEEPS {
        follower.start(0.0);
        for count in (0..=LAST_COUNT).chain((0..LAST_COUNT).rev()) {
            let clock = Instant::now();
            let outcome = follower.follow(f64::from(count) * COUNT);
            let spent = clock.elapsed();
            if !outcome.status.is_trustworthy() {
                return Err(format!("{how:?}: {} at count {count}", outcome.status).into());
            }
            if follower.touching() > 0 {
                times.push(spent.as_secs_f64() * 1e6);
            }
        }
    }
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied().ok_or_else(|| "the finger never touched".into())
}

/// Least squares t = a + b n, and how far the times are from it.
fn print_fit(what: &str, points: &[(f64, f64)]) {
    let n = points.len() as f64;
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / n;
    let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
    let slope = mean(&|p| (p.0 - x) * (p.1 - y)) / mean(&|p| (p.0 - x) * (p.0 - x));
    let fit = |at: f64| y + slope * (at - x);
    let spread = mean(&|p| (p.1 - y).powi(2));
    let left = mean(&|p| (p.1 - fit(p.0)).powi(2));
    println!("a count against {what}");
    for (at, time) in points {
        println!("  {at:>6.0} {time:>8.1} µs, line {:>8.1} µs ({:+.1} %)", fit(*at), 100.0 * (time / fit(*at) - 1.0));
    }
    println!("  {:.1} µs + {slope:.3} µs each, R² {:.4}", fit(0.0), 1.0 - left / spread);
}

/// Cases per second on one core and on all.
fn batch() -> Result<(), Problem> {
    let cases: Vec<_> = Cases::seeded(1).take(BATCH).collect();
    let cores = thread::available_parallelism().map_or(1, NonZero::get);
    let mut rates = Vec::new();
    for threads in 1..=cores {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        let clock = Instant::now();
        let solved: usize = pool.install(|| {
            cases
                .par_iter()
                .map_init(
                    || Box::new(Follower::<f64, Paper>::EMPTY),
                    |follower, case| {
                        if follower.configure(&case.design, &Discretisation::reduced(Physics::Paper)).is_err() {
                            return 0;
                        }
                        follower.set_object(case.object(), Motion::Rotating { axis: case.design.motor_axis });
                        follower.start(case.angle);
                        usize::from(follower.follow(case.angle).status.is_trustworthy())
                    },
                )
                .sum()
        });
        rates.push(BATCH as f64 / clock.elapsed().as_secs_f64());
        let (first, now) = (rates[0], rates[rates.len() - 1]);
        println!(
            "a batch of {BATCH} random cases, {threads} thread(s): {now:.0} cases per second, {:.2} times one thread's \
             ({solved} solved)",
            now / first
        );
    }
    Ok(())
}
