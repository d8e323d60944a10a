//! Measurements drawn from the model itself: to plan an experiment, and to check that a fit keeps what it states.

use model_core::discretise::DiscretiseError;
use model_core::object::ObjectDesign;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use super::{Model, Reading, Run, Trial};

/// Errors of drawn measurements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    /// Standard deviation of the force's, normal, N.
    pub force_n: f64,
    /// Half the width of the angle's, uniform, degrees: half a count of the servo.
    pub angle_deg: f64,
}

/// Draws runs: one per object, a reading at each angle (degrees), true values from `truth`. Readings without a trustworthy
/// solution are missing.
///
/// # Errors
/// If the true design is refused.
pub fn draw(
    model: &Model<'_>,
    truth: &Trial,
    objects: &[ObjectDesign],
    angles_deg: &[f64],
    errors: Errors,
    seed: u64,
) -> Result<Vec<Run>, DiscretiseError> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    // Uniform in 0 … 1, the ends left out.
    let mut uniform = || ((random.next_u64() >> 12) as f64 + 0.5) / (1_u64 << 52) as f64;
    let mut runs = Vec::new();
    for (index, &object) in objects.iter().enumerate() {
        let mut readings = Vec::new();
        let mut shifted = Vec::new();
        for (place, &angle_deg) in angles_deg.iter().enumerate() {
            readings.push(Reading { line: place + 2, angle_deg, force_n: None, front_mm: Vec::new() });
            shifted.push(angle_deg + errors.angle_deg * (2.0 * uniform() - 1.0));
        }
        // The finger closes on and on: it meets the true angles in their own order.
        let mut order: Vec<usize> = (0..shifted.len()).collect();
        order.sort_by(|&a, &b| shifted[a].total_cmp(&shifted[b]));
        let closing = order.iter().map(|&i| Reading { angle_deg: shifted[i], ..readings[i].clone() });
        let name = format!("run {}", index + 1);
        let run = Run { name: name.clone(), object, readings: closing.collect() };
        let predictions = model.predict(&run, truth, false)?;
        for (&i, prediction) in order.iter().zip(predictions) {
            // Box and Muller's normal numbers.
            let normal = (-2.0 * uniform().ln()).sqrt() * (std::f64::consts::TAU * uniform()).cos();
            if prediction.status.is_trustworthy() {
                readings[i].force_n = Some((prediction.force_n + errors.force_n * normal).max(0.0));
            }
        }
        readings.retain(|reading| reading.force_n.is_some());
        runs.push(Run { name, object, readings });
    }
    Ok(runs)
}
