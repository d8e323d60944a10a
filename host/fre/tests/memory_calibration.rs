//! Calibration of a material with memory: from force over time, its terms and its modulus come back.

use fre::case::{Document, preset};
use fre::fit::calibrate::synthetic::{Errors, Protocol, draw};
use fre::fit::calibrate::{
    Fit, FitError, Input, Noise, Parameter, Plan, Predictor, Reading, Readings, Trial, fit, fitted_finger,
};
use fre::fit::measured::Measured;
use model_core::design::Design;
use model_core::discretise::{Discretisation, Physics};
use model_core::drive::Drive;
use model_core::object::ObjectDesign;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// Where a fit begins, and the truth.
const OWN: [[f64; 2]; 2] = [[0.15, 1.0], [0.15, 30.0]];
const TRUE: [f64; 5] = [44.0, 0.2, 0.7, 0.12, 45.0];
const PARAMETERS: [Parameter; 5] =
    [Parameter::YoungsModulus, Parameter::Share(0), Parameter::Fading(0), Parameter::Share(1), Parameter::Fading(1)];

fn model(design: &Design) -> Predictor<'_> {
    let discretisation = Discretisation::reduced(Physics::Extended);
    Predictor { design, discretisation, drive: Drive::Rotating, prony: &OWN }
}

/// Closing at 10 °/s to 8°, a hold of five minutes, opening, and closing slowly once more.
fn motion() -> Vec<[f64; 2]> {
    let fast = (0..=8).map(|step| [0.1 * f64::from(step), f64::from(step)]);
    let held = (0..20).map(|step| [0.8 + 0.1 * 1.5_f64.powi(step), 8.0]);
    let opening = (1..=4).map(|step| [300.0 + 0.2 * f64::from(step), 8.0 - 2.0 * f64::from(step)]);
    let slow = (1..=8).map(|step| [301.0 + 2.0 * f64::from(step), f64::from(step)]);
    fast.chain(held).chain(opening).chain(slow).collect()
}

/// Readings of that motion, with a force sensor's noise.
fn drawn(design: &Design, seed: u64) -> Readings {
    let object = ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 };
    let reading = |(index, [time, angle_deg]): (usize, [f64; 2])| Reading {
        line: index + 2,
        angle_deg,
        time_s: Some(time),
        force_n: None,
        torque_nmm: None,
        front_mm: Vec::new(),
    };
    let readings = motion().into_iter().enumerate().map(reading).collect();
    let mut run = Readings { name: "drawn".to_owned(), object, friction: 0.0, readings };
    let truth = Trial { parameters: PARAMETERS.to_vec(), values: TRUE.to_vec() };
    let predicted = model(design).predict(&run, &truth, false).unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    for (reading, prediction) in run.readings.iter_mut().zip(predicted) {
        let normal: f64 = StandardNormal.sample(&mut random);
        assert!(prediction.status.is_trustworthy(), "{prediction:?}");
        reading.force_n = Some((prediction.force.value + 0.02 * normal).max(0.0));
    }
    run
}

fn fitted(design: &Design, run: Readings) -> Fit {
    let noise = Noise { angle_deg: 1e-3, ..Noise::default() };
    fit(&model(design), &[run], &PARAMETERS, &noise).unwrap()
}

#[test]
fn without_anything_to_fit_there_is_no_fit() {
    let design = preset("ladder-80").unwrap().unwrap().design;
    let none = fit(&model(&design), &[drawn(&design, 0)], &[], &Noise::default()).unwrap_err();
    assert_eq!(none, FitError::NoParameters);
    let words = none.to_string();
    assert!(words.starts_with("at least one parameter to fit is needed; allowed is youngs-modulus, "), "{words}");
    let case = "finger = \"preset:ladder-80\"\n[object]\nshape = \"circle\"\nradius_mm = 40\ncentre_mm = [41, 45]\n[motion]\nmotor_angles_deg = [2]\n";
    let document = Document::resolve("case.toml", case, std::path::Path::new("")).unwrap();
    let none = Input::of(&[], vec![("case.toml".to_owned(), document)], false, Drive::Rotating).unwrap_err();
    assert_eq!(none.to_string(), "at least one file of measurements is needed");
}

#[test]
fn terms_and_modulus_come_back_within_what_is_stated() {
    let design = preset("ladder-80").unwrap().unwrap().design;
    let (mut within, mut all) = (0, 0);
    for seed in 0..3 {
        let found = fitted(&design, drawn(&design, seed));
        assert!(found.converged && found.undetermined.is_empty(), "{found:?}");
        for (estimate, truth) in found.estimates.iter().zip(TRUE) {
            let off = (estimate.value - truth).abs() / estimate.standard_deviation;
            println!("{}: {} ± {} of {truth}", estimate.parameter.word(), estimate.value, estimate.standard_deviation);
            assert!(off < 4.0 && estimate.determined, "{estimate:?}, truth {truth}");
            within += usize::from(off <= 2.0);
            all += 1;
        }
        assert!(found.inflation.force < 1.3, "{:?}", found.inflation);
        // A larger modulus with a larger share gives nearly the same forces.
        assert!(found.correlation[0][1] > 0.3, "{:?}", found.correlation);
    }
    assert!(within * 100 >= all * 75, "{within} of {all} within two deviations");
}

/// What a plan states before anything is measured is what fits along it state, and their errors keep to it: the angle of a hold, too, is off
/// by one error and not by one per reading. (`cargo xtask bench calibration` does it with 500.)
#[test]
fn a_plan_states_how_well_its_readings_determine() {
    let design = preset("ladder-80").unwrap().unwrap().design;
    let object = ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 };
    let protocol = Protocol::planned(&Plan::new(0.0, 8.0, 10.0, &OWN, false), object);
    let truth = Trial { parameters: PARAMETERS.to_vec(), values: TRUE.to_vec() };
    let exact = Errors { force_n: 0.0, torque_nmm: None, angle_deg: 0.0 };
    let expected = fit(
        &model(&design),
        &draw(&model(&design), &truth, &protocol, exact, 0).unwrap(),
        &PARAMETERS,
        &Noise::default(),
    );
    let expected = expected.unwrap();
    let (mut within, mut all) = (0, 0);
    for seed in 0..6 {
        let runs = draw(&model(&design), &truth, &protocol, Errors::USUAL, seed).unwrap();
        let found = fit(&model(&design), &runs, &PARAMETERS, &Noise::default()).unwrap();
        assert!(found.converged && found.undetermined.is_empty(), "{found:?}");
        for (estimate, truth) in found.estimates.iter().zip(TRUE) {
            within += usize::from((estimate.value - truth).abs() <= 2.0 * estimate.standard_deviation);
            all += 1;
        }
        // Of the noise that is stated; a fit's own residuals may add to it.
        for (estimate, expected) in found.estimates.iter().zip(&expected.estimates) {
            let ratio = estimate.standard_deviation / expected.standard_deviation / found.inflation.force;
            assert!((0.6..1.7).contains(&ratio), "seed {seed}, {}: {ratio}", estimate.parameter.word());
        }
    }
    // 95.4 % of 30 of which five go together: three deviations of some 15 independent ones are 16 %.
    assert!(within * 100 >= all * 79, "{within} of {all} within two deviations");
}

/// With friction as well: what is drawn without noise comes back, the coefficient from where a fit begins at 0.
#[test]
fn friction_comes_back_beside_the_modulus() {
    let design = preset("ladder-80").unwrap().unwrap().design;
    let truth = Trial { parameters: vec![Parameter::YoungsModulus, Parameter::Friction], values: vec![44.0, 0.4] };
    let mut run = drawn(&design, 0);
    let predicted = model(&design).predict(&run, &truth, false).unwrap();
    for (reading, prediction) in run.readings.iter_mut().zip(predicted) {
        assert!(prediction.status.is_trustworthy(), "{prediction:?}");
        reading.force_n = Some(prediction.force.value);
    }
    let found = fit(&model(&design), &[run], &truth.parameters, &Noise::default()).unwrap();
    assert!(found.converged && found.undetermined.is_empty(), "{found:?}");
    for (estimate, truth) in found.estimates.iter().zip(&truth.values) {
        println!("{}: {} ± {}", estimate.parameter.word(), estimate.value, estimate.standard_deviation);
        assert!((estimate.value / truth - 1.0).abs() < 0.01, "{estimate:?}, truth {truth}");
    }
}

/// What files say: rows in time are read, the fitted finger has its terms, and what has no time is refused with its line.
#[test]
fn a_file_of_times_is_fitted_and_one_without_is_refused() {
    let finger = include_str!("../src/case/presets/ladder-80.toml").replace("\n[", "\n[finger.");
    let finger = finger.replacen("poissons_ratio", "prony = [[0.15, 1], [0.15, 30]]\npoissons_ratio", 1);
    let case = format!(
        "[finger]\n{finger}\n[object]\nshape = \"circle\"\nradius_mm = 40\ncentre_mm = [41, 45]\n[motion]\nmotor_angles_deg = [8]\n"
    );
    let document = || Document::resolve("case.toml", &case, std::path::Path::new("")).unwrap();
    let design = preset("ladder-80").unwrap().unwrap().design;
    let run = drawn(&design, 5);
    let line =
        |reading: &Reading| format!("{},{},{}\n", reading.time_s.unwrap(), reading.angle_deg, reading.force_n.unwrap());
    let rows: String = run.readings.iter().map(line).collect();
    let input = |head: &str, rows: &str| {
        let measured = Measured::parse("force.csv", &format!("{head}\n{rows}")).unwrap();
        Input::of_measured(
            vec![("force.csv".to_owned(), measured)],
            vec![("case.toml".to_owned(), document())],
            false,
            Drive::Rotating,
        )
    };
    let read = input("time_s,motor_angle_deg,force_n", &rows).unwrap();
    assert_eq!(read.runs[0].readings, run.readings);
    let found = fitted(&design, read.runs[0].clone());
    let text = fitted_finger(&read, &found);
    assert!(text.contains("prony-tau2 = ") && text.contains("prony = [[0."), "{text}");
    for (head, rows, line) in [
        ("time,motor_angle_deg,force_n", rows.as_str(), 2),
        ("time_s,motor_angle_deg,force_n", "0,0,0\n1,2,1\n1,3,2\n", 4),
        ("time_s,motor_angle_deg,force_n", "0,0,0\n,2,1\n", 3),
    ] {
        let error = input(head, rows).unwrap_err().to_string();
        assert!(error.starts_with(&format!("force.csv:{line}: needed is time_s")), "{error}");
    }
    let obstacle = Parameter::Share(2).obstacle(&design, &OWN, &[], &Drive::Rotating);
    snapbox::assert_data_eq!(
        obstacle.unwrap(),
        snapbox::str!["finger.material.prony of the case has no such term to begin with"]
    );
}
