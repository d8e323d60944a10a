//! What the solver costs on this PC, and the forces that the target's are compared with.
//!
//! Warm: one count of the servo's sensor (360°/4096, or 0.05 mm of a jaw), the least of the repetitions of each tick in contact of closing
//! to 11° (10 mm) and opening again, median over the ticks. Cold: from no contact to the last place by continuation, the least of the
//! repetitions. Throughput: places solved per second by one core, 1° (0.5 mm) apart, each asked for by itself as a study asks.

use std::time::{Duration, Instant};

use anyhow::{Result, bail};
use model_core::discretise::{Discretisation, Physics, Sampling, Scheme};
use model_core::equilibrium::{Follower, Target};
use model_core::real::Real;
use model_core::size::{Paper, Reduced, Remembering, Ribs, Rubbing, Size};
use model_core::status::Status;
use reference_tests::closing::{Closing, LADDER, RIBS_7, UMI};
use reference_tests::{TERMS, TICK_S};

use crate::ladder::{PHYSICS, follower, follower_on, word};
use crate::peer;
use crate::spread::Spread;

/// The last angle of the peer's problem, degrees.
const LAST_DEG: f64 = 11.0;
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
/// The microcontroller's model of a finger whose ribs bend.
pub const RIBS: &str = "simpson-ribs";
/// The paper's.
pub const PAPER: &str = "paper-170-20";

/// Times of one model.
#[derive(Clone, Debug)]
pub struct Time {
    /// Finger and object.
    pub case: &'static str,
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
    /// From no contact to the last place, µs.
    pub cold_us: f64,
    /// Places per second and core, 1° or 0.5 mm apart.
    pub places_per_s: f64,
}

/// A discretisation: finger and object, model, samples per element, physics; and the coefficient of friction, in hundredths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Model {
    pub case: &'static str,
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
        times.extend(both::<Reduced>(&LADDER, REDUCED, &Discretisation::reduced(physics), 0)?);
        times.extend(both::<Paper>(&LADDER, "fine", &Discretisation::fine(physics), 0)?);
        times.extend(both::<Paper>(&LADDER, PAPER, &Discretisation::full(Scheme::Paper, physics), 0)?);
        times.extend(both::<Paper>(&LADDER, "trapezoid-170-20", &Discretisation::full(Scheme::Trapezoid, physics), 0)?);
    }
    for friction in FRICTIONS {
        times.extend(both::<Rubbing>(&LADDER, RUBBING, &Discretisation::reduced(Physics::Extended), friction)?);
    }
    for closing in [RIBS_7, UMI] {
        times.extend(both::<Ribs>(&closing, RIBS, &Discretisation::reduced(Physics::Extended), 0)?);
    }
    Ok(times)
}

fn both<S: Size>(closing: &Closing, model: &'static str, how: &Discretisation, friction: u32) -> Result<[Time; 2]> {
    Ok([time::<f64, S>(closing, model, how, "f64", friction)?, time::<f32, S>(closing, model, how, "f32", friction)?])
}

fn time<T: Real, S: Size>(
    closing: &Closing,
    model: &'static str,
    how: &Discretisation,
    precision: &'static str,
    friction: u32,
) -> Result<Time> {
    let (count, (step, places)) = (closing.count, closing.step);
    let mut follower = rubbing::<T, S>(closing, how, friction)?;
    // What a tick takes is the least of its repetitions: whatever else the PC does only adds to it.
    let mut warm = vec![Duration::MAX; Closing::ticks(count).count()];
    for _ in 0..SWEEPS {
        follower.start(0.0);
        for (position, least) in Closing::ticks(count).zip(&mut warm) {
            let clock = Instant::now();
            let outcome = follower.follow(f64::from(position) * count.0);
            let spent = clock.elapsed();
            if !outcome.status.is_trustworthy() {
                bail!(
                    "{}, {model}, {}, {precision}: {} at count {position}",
                    closing.case,
                    word(how.physics),
                    outcome.status
                );
            }
            if follower.solution().touching() > 0 {
                *least = spent.min(*least);
            }
        }
    }
    warm.retain(|least| *least < Duration::MAX);
    let mut cold = Duration::MAX;
    for _ in 0..COLD_SOLVES {
        let clock = Instant::now();
        follower.start(0.0);
        let outcome = follower.follow(f64::from(places) * step);
        cold = clock.elapsed().min(cold);
        if !outcome.status.is_trustworthy() {
            bail!(
                "{}, {model}, {}, {precision}: {} at the last place",
                closing.case,
                word(how.physics),
                outcome.status
            );
        }
    }
    let mut study = Duration::MAX;
    for _ in 0..COLD_SOLVES {
        let clock = Instant::now();
        follower.start(0.0);
        for place in 1..=places {
            let outcome = follower.follow(f64::from(place) * step);
            if !outcome.status.is_trustworthy() {
                bail!(
                    "{}, {model}, {}, {precision}: {} at place {place}",
                    closing.case,
                    word(how.physics),
                    outcome.status
                );
            }
        }
        study = clock.elapsed().min(study);
    }
    Ok(Time {
        case: closing.case,
        model,
        physics: how.physics,
        friction,
        precision,
        ticks_us: Spread::of(warm.iter().map(|time| time.as_secs_f64() * 1e6)),
        warm_us: median_us(&mut warm),
        cold_us: cold.as_secs_f64() * 1e6,
        places_per_s: f64::from(places) / study.as_secs_f64(),
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
        Ok((spent_us, follower.solution().force_finger()))
    };
    for repetition in 0..COLD_SOLVES {
        let (spent_us, force) = go(Some(0.0), LAST_DEG.to_radians())?;
        run.cold_us.push(spent_us);
        if repetition == 0 {
            run.forces.push(("cold".to_owned(), force));
        }
    }
    for sweep in 0..SWEEPS {
        go(Some(0.0), f64::from(*PEER_COUNTS.start()) * reference_tests::COUNT)?;
        for count in PEER_COUNTS.skip(1) {
            let (spent_us, force) = go(None, f64::from(count) * reference_tests::COUNT)?;
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
            all.push(forces_of::<Reduced>(&LADDER, (REDUCED, samples, physics, 0), &how)?);
        }
        let how = Discretisation::full(Scheme::Paper, physics);
        all.push(forces_of::<Paper>(&LADDER, (PAPER, 1, physics, 0), &how)?);
    }
    let physics = Physics::Extended;
    for (samples, how) in [(4, Discretisation::reduced(physics)), (5, Discretisation::estimator(physics))] {
        for friction in FRICTIONS {
            all.push(forces_of::<Rubbing>(&LADDER, (RUBBING, samples, physics, friction), &how)?);
        }
    }
    for (samples, how) in [(4, Discretisation::reduced(physics)), (5, Discretisation::estimator(physics))] {
        all.push(forces_of::<Remembering>(&LADDER, (REMEMBERING, samples, physics, 0), &how)?);
    }
    for closing in [RIBS_7, UMI] {
        for samples in [2, 5] {
            let how = Discretisation { sampling: Sampling::PerElement(samples), ..Discretisation::reduced(physics) };
            all.push(forces_of::<Ribs>(&closing, (RIBS, samples, physics, 0), &how)?);
        }
    }
    Ok(all)
}

/// The follower of the sweep, with a coefficient of friction in hundredths, and the terms that its size has room for.
fn rubbing<T: Real, S: Size>(closing: &Closing, how: &Discretisation, friction: u32) -> Result<Box<Follower<T, S>>> {
    let mut follower = follower_on::<T, S>(closing, how)?;
    follower.set_friction(f64::from(friction) * 0.01)?;
    follower.set_prony(TERMS.get(..S::TERMS).unwrap_or_default())?;
    Ok(follower)
}

fn forces_of<S: Size>(
    closing: &Closing,
    (name, samples, physics, friction): (&'static str, u8, Physics, u32),
    how: &Discretisation,
) -> Result<Forces> {
    let model = Model { case: closing.case, name, samples, physics, friction };
    let mut exact = rubbing::<f64, S>(closing, how, friction)?;
    let mut single = rubbing::<f32, S>(closing, how, friction)?;
    exact.start(0.0);
    single.start(0.0);
    let mut ticks = Vec::new();
    for position in Closing::ticks(closing.count) {
        let target = Target { coordinate: f64::from(position) * closing.count.0, time_step_s: TICK_S };
        let outcome = exact.follow(target);
        if !outcome.status.is_trustworthy() {
            bail!("{}, {}, {}: {} at count {position}", model.case, model.name, word(model.physics), outcome.status);
        }
        single.follow(target);
        let single = single.solution().force_world().map(f32::to_bits);
        ticks.push(Force { position, double: exact.solution().force_world(), single });
    }
    Ok(Forces { model, ticks })
}
