//! How the cost grows: with elements, with lamellae (both linear: see the fits) and with cores. `cargo xtask bench` prints it.
//!
//! Ladder-80, cylinder of 80 mm at Mid height, double precision: median time of one count of the servo's sensor in contact, closing
//! to 8° and opening again. The batch closes random fingers on random circles, one after the other on each core. Everything that is
//! compared is timed in turn, several times, and its quietest time counts: a virtual machine is now fast, now slow.

use std::num::NonZero;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::Instant;

use model_core::design::{Attachments, Design};
use model_core::discretise::{Discretisation, Elements, Physics, Sampling, Scheme};
use model_core::equilibrium::{Follower, Settings};
use model_core::object::Motion;
use model_core::size::Paper;
use reference_tests::random::{Case, Cases};
use reference_tests::{COUNT, circle_80, ladder_80};

type Problem = Box<dyn std::error::Error>;

const ROUNDS: usize = 20;
const LAST_COUNT: i32 = 91;
const BATCH: usize = 400;

fn main() -> Result<(), Problem> {
    let mut sizes = Vec::new();
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
        sizes.push((elements, ladder_80(), how));
    }
    print_fit("elements (trapezoid, seven lamellae)", &quietest(&sizes)?);

    let mut sizes = Vec::new();
    for lamellae in 3..=10 {
        let mut design = ladder_80();
        let pitch = 60.0 / f64::from(lamellae);
        design.lamellae.attachments = Attachments::Heights((1..=lamellae).map(|k| pitch * f64::from(k)).collect());
        sizes.push((f64::from(lamellae), design, Discretisation::fine(Physics::Paper)));
    }
    print_fit("lamellae (simpson, 4 elements per span, 2 per hinge)", &quietest(&sizes)?);
    batch()
}

/// Sizes with their times, µs.
fn quietest(sizes: &[(f64, Design, Discretisation)]) -> Result<Vec<(f64, f64)>, Problem> {
    let mut points: Vec<(f64, f64)> = sizes.iter().map(|(size, ..)| (*size, f64::INFINITY)).collect();
    for _ in 0..ROUNDS {
        for ((_, design, how), (_, least)) in sizes.iter().zip(&mut points) {
            *least = least.min(warm_us(design, how)?);
        }
    }
    Ok(points)
}

/// Median of a count in contact, µs.
fn warm_us(design: &Design, how: &Discretisation) -> Result<f64, Problem> {
    let mut follower: Box<Follower<f64, Paper>> = Box::new(Follower::EMPTY);
    follower.configure(design, how)?;
    follower.set_settings(Settings::DEFAULT);
    follower.set_object(circle_80(45.0), Motion::Rotating { axis: design.motor_axis });
    let mut times = Vec::new();
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
    for (threads, rate) in (1..).zip(&rates) {
        println!(
            "a batch of {BATCH} random cases, {threads} thread(s): {rate:.0} cases per second, {:.2} times one thread's \
             ({solved} solved)",
            rate / rates[0]
        );
    }
    Ok(())
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
