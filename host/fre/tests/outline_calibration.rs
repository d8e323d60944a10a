//! Calibration from outlines beside forces: each quantity's standard deviations rest on its own residuals.

use fre::case::preset;
use fre::fit::calibrate::synthetic::{Errors, Protocol, draw};
use fre::fit::calibrate::{Fit, Loss, Noise, Parameter, Predictor, Readings, Trial, fit};
use model_core::design::Design;
use model_core::discretise::{Discretisation, Physics};
use model_core::drive::Drive;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

const PARAMETERS: [Parameter; 2] = [Parameter::YoungsModulus, Parameter::Zero];
const TRUE: [f64; 2] = [46.0, 0.3];
/// What an outline counts as at most.
const INDEPENDENT: usize = 10;

fn design() -> Design {
    preset("ladder-80").unwrap().unwrap().design
}

fn model(design: &Design) -> Predictor<'_> {
    Predictor { design, discretisation: Discretisation::reduced(Physics::Extended), drive: Drive::Rotating, prony: &[] }
}

fn truth() -> Trial {
    Trial { parameters: PARAMETERS.to_vec(), values: TRUE.to_vec() }
}

/// Forces on a cylinder, so far off. All touch it: a force is never below 0, and one near 0 would not be as far off.
fn forces(design: &Design, count: u32, force_n: f64, seed: u64) -> Vec<Readings> {
    let errors = Errors { force_n, ..Errors::USUAL };
    let mut runs = draw(&model(design), &truth(), &Protocol::cylinders(&[[45.0, 40.0]], count), errors, seed).unwrap();
    runs.iter_mut().for_each(|run| run.readings.retain(|reading| reading.angle_deg > 4.0));
    runs
}

/// The same with an outline of so many points at every fourth reading, off by ten independent errors along it, mm.
fn with_outlines(design: &Design, runs: &[Readings], points: usize, off_mm: f64, seed: u64) -> Vec<Readings> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut runs = runs.to_vec();
    for run in &mut runs {
        let mut asked = run.clone();
        asked.readings.iter_mut().for_each(|reading| reading.front_mm = vec![[0.0, 0.0]]);
        let shapes = model(design).predict(&asked, &truth(), false).unwrap();
        for (reading, shape) in run.readings.iter_mut().zip(shapes).step_by(4) {
            let errors: Vec<f64> = (0..INDEPENDENT).map(|_| StandardNormal.sample(&mut random)).collect();
            let line = &shape.front_mm;
            let place = |point: usize| {
                let along = (point as f64 + 0.5) / points as f64 * (line.len() - 1) as f64;
                let [begin, end] = [line[along as usize], line[along as usize + 1]];
                let way = [end[0] - begin[0], end[1] - begin[1]];
                let off = off_mm * errors[point * INDEPENDENT / points] / way[0].hypot(way[1]);
                let share = along.fract();
                [begin[0] + share * way[0] + off * way[1], begin[1] + share * way[1] - off * way[0]]
            };
            reading.front_mm = (0..points).map(place).collect();
        }
    }
    runs
}

fn fitted(design: &Design, runs: &[Readings], parameters: &[Parameter], loss: Loss) -> Fit {
    let found = fit(&model(design), runs, parameters, &Noise { loss, ..Noise::default() }).unwrap();
    assert!(found.converged && found.undetermined.is_empty(), "{found:?}");
    found
}

/// Forces ten times as far off as stated, beside outlines that fit exactly. At a given angle a finger's shape does not depend on its modulus: the
/// modulus' standard deviation is that of the forces alone, however many points there are.
#[test]
fn outlines_do_not_hide_how_far_forces_are_off() {
    let design = design();
    let alone = forces(&design, 60, 0.2, 1);
    let modulus = [Parameter::YoungsModulus];
    for loss in [Loss::Square, Loss::Huber, Loss::Tukey] {
        let expected = fitted(&design, &alone, &modulus, loss);
        for points in [10, 200] {
            let beside = with_outlines(&design, &alone, points, 0.0, 1);
            let found = fitted(&design, &beside, &modulus, loss);
            let ratio = found.estimates[0].standard_deviation / expected.estimates[0].standard_deviation;
            println!("{loss:?}, {points} points: σ × {ratio:.4}, {:?}", found.inflation);
            assert!((0.99..1.01).contains(&ratio), "{loss:?}, {points} points: σ × {ratio}");
            assert!((found.inflation.force / expected.inflation.force - 1.0).abs() < 0.01, "{:?}", found.inflation);
            assert!(found.inflation.force > 4.0 && found.inflation.outline == 1.0, "{:?}", found.inflation);
        }
    }
}

/// As far off as stated, or one of them further: the stated deviations match the scatter, and each quantity has its own inflation.
#[test]
fn stated_deviations_match_the_scatter_whichever_is_off() {
    const SEEDS: u64 = 30;
    let design = design();
    for (force_n, off_mm, points) in [(0.02, 0.3, 10), (0.02, 0.3, 200), (0.1, 0.3, 200), (0.02, 1.2, 200)] {
        let (mut squares, mut inflations) = ([0.0; 2], [0.0; 2]);
        for seed in 0..SEEDS {
            let runs = with_outlines(&design, &forces(&design, 24, force_n, seed), points, off_mm, seed);
            let found = fitted(&design, &runs, &PARAMETERS, Loss::default());
            for ((sum, estimate), value) in squares.iter_mut().zip(&found.estimates).zip(TRUE) {
                *sum += ((estimate.value - value) / estimate.standard_deviation).powi(2) / SEEDS as f64;
            }
            for (sum, of) in inflations.iter_mut().zip([found.inflation.force, found.inflation.outline]) {
                *sum += of / SEEDS as f64;
            }
        }
        println!("{force_n} N, {off_mm} mm at {points} points: squares {squares:?}, inflations {inflations:?}");
        // Three deviations of the mean square of 30 are 0.77.
        assert!(squares.iter().all(|mean| (0.3..1.8).contains(mean)), "{force_n} N, {off_mm} mm: {squares:?}");
        for (inflation, is_off) in inflations.into_iter().zip([force_n > 0.05, off_mm > 1.0]) {
            let allowed = if is_off { 2.5..5.0 } else { 1.0..1.5 };
            assert!(allowed.contains(&inflation), "{force_n} N, {off_mm} mm: {inflations:?}");
        }
    }
}
