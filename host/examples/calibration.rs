//! Does a calibration keep what it states? `cargo run -p host --release --example calibration -- [RUNS]` (default 500).
//!
//! Draws measurements from the model with errors of ±0.02 N (normal) and ±0.044° (uniform: half a count), fits them, and counts
//! how often the truth lies within two stated standard deviations. Then the same with a truth of the `fine` resolution, fitted
//! with the `reduced` one: the bias that the coarser model brings, apart from the noise.

use std::time::Instant;

use host::calibrate::synthetic::{Errors, draw};
use host::calibrate::{Model, Noise, Parameter, Trial, fit};
use host::case::preset;
use model_core::discretise::{Discretisation, Physics};
use model_core::object::ObjectDesign;
use rayon::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let runs: u64 = std::env::args().nth(1).map_or(Ok(500), |word| word.parse())?;
    let design = preset("ladder-80").ok_or("the preset is gone")??.design;
    let parameters = [Parameter::YoungsModulus, Parameter::Zero, Parameter::ObjectX, Parameter::ObjectY];
    let truth = Trial { parameters: parameters.to_vec(), values: vec![46.0, 0.6, 0.8, -0.5] };
    let circle = |y, radius| ObjectDesign::Circle { centre: [1.0 + radius, y], radius };
    let objects = [circle(30.0, 40.0), circle(45.0, 40.0), circle(58.0, 40.0), circle(40.0, 20.0)];
    let count = 360.0 / 4096.0;
    let angles: Vec<f64> = (0..24).map(|i| count * (12.0 + 4.0 * f64::from(i)).round()).collect();
    let errors = Errors { force_n: 0.02, angle_deg: 0.5 * count };
    let reduced = Model { design: &design, discretisation: Discretisation::reduced(Physics::Extended) };
    let fine = Model { design: &design, discretisation: Discretisation::fine(Physics::Extended) };

    let begin = Instant::now();
    let fits: Vec<_> = (0..runs)
        .into_par_iter()
        .map(|seed| -> Result<_, String> {
            let drawn = draw(&reduced, &truth, &objects, &angles, errors, seed).map_err(|error| error.to_string())?;
            fit(&reduced, &drawn, &parameters, &Noise::default()).map_err(|error| error.to_string())
        })
        .collect::<Result<_, _>>()?;
    println!(
        "{runs} calibrations, {} readings each, {:.1} s; errors ±{} N, ±{:.3}°",
        objects.len() * angles.len(),
        begin.elapsed().as_secs_f64(),
        errors.force_n,
        errors.angle_deg
    );
    println!("{} did not converge", fits.iter().filter(|fit| !fit.converged).count());
    println!(
        "{:<16} {:>9} {:>9} {:>9} {:>9} {:>9}  within 2σ",
        "parameter", "truth", "mean", "stated σ", "rms error", "largest"
    );
    let mut all = 0;
    for (i, parameter) in parameters.iter().enumerate() {
        let value = truth.values[i];
        let errors: Vec<f64> = fits.iter().map(|fit| fit.estimates[i].value - value).collect();
        let stated: Vec<f64> = fits.iter().map(|fit| fit.estimates[i].standard_deviation).collect();
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
        let rms = mean(&errors.iter().map(|e| e * e).collect::<Vec<_>>()).sqrt();
        let within = errors.iter().zip(&stated).filter(|(error, sigma)| error.abs() <= 2.0 * **sigma).count();
        all += within;
        println!(
            "{:<16} {value:>9.3} {:>9.3} {:>9.4} {rms:>9.4} {:>9.4}  {:.1} %",
            parameter.word(),
            value + mean(&errors),
            mean(&stated),
            errors.iter().fold(0.0_f64, |most, e| most.max(e.abs())),
            100.0 * within as f64 / runs as f64
        );
    }
    println!("all: {:.1} %", 100.0 * all as f64 / (runs as f64 * parameters.len() as f64));

    let exact = Errors { force_n: 0.0, angle_deg: 0.0 };
    let drawn = draw(&fine, &truth, &objects, &angles, exact, 0)?;
    let found = fit(&reduced, &drawn, &parameters, &Noise::default())?;
    println!("\nbias of a truth at `fine` fitted with `reduced`, no noise:");
    for (estimate, value) in found.estimates.iter().zip(&truth.values) {
        println!("{:<16} {:+.4} {}", estimate.parameter.word(), estimate.value - value, estimate.parameter.unit());
    }
    println!("residuals: rms {:.4} N", found.rms_n());
    Ok(())
}
