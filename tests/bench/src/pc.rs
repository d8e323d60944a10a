//! What the solver costs on this PC, and the forces that the target's are compared with.
//!
//! Warm: one count of the servo's sensor (360°/4096), the least of the repetitions of each tick in contact of closing to 11° and
//! opening again, median over the ticks. Cold: from no contact to 11° by continuation in steps of 1°, the least of the repetitions.
//! Throughput: places solved per second by one core, 1° apart from no contact to 11°, each asked for by itself as a study asks.

use std::time::{Duration, Instant};

use anyhow::{Result, bail};
use model_core::discretise::{Discretisation, Physics, Sampling, Scheme};
use model_core::equilibrium::{Follower, Target};
use model_core::real::Real;
use model_core::size::{Paper, Reduced, Remembering, Rubbing, Size};
use model_core::status::Status;
use reference_tests::{COUNT, TERMS, TICK_S};

use crate::ladder::{PHYSICS, counts, follower, word};
use crate::peer;
use crate::spread::Spread;

const LAST_DEG: f64 = 11.0;
const LAST_COUNT: i32 = LAST_DEG as i32 * 4096 / 360;
/// Places of a study: 1° to the last angle.
const PLACES: u32 = LAST_DEG as u32;
const SWEEPS: usize = 12;
const COLD_SOLVES: usize = 31;
/// The counts over which a peer is compared.
const PEER_COUNTS: std::ops::RangeInclusive<i32> = 80..=110;

/// The microcontroller's model.
pub const REDUCED: &str = "simpson-17-1";
/// The same with room for friction.
pub const RUBBING: &str = "simpson-17-1-rubbing";
/// The same with two terms of a material with memory.
pub const REMEMBERING: &str = "simpson-17-1-memory";
/// Coefficients of friction of the rows with room for it, in hundredths.
const FRICTIONS: [u32; 2] = [0, 60];
/// The paper's.
pub const PAPER: &str = "paper-170-20";

/// Times of one model.
#[derive(Clone, Debug)]
pub struct Time {
    pub model: &'static str,
    pub physics: Physics,
    /// Coefficient of friction, in hundredths.
    pub friction: u32,
    /// `f32` or `f64`.
    pub precision: &'static str,
    /// One count, µs: median of the ticks.
    pub warm_us: f64,
    /// Their mean and the most expensive, µs.
    pub ticks_us: Spread,
    /// From no contact to the last angle, µs.
    pub cold_us: f64,
    /// Places per second and core, 1° apart.
    pub places_per_s: f64,
}

/// A discretisation: model, samples per element, physics; and the coefficient of friction, in hundredths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Model {
    pub name: &'static str,
    pub samples: u8,
    pub physics: Physics,
    pub friction: u32,
}

/// Forces at one tick of the sweep, world frame, N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Force {
    pub position: i32,
    pub double: [f64; 2],
    /// In single precision: bits, since the target's must be the same.
    pub single: [u32; 2],
}

/// The forces of a model over the sweep, tick by tick.
#[derive(Clone, Debug)]
pub struct Forces {
    pub model: Model,
    pub ticks: Vec<Force>,
}

/// Times of every model, physics and precision.
pub fn times() -> Result<Vec<Time>> {
    let mut times = Vec::new();
    for physics in PHYSICS {
        times.extend(both::<Reduced>(REDUCED, &Discretisation::reduced(physics), 0)?);
        times.extend(both::<Paper>("fine", &Discretisation::fine(physics), 0)?);
        times.extend(both::<Paper>(PAPER, &Discretisation::full(Scheme::Paper, physics), 0)?);
        times.extend(both::<Paper>("trapezoid-170-20", &Discretisation::full(Scheme::Trapezoid, physics), 0)?);
    }
    for friction in FRICTIONS {
        times.extend(both::<Rubbing>(RUBBING, &Discretisation::reduced(Physics::Extended), friction)?);
    }
    Ok(times)
}

fn both<S: Size>(model: &'static str, how: &Discretisation, friction: u32) -> Result<[Time; 2]> {
    Ok([time::<f64, S>(model, how, "f64", friction)?, time::<f32, S>(model, how, "f32", friction)?])
}

fn time<T: Real, S: Size>(
    model: &'static str,
    how: &Discretisation,
    precision: &'static str,
    friction: u32,
) -> Result<Time> {
    let mut follower = rubbing::<T, S>(how, friction)?;
    // What a tick takes is the least of its repetitions: whatever else the PC does only adds to it.
    let mut warm = vec![Duration::MAX; counts(LAST_COUNT).count()];
    for _ in 0..SWEEPS {
        follower.start(0.0);
        for (count, least) in counts(LAST_COUNT).zip(&mut warm) {
            let clock = Instant::now();
            let outcome = follower.follow(f64::from(count) * COUNT);
            let spent = clock.elapsed();
            if !outcome.status.is_trustworthy() {
                bail!("{model}, {}, {precision}: {} at count {count}", word(how.physics), outcome.status);
            }
            if follower.touching() > 0 {
                *least = spent.min(*least);
            }
        }
    }
    warm.retain(|least| *least < Duration::MAX);
    let mut cold = Duration::MAX;
    for _ in 0..COLD_SOLVES {
        let clock = Instant::now();
        follower.start(0.0);
        let outcome = follower.follow(LAST_DEG.to_radians());
        cold = clock.elapsed().min(cold);
        if !outcome.status.is_trustworthy() {
            bail!("{model}, {}, {precision}: {} at {LAST_DEG}°", word(how.physics), outcome.status);
        }
    }
    let mut study = Duration::MAX;
    for _ in 0..COLD_SOLVES {
        let clock = Instant::now();
        follower.start(0.0);
        for place in 1..=PLACES {
            let outcome = follower.follow(f64::from(place).to_radians());
            if !outcome.status.is_trustworthy() {
                bail!("{model}, {}, {precision}: {} at {place}°", word(how.physics), outcome.status);
            }
        }
        study = clock.elapsed().min(study);
    }
    Ok(Time {
        model,
        physics: how.physics,
        friction,
        precision,
        ticks_us: Spread::of(warm.iter().map(|time| time.as_secs_f64() * 1e6)),
        warm_us: median_us(&mut warm),
        cold_us: cold.as_secs_f64() * 1e6,
        places_per_s: f64::from(PLACES) / study.as_secs_f64(),
    })
}

fn median_us(times: &mut [Duration]) -> f64 {
    times.sort();
    times.get(times.len() / 2).map_or(f64::NAN, |time| time.as_secs_f64() * 1e6)
}

/// The model of *Geometrico-Static Modelling of a FRE Finger*, as another program solves it too: 0 to 11° in steps of 1°, then a
/// stretch of counts.
pub fn shared_problem() -> Result<peer::Run> {
    let mut run = peer::Run::default();
    let mut follower = follower::<f64, Paper>(&Discretisation::full(Scheme::Paper, Physics::Paper))?;
    let mut go = |from: Option<f64>, to: f64| -> Result<(f64, [f64; 2])> {
        let clock = Instant::now();
        if let Some(from) = from {
            follower.start(from);
        }
        let outcome = follower.follow(to);
        let spent_us = clock.elapsed().as_secs_f64() * 1e6;
        if outcome.status != Status::Converged {
            bail!("the peer's problem: {} at {to} rad", outcome.status);
        }
        Ok((spent_us, follower.force_finger()))
    };
    for repetition in 0..COLD_SOLVES {
        let (spent_us, force) = go(Some(0.0), LAST_DEG.to_radians())?;
        run.cold_us.push(spent_us);
        if repetition == 0 {
            run.forces.push(("cold".to_owned(), force));
        }
    }
    for sweep in 0..SWEEPS {
        go(Some(0.0), f64::from(*PEER_COUNTS.start()) * COUNT)?;
        for count in PEER_COUNTS.skip(1) {
            let (spent_us, force) = go(None, f64::from(count) * COUNT)?;
            run.warm_us.push(spent_us);
            if sweep == 0 {
                run.forces.push((count.to_string(), force));
            }
        }
    }
    Ok(run)
}

/// Forces of every model that the target runs.
pub fn forces() -> Result<Vec<Forces>> {
    let mut all = Vec::new();
    for physics in PHYSICS {
        for samples in [2, 4, 5] {
            let how = Discretisation { sampling: Sampling::PerElement(samples), ..Discretisation::reduced(physics) };
            all.push(forces_of::<Reduced>(Model { name: REDUCED, samples, physics, friction: 0 }, &how)?);
        }
        let how = Discretisation::full(Scheme::Paper, physics);
        all.push(forces_of::<Paper>(Model { name: PAPER, samples: 1, physics, friction: 0 }, &how)?);
    }
    let physics = Physics::Extended;
    for (samples, how) in [(4, Discretisation::reduced(physics)), (5, Discretisation::estimator(physics))] {
        for friction in FRICTIONS {
            all.push(forces_of::<Rubbing>(Model { name: RUBBING, samples, physics, friction }, &how)?);
        }
    }
    for (samples, how) in [(4, Discretisation::reduced(physics)), (5, Discretisation::estimator(physics))] {
        all.push(forces_of::<Remembering>(Model { name: REMEMBERING, samples, physics, friction: 0 }, &how)?);
    }
    Ok(all)
}

/// The follower of the sweep, with a coefficient of friction in hundredths, and the terms that its size has room for.
fn rubbing<T: Real, S: Size>(how: &Discretisation, friction: u32) -> Result<Box<Follower<T, S>>> {
    let mut follower = follower::<T, S>(how)?;
    follower.set_friction(f64::from(friction) * 0.01)?;
    follower.set_prony(TERMS.get(..S::TERMS).unwrap_or_default())?;
    Ok(follower)
}

fn forces_of<S: Size>(model: Model, how: &Discretisation) -> Result<Forces> {
    let mut exact = rubbing::<f64, S>(how, model.friction)?;
    let mut single = rubbing::<f32, S>(how, model.friction)?;
    exact.start(0.0);
    single.start(0.0);
    let mut ticks = Vec::new();
    for position in counts(LAST_COUNT) {
        let angle = f64::from(position) * COUNT;
        let target = Target { coordinate: angle, time_step_s: TICK_S };
        let outcome = exact.follow(target);
        if !outcome.status.is_trustworthy() {
            bail!("{}, {}: {} at count {position}", model.name, word(model.physics), outcome.status);
        }
        single.follow(target);
        let single = single.force_world().map(f32::to_bits);
        ticks.push(Force { position, double: exact.force_world(), single });
    }
    Ok(Forces { model, ticks })
}
