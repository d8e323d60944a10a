//! What the solver costs on this PC, and the forces that the target's are compared with. `cargo xtask bench` reads its lines:
//!
//!     time MODEL PHYSICS PRECISION WARM_US COLD_US
//!     force MODEL SAMPLES PHYSICS COUNT FX_F64 FY_F64 FX_F32_BITS FY_F32_BITS      over the sweep, in its order
//!
//!     peer cold US | peer warm US | peer force cold|COUNT FX FY       what `peer.py` prints too: same problem, same steps
//!
//! Ladder-80, cylinder of 80 mm at Mid height. Warm: one count of the servo's sensor (360°/4096), the least of the repetitions of
//! each tick in contact of closing to 11° and opening again, median over the ticks. Cold: from no contact to 11° by continuation in
//! steps of 1°, the least of the repetitions.

use std::time::{Duration, Instant};

use model_core::discretise::{Discretisation, Physics, Sampling, Scheme};
use model_core::equilibrium::{Follower, Settings};
use model_core::object::Motion;
use model_core::real::Real;
use model_core::size::{Paper, Reduced, Size};
use model_core::status::Status;
use reference_tests::{COUNT, circle_80, ladder_80};

const HEIGHT: f64 = 45.0;
const LAST_DEG: f64 = 11.0;
const LAST_COUNT: i32 = LAST_DEG as i32 * 4096 / 360;
const SWEEPS: usize = 12;
const COLD_SOLVES: usize = 31;
/// The counts over which a peer is compared.
const PEER_COUNTS: std::ops::RangeInclusive<i32> = 80..=110;
const BOTH: [(Physics, &str); 2] = [(Physics::Paper, "paper"), (Physics::Extended, "extended")];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for (physics, word) in BOTH {
        times::<Reduced>("simpson-17-1", Discretisation::reduced(physics), word)?;
        times::<Paper>("fine", Discretisation::fine(physics), word)?;
        times::<Paper>("paper-170-20", Discretisation::full(Scheme::Paper, physics), word)?;
        times::<Paper>("trapezoid-170-20", Discretisation::full(Scheme::Trapezoid, physics), word)?;
    }
    peer()?;
    for (physics, word) in BOTH {
        for samples in [2, 4, 5] {
            let how = Discretisation { sampling: Sampling::PerElement(samples), ..Discretisation::reduced(physics) };
            forces::<Reduced>("simpson-17-1", samples, how, word)?;
        }
        forces::<Paper>("paper-170-20", 1, Discretisation::full(Scheme::Paper, physics), word)?;
    }
    Ok(())
}

/// A follower with the finger and the object, at rest.
fn ready<T: Real, S: Size>(how: &Discretisation) -> Result<Box<Follower<T, S>>, Box<dyn std::error::Error>> {
    let mut follower = Box::new(Follower::EMPTY);
    let design = ladder_80();
    follower.configure(&design, how)?;
    follower.set_settings(Settings::DEFAULT);
    follower.set_object(circle_80(HEIGHT), Motion::Rotating { axis: design.motor_axis });
    Ok(follower)
}

/// Counts of closing and opening.
fn counts() -> impl Iterator<Item = i32> {
    (0..=LAST_COUNT).chain((0..LAST_COUNT).rev())
}

fn times<S: Size>(model: &str, how: Discretisation, physics: &str) -> Result<(), Box<dyn std::error::Error>> {
    time::<f64, S>(model, &how, physics, "f64")?;
    time::<f32, S>(model, &how, physics, "f32")
}

fn time<T: Real, S: Size>(
    model: &str,
    how: &Discretisation,
    physics: &str,
    precision: &str,
) -> Result<(), Box<dyn std::error::Error>> {
    let mut follower = ready::<T, S>(how)?;
    // What a tick takes is the least of its repetitions: whatever else the PC does only adds to it.
    let mut warm = vec![Duration::MAX; counts().count()];
    for _ in 0..SWEEPS {
        follower.start(0.0);
        for (count, least) in counts().zip(&mut warm) {
            let clock = Instant::now();
            let outcome = follower.follow(f64::from(count) * COUNT);
            let spent = clock.elapsed();
            if !outcome.status.is_trustworthy() {
                return Err(format!("{model}, {physics}, {precision}: {} at count {count}", outcome.status).into());
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
            return Err(format!("{model}, {physics}, {precision}: {} at {LAST_DEG}°", outcome.status).into());
        }
    }
    println!("time {model} {physics} {precision} {:.3} {:.3}", median_us(&mut warm), cold.as_secs_f64() * 1e6);
    Ok(())
}

/// The paper's model as another program solves it too: 0 to 11° in steps of 1°, then a stretch of counts.
fn peer() -> Result<(), Box<dyn std::error::Error>> {
    let mut follower = ready::<f64, Paper>(&Discretisation::full(Scheme::Paper, Physics::Paper))?;
    let mut go = |name: &str, from: Option<f64>, to: f64| -> Result<(Duration, [f64; 2]), Box<dyn std::error::Error>> {
        let clock = Instant::now();
        if let Some(from) = from {
            follower.start(from);
        }
        let outcome = follower.follow(to);
        let spent = clock.elapsed();
        if outcome.status != Status::Converged {
            return Err(format!("peer, {name}: {} at {to} rad", outcome.status).into());
        }
        Ok((spent, follower.force_finger()))
    };
    for repetition in 0..COLD_SOLVES {
        let (spent, [x, y]) = go("cold", Some(0.0), LAST_DEG.to_radians())?;
        println!("peer cold {:.3}", spent.as_secs_f64() * 1e6);
        if repetition == 0 {
            println!("peer force cold {x:e} {y:e}");
        }
    }
    for sweep in 0..SWEEPS {
        go("warm", Some(0.0), f64::from(*PEER_COUNTS.start()) * COUNT)?;
        for count in PEER_COUNTS.skip(1) {
            let (spent, [x, y]) = go("warm", None, f64::from(count) * COUNT)?;
            println!("peer warm {:.3}", spent.as_secs_f64() * 1e6);
            if sweep == 0 {
                println!("peer force {count} {x:e} {y:e}");
            }
        }
    }
    Ok(())
}

fn median_us(times: &mut [Duration]) -> f64 {
    times.sort();
    times.get(times.len() / 2).map_or(f64::NAN, |time| time.as_secs_f64() * 1e6)
}

fn forces<S: Size>(
    model: &str,
    samples: u8,
    how: Discretisation,
    physics: &str,
) -> Result<(), Box<dyn std::error::Error>> {
    let mut exact = ready::<f64, S>(&how)?;
    let mut single = ready::<f32, S>(&how)?;
    exact.start(0.0);
    single.start(0.0);
    for count in counts() {
        let angle = f64::from(count) * COUNT;
        let outcome = exact.follow(angle);
        if !outcome.status.is_trustworthy() {
            return Err(format!("{model}, {physics}: {} at count {count}", outcome.status).into());
        }
        single.follow(angle);
        let [x, y] = exact.force_world();
        let [bits_x, bits_y] = single.force_world().map(f32::to_bits);
        println!("force {model} {samples} {physics} {count} {x:e} {y:e} {bits_x} {bits_y}");
    }
    Ok(())
}
