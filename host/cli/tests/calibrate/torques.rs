//! Calibrations of motor torques, instead of forces and beside them.

use std::path::Path;
use std::process::Command;

use fre::fit::calibrate::synthetic::{Errors, Protocol, draw};
use fre::fit::calibrate::{Noise, Parameter, Plan, Predictor, Quantity, Trial, fit};
use model_core::drive::{Drive, Knots, Travel};
use model_core::object::ObjectDesign;
use model_core::sensitivity::DesignParameter;
use serde_json::Value;

use super::{Folder, USUAL, design, fre, model};

/// Motor torques do instead of forces: those of a closing and an opening give friction beside modulus and zero, within what is stated, and both
/// together give it more precisely than either.
#[test]
fn friction_comes_back_from_torques() {
    const ALL: [Parameter; 3] = [Parameter::YoungsModulus, Parameter::Zero, Parameter::Friction];
    let design = design();
    let truth = Trial { parameters: ALL.to_vec(), values: vec![46.0, 0.3, 0.4] };
    let both_ways = Protocol::cylinders(&[[45.0, 40.0]], 24).there_and_back();
    let errors = Errors { torque_nmm: Some(2.0), ..Errors::USUAL };
    let fitted = |seed, quantities: &[Quantity]| {
        let mut runs = draw(&model(&design), &truth, &both_ways, errors, seed).unwrap();
        for reading in runs.iter_mut().flat_map(|run| &mut run.readings) {
            reading.force_n = reading.force_n.filter(|_| quantities.contains(&Quantity::Force));
            reading.torque_nmm = reading.torque_nmm.filter(|_| quantities.contains(&Quantity::Torque));
        }
        fit(&model(&design), &runs, &ALL, &Noise::default()).unwrap()
    };
    for quantities in [&[Quantity::Force][..], &[Quantity::Torque], &Quantity::ALL] {
        let mut squares = 0.0;
        for seed in 0..10 {
            let found = fitted(seed, quantities);
            assert!(found.converged && found.undetermined.is_empty(), "{found:?}");
            assert!(Quantity::ALL.iter().all(|q| found.of(*q).next().is_some() == quantities.contains(q)));
            for (estimate, value) in found.estimates.iter().zip(&truth.values) {
                squares += ((estimate.value - value) / estimate.standard_deviation).powi(2) / 30.0;
            }
        }
        println!("{quantities:?}: mean square of errors over stated deviations {squares}");
        assert!((0.2..2.5).contains(&squares), "{quantities:?}: {squares}");
    }
    let [force, torque, both] = [&[Quantity::Force][..], &[Quantity::Torque], &Quantity::ALL].map(|quantities| {
        let found = fitted(1, quantities);
        println!("{quantities:?}: {:?} {:?}", found.estimates, found.correlation);
        found.estimates[2].standard_deviation
    });
    assert!(torque < 0.04 && both < force && both < torque, "{force} {torque} {both}");
}

/// A plan has torques where their deviation is given, and forces beside them where theirs is, too: what it states is what a fit to such readings
/// states.
#[test]
fn torques_are_planned_where_their_deviation_is_given() {
    let folder = Folder::new();
    let case = folder.file(
        "case.toml",
        "finger = \"preset:ladder-80\"\n[object]\nshape = \"circle\"\nradius_mm = 40\ncentre_mm = [41, 45]\n\
         [motion]\nmotor_angles_deg = [2, 8]\n",
    );
    let motion = folder.0.path().join("motion.csv");
    let words = [Path::new("--plan"), &motion, Path::new("--case"), &case];
    let planned = |more: &str| {
        let output = fre(&words, &format!("--elements reduced --fit youngs-modulus,zero --force --format json {more}"));
        let text = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
        let found: Value = serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {text}"));
        let count = |of: &str| found["residuals"].as_array().unwrap().iter().filter(|r| r[of].is_f64()).count();
        let deviation = found["parameters"][0]["standard_deviation"].as_f64().unwrap();
        ([count("measured_n"), count("measured_nmm")], deviation)
    };
    let (forces, by_forces) = planned("");
    let (torques, by_torques) = planned("--torque-sd-nmm 2");
    let (_, by_rough) = planned("--torque-sd-nmm 20");
    let (both, by_both) = planned("--torque-sd-nmm 2 --force-sd-n 0.02");
    assert_eq!([forces, torques, both], [[49, 0], [0, 49], [49, 49]]);
    assert_eq!(planned("--force-sd-n 0.02").1, by_forces);
    assert!(by_rough > 3.0 * by_torques && by_both < by_torques && by_both < by_forces, "{by_rough} {by_torques}");

    // The same readings, drawn without errors.
    let design = design();
    let plan = Plan::parse("motion.csv", &std::fs::read_to_string(&motion).unwrap(), 0.0..=8.0).unwrap();
    let protocol = Protocol::planned(&plan, ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 });
    let parameters = [Parameter::YoungsModulus, Parameter::Zero];
    let exact = Errors { force_n: 0.0, torque_nmm: Some(0.0), angle_deg: 0.0 };
    let mut runs = draw(&model(&design), &Trial::start(&parameters, &design, &[]), &protocol, exact, 0).unwrap();
    runs.iter_mut().flat_map(|run| &mut run.readings).for_each(|reading| reading.force_n = None);
    let found = fit(&model(&design), &runs, &parameters, &Noise::default()).unwrap();
    let ratio = by_torques / found.estimates[0].standard_deviation;
    assert!((ratio - 1.0).abs() < 1e-3, "{ratio}");
}

/// Derivatives of force and torque agree with differences, of a finger that turns and of one that a crank moves.
#[test]
fn derivatives_of_torques_agree_with_differences() {
    let design = design();
    let crank = [-30.0_f32, 0.0, 30.0, 60.0].map(|deg| [deg.to_radians(), 22.0 * deg.to_radians().sin()]);
    let table = Travel::Table(Knots::new(&crank).unwrap());
    for drive in [Drive::Rotating, Drive::Translating { direction: [1.0, 0.0], travel: table }] {
        let model = Predictor { drive, ..model(&design) };
        let mut parameters = USUAL.to_vec();
        parameters.extend([Parameter::Radius, Parameter::Design(DesignParameter::HingeThickness)]);
        if drive != Drive::Rotating {
            parameters.push(Parameter::Travel);
        }
        let trial = Trial::start(&parameters, &design, &[]);
        let mut protocol = Protocol::cylinders(&[[45.0, 40.0]], 6);
        protocol.angles_deg = if drive == Drive::Rotating { vec![4.0, 7.0] } else { vec![12.0, 20.0] };
        let exact = Errors { force_n: 0.0, torque_nmm: Some(0.0), angle_deg: 0.0 };
        let runs = draw(&model, &trial, &protocol, exact, 1).unwrap();
        let here = model.predict(&runs[0], &trial, true).unwrap();
        for (index, parameter) in parameters.iter().enumerate() {
            let step = 1e-4 * parameter.doubt(&design, &[]);
            let beside = [1.0, -1.0].map(|sign| {
                let mut other = trial.clone();
                other.values[index] += sign * step;
                model.predict(&runs[0], &other, false).unwrap()
            });
            for (reading, prediction) in here.iter().enumerate() {
                let [above, below] = beside.each_ref().map(|predictions| &predictions[reading]);
                for (name, derivative, difference) in [
                    ("force", prediction.force.gradient[index], above.force.value - below.force.value),
                    ("torque", prediction.torque.gradient[index], above.torque.value - below.torque.value),
                ] {
                    let difference = difference / (2.0 * step);
                    let off = (derivative - difference).abs();
                    assert!(
                        off < 2e-3 * difference.abs() + 1e-3,
                        "{drive:?} {parameter:?} {name} {reading}: {derivative} for {difference}"
                    );
                }
            }
        }
    }
}

/// The command reads torques where it is told how precise they are, and says so where it leaves them out. A file that has torques alone is
/// refused then; a comparison refuses it always.
#[test]
fn torques_are_read_where_their_deviation_is_given() {
    let folder = Folder::new();
    let run = |words: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fre"));
        command.current_dir(folder.0.path()).args(words.split_whitespace()).output().unwrap()
    };
    folder.file(
        "case.toml",
        "finger = \"preset:ladder-80\"\n[object]\nshape = \"circle\"\nradius_mm = 40\ncentre_mm = [41, 45]\n\
         [motion]\nmotor_angles_deg = [2, 3, 4, 5, 6, 7, 8]\n",
    );
    let csv = String::from_utf8(run("solve case.toml --format csv").stdout).unwrap();
    folder.file("both.csv", &csv);
    let mut lines = csv.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let head = lines.next().unwrap();
    let places =
        ["motor_angle_deg", "motor_torque_nmm"].map(|name| head.iter().position(|cell| *cell == name).unwrap());
    let row = |cells: &Vec<&str>| format!("{},{}\n", cells[places[0]], cells[places[1]]);
    folder.file("torques.csv", &(row(&head) + &lines.map(|cells| row(&cells)).collect::<String>()));
    let fitted = |file: &str, more: &str| -> Value {
        let out = run(&format!("calibrate {file} --case case.toml --fit youngs-modulus,zero --format json {more}"));
        serde_json::from_slice(&out.stdout).unwrap_or_else(|_| panic!("{}", String::from_utf8_lossy(&out.stderr)))
    };
    let count = |found: &Value| found["residuals"].as_array().unwrap().len();
    let forces = fitted("both.csv", "");
    assert!(forces["left_out"].to_string().contains("7 motor torques (--torque-sd-nmm uses them)"), "{forces}");
    assert!(forces["rms_nmm"].is_null() && count(&forces) == 7, "{forces}");
    let [both, torques] = ["both.csv", "torques.csv"].map(|file| fitted(file, "--torque-sd-nmm 1"));
    assert!(count(&both) == 14 && count(&torques) == 7, "{both} {torques}");
    assert!(torques["residuals"][3]["measured_nmm"].as_f64().unwrap() > 100.0, "{torques}");
    for found in [&both, &torques] {
        let modulus = found["parameters"][0]["value"].as_f64().unwrap();
        assert!((modulus - 49.5).abs() < 0.05, "{found}");
    }
    let alone = "torques.csv: has motor torques alone";
    for words in ["calibrate torques.csv --case case.toml", "compare case.toml --measured torques.csv"] {
        let out = run(words);
        let said = String::from_utf8(out.stderr).unwrap();
        assert!(out.status.code() == Some(1) && said.contains(alone), "{words}: {said}");
    }
    let out = run("calibrate both.csv --case case.toml --fit youngs-modulus,zero --torque-sd-nmm 1 --plot fit.svg");
    let said = String::from_utf8(out.stdout).unwrap();
    assert!(said.contains("7 forces and 7 torques of 1 run") && said.contains(" N·mm, "), "{said}");
    let picture = std::fs::read_to_string(folder.0.path().join("fit.svg")).unwrap();
    assert!(picture.contains("N·mm"), "no panel of torques");
}
