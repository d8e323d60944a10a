//! Calibrations: of measurements drawn from the model, the truth comes back, and the stated deviations cover it.

mod said;
#[path = "calibrate/torques.rs"]
mod torques;
mod transcript;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use fre::case::{preset, read_finger};
use fre::fit::calibrate::synthetic::{Errors, Protocol, draw};
use fre::fit::calibrate::{Loss, Noise, Parameter, Plan, Predictor, Quantity, Readings, Trial, fit};
use model_core::design::Design;
use model_core::discretise::{Discretisation, Physics};
use model_core::drive::{Drive, Knots, Travel};
use model_core::object::ObjectDesign;
use model_core::sensitivity::DesignParameter;
use model_core::uncertainty::Uncertainty;
use serde_json::Value;
use tempfile::TempDir;
use transcript::Transcript;

const USUAL: [Parameter; 4] = [Parameter::YoungsModulus, Parameter::Zero, Parameter::ObjectX, Parameter::ObjectY];

fn design() -> Design {
    preset("ladder-80").unwrap().unwrap().design
}

fn model(design: &Design) -> Predictor<'_> {
    Predictor { design, discretisation: Discretisation::reduced(Physics::Extended), drive: Drive::Rotating, prony: &[] }
}

fn truth() -> Trial {
    Trial { parameters: USUAL.to_vec(), values: vec![46.0, 0.6, 0.8, -0.5] }
}

fn drawn(protocol: &Protocol, seed: u64) -> (Design, Vec<Readings>) {
    let design = design();
    let drawn = draw(&model(&design), &truth(), protocol, Errors::USUAL, seed).unwrap();
    (design, drawn)
}

fn readings(seed: u64, count: u32) -> (Design, Vec<Readings>) {
    drawn(&Protocol::cylinders(&[[30.0, 40.0], [45.0, 40.0], [58.0, 40.0], [40.0, 20.0]], count), seed)
}

#[test]
fn stated_deviations_cover_the_truth() {
    let (mut within, mut all, mut squares) = (0, 0, 0.0);
    for seed in 0..30 {
        let (design, runs) = readings(1000 + seed, 12);
        let found = fit(&model(&design), &runs, &USUAL, &Noise::default()).unwrap();
        assert!(found.converged && found.undetermined.is_empty(), "{found:?}");
        for (estimate, value) in found.estimates.iter().zip(&truth().values) {
            let off = (estimate.value - value) / estimate.standard_deviation;
            within += usize::from(off.abs() <= 2.0);
            all += 1;
            squares += off * off;
        }
    }
    // 95.4 % of 120 that go together in fours: about as sharp as 60 independent ones, three deviations of which are 8 %.
    assert!(within * 100 >= all * 87, "{within} of {all} within two deviations");
    let mean = squares / f64::from(all as u32);
    assert!((0.5..1.6).contains(&mean), "mean square of errors over stated deviations {mean}");
}

/// Every one of them: within 1 % of the modulus, 0.05° and 0.2 mm. (`cargo xtask bench calibration` does it with 500.)
#[test]
fn what_is_recommended_finds_the_truth_every_time() {
    let (mut within, mut all) = (0, 0);
    for seed in 0..10 {
        let (design, runs) = drawn(&Protocol::recommended(), seed);
        let found = fit(&model(&design), &runs, &USUAL, &Noise::default()).unwrap();
        assert!(found.converged && found.undetermined.is_empty(), "{found:?}");
        for ((estimate, value), bound) in found.estimates.iter().zip(&truth().values).zip([0.46, 0.05, 0.2, 0.2]) {
            let off = (estimate.value - value).abs();
            assert!(off < bound, "seed {seed}: {estimate:?}");
            within += usize::from(off <= 2.0 * estimate.standard_deviation);
            all += 1;
        }
        assert!(found.inflation.force < 1.2, "{:?}", found.inflation);
    }
    // As above; three deviations of 20 independent ones are 14 %.
    assert!(within * 100 >= all * 80, "{within} of {all} within two deviations");
}

#[test]
fn outliers_are_named_and_hardly_count() {
    let (design, mut runs) = readings(8, 24);
    let spoilt = [(0, 5), (2, 11), (3, 2)];
    for (run, reading) in spoilt {
        let force = runs[run].readings[reading].force_n.as_mut().unwrap();
        *force += 1.5;
    }
    for loss in [Loss::Huber, Loss::Tukey] {
        let found = fit(&model(&design), &runs, &USUAL, &Noise { loss, ..Noise::default() }).unwrap();
        for (run, reading) in spoilt {
            let line = runs[run].readings[reading].line;
            assert!(found.residuals.iter().any(|r| r.run == run && r.line == line && r.is_outlier()), "{loss:?}");
        }
        for (estimate, value) in found.estimates.iter().zip(&truth().values) {
            let off = (estimate.value - value).abs() / estimate.standard_deviation;
            assert!(off < 4.0, "{loss:?}: {estimate:?}");
        }
        let without = found.of(Quantity::Force).filter(|residual| residual.is_outlier()).count();
        assert!(found.outliers(Quantity::Force) == without && without >= spoilt.len());
        let [kept, all] = [found.rms(Quantity::Force), found.rms_of_all(Quantity::Force)];
        assert!(kept < 0.05 && all > 0.2, "{kept} N without outliers, {all} N with them");
    }
}

/// By the stated noise of 0.02 N these forces would determine the modulus; their own scatter of 20 N does not.
#[test]
fn what_scatter_leaves_open_is_not_determined() {
    let (design, mut runs) = readings(8, 6);
    for (index, reading) in runs.iter_mut().flat_map(|run| &mut run.readings).enumerate() {
        reading.force_n = Some(if index.is_multiple_of(2) { 0.0 } else { 20.0 });
    }
    let noise = Noise { loss: Loss::Square, ..Noise::default() };
    let found = fit(&model(&design), &runs, &[Parameter::YoungsModulus], &noise).unwrap();
    let [modulus] = &found.estimates[..] else { panic!("one parameter") };
    assert!(modulus.standard_deviation > modulus.parameter.doubt(&design, &[]), "{modulus:?}");
    assert!(!modulus.determined, "{modulus:?}");
    assert_eq!(found.undetermined.len(), 1, "{:?}", found.undetermined);
}

#[test]
fn what_the_data_do_not_tell_is_named() {
    let design = design();
    let mut few = Protocol::cylinders(&[[45.0, 40.0]], 4);
    few.angles_deg.truncate(3);
    // Low forces at one place: the modulus, the angle and the place all make them greater or less.
    let drawn = draw(&model(&design), &truth(), &few, Errors::USUAL, 1).unwrap();
    let mut parameters = USUAL.to_vec();
    parameters.push(Parameter::Radius);
    let found = fit(&model(&design), &drawn, &parameters, &Noise::default()).unwrap();
    assert!(!found.undetermined.is_empty());
    let named: Vec<Parameter> = found.undetermined.iter().flat_map(|c| c.terms.iter().map(|(p, _)| *p)).collect();
    assert!(named.contains(&Parameter::Zero) || named.contains(&Parameter::ObjectX), "{named:?}");
    assert!(found.estimates.iter().any(|estimate| !estimate.determined));
    // A direction that nothing tells keeps the doubt it had.
    let doubts: f64 =
        found.estimates.iter().map(|e| e.standard_deviation / e.parameter.doubt(&design, &[])).fold(0.0, f64::max);
    assert!(doubts > 0.3 && doubts < 1.5, "{doubts}");
}

#[test]
fn a_hinge_thickness_and_outlines_are_fitted_too() {
    let design = design();
    let parameters = [Parameter::Design(DesignParameter::HingeThickness), Parameter::Zero];
    let truth = Trial { parameters: parameters.to_vec(), values: vec![0.85, -0.4] };
    let protocol = Protocol::cylinders(&[[45.0, 40.0], [58.0, 40.0]], 10);
    let mut runs = draw(&model(&design), &truth, &protocol, Errors::USUAL, 3).unwrap();
    for run in &mut runs {
        let shapes = model(&design).predict(&with_fronts(run), &truth, false).unwrap();
        for (reading, shape) in run.readings.iter_mut().zip(shapes) {
            reading.front_mm = shape.front_mm.iter().step_by(2).copied().collect();
        }
    }
    let found = fit(&model(&design), &runs, &parameters, &Noise::default()).unwrap();
    assert!((found.estimates[0].value - 0.85).abs() < 4.0 * found.estimates[0].standard_deviation, "{found:?}");
    assert!(found.estimates[0].standard_deviation < 0.02 && found.estimates[1].standard_deviation < 0.1);
    let (points, rms) = found.outline.unwrap();
    assert!(points > 100 && rms < 0.05, "{points} {rms}");
}

/// The run with a point at every reading, so that shapes are computed.
fn with_fronts(run: &Readings) -> Readings {
    let mut run = run.clone();
    for reading in &mut run.readings {
        reading.front_mm = vec![[0.0, 0.0]];
    }
    run
}

/// Jaws on a rack and on a crank: zero and travel come back with the rest, and what goes to the gripper has the fitted travel.
#[test]
fn a_translating_fingers_travel_is_fitted() {
    let design = design();
    let crank = [-30.0_f32, 0.0, 30.0, 60.0].map(|deg| [deg.to_radians(), 22.0 * deg.to_radians().sin()]);
    let table = Travel::Table(Knots::new(&crank).unwrap());
    for drive in [Drive::linear([1.0, 0.0], 20.0), Drive::Translating { direction: [1.0, 0.0], travel: table }] {
        let model = Predictor { drive, ..model(&design) };
        let parameters = [Parameter::YoungsModulus, Parameter::Zero, Parameter::Travel, Parameter::ObjectY];
        let truth = Trial { parameters: parameters.to_vec(), values: vec![46.0, 0.8, 1.03, -0.5] };
        // A thin and a thick cylinder, low and high, each 2 mm and 7 mm away: one distance leaves zero and travel together.
        let mut protocol = Protocol::recommended();
        let far = |object: &ObjectDesign| match *object {
            ObjectDesign::Circle { centre: [x, y], radius } => ObjectDesign::Circle { centre: [x + 5.0, y], radius },
            ref other => *other,
        };
        let further: Vec<ObjectDesign> = protocol.objects.iter().map(far).collect();
        protocol.objects.extend(further);
        protocol.angles_deg = (0..40).map(|i| (8.0 * f64::from(i)).round() * 360.0 / 4096.0).collect();
        let runs = draw(&model, &truth, &protocol, Errors::USUAL, 11).unwrap();
        let found = fit(&model, &runs, &parameters, &Noise::default()).unwrap();
        assert!(found.converged && found.undetermined.is_empty(), "{found:?}");
        for ((estimate, value), bound) in found.estimates.iter().zip(&truth.values).zip([0.46, 0.1, 0.005, 0.2]) {
            let off = (estimate.value - value).abs();
            assert!(off < bound && off < 4.0 * estimate.standard_deviation, "{drive:?}: {estimate:?}");
        }
        let sent = found.trial.drive(&drive, &design);
        let [there, _] = sent.coordinate(0.5).unwrap();
        let [before, _] = drive.coordinate(0.5).unwrap();
        assert!((there / before - 1.03).abs() < 0.005, "{sent:?}");
        // Beyond a table's end nothing is known.
        if let Some(run) = runs.first() {
            let mut beyond = run.clone();
            beyond.readings.truncate(1);
            beyond.readings[0].angle_deg = 200.0;
            let status = model.predict(&beyond, &truth, true).unwrap()[0].status;
            assert!(
                matches!(drive, Drive::Translating { travel: Travel::Linear { .. }, .. }) || !status.is_trustworthy()
            );
        }
    }
    assert!(Parameter::Travel.obstacle(&design, &[], &[], &Drive::Rotating).is_some());
}

/// A folder of its own for each test, removed when dropped.
struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn file(&self, name: &str, text: &str) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    }
}

fn fre(words: &[&Path], options: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fre"));
    command.arg("calibrate").args(words).args(options.split_whitespace()).output().unwrap()
}

fn files(folder: &Folder) -> (Vec<PathBuf>, Vec<PathBuf>) {
    let (_, runs) = readings(5, 16);
    let (mut tables, mut cases) = (Vec::new(), Vec::new());
    for (index, run) in runs.iter().enumerate() {
        // A gauge's reading of its own is nothing to the fit.
        let [head, gauge] = if index == 0 { [",gauge_mv", ",1.5"] } else { [""; 2] };
        let mut table = format!("motor_angle_deg,force_n{head}\n");
        for reading in &run.readings {
            table += &format!("{},{}{gauge}\n", reading.angle_deg, reading.force_n.unwrap());
        }
        // On the way back, with the play of the gears between.
        let back = run.readings.last().unwrap();
        table += &format!("{},{}{gauge}\n", back.angle_deg - 2.0, 0.1);
        tables.push(folder.file(&format!("{index}.csv"), &table));
        let ObjectDesign::Circle { centre: [x, y], radius } = run.object else { panic!("a circle") };
        cases.push(folder.file(
            &format!("{index}.toml"),
            &format!(
                "finger = \"preset:ladder-80\"\nobject = {{ shape = \"circle\", radius_mm = {radius:?}, centre_mm = [{x:?}, {y:?}] }}\n\
                 motion = {{ motor_angles_deg = [5] }}\n"
            ),
        ));
    }
    (tables, cases)
}

#[test]
fn the_command_fits_writes_and_draws() {
    let folder = Folder::new();
    let (tables, cases) = files(&folder);
    let mut words: Vec<&Path> = tables.iter().map(PathBuf::as_path).collect();
    for case in &cases {
        words.extend([Path::new("--case"), case.as_path()]);
    }
    let (finger, plot) = (folder.0.path().join("finger.toml"), folder.0.path().join("plot.svg"));
    let options = format!("--elements reduced --format json --write {} --plot {}", finger.display(), plot.display());
    let output = fre(&words, &options);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let value: Value = serde_json::from_slice(&output.stdout).unwrap();
    let modulus = value["parameters"][0]["value"].as_f64().unwrap();
    assert!((modulus - 46.0).abs() < 1.0, "{value}");
    assert_eq!(value["left_out"].as_array().unwrap().len(), 5, "a column, the opening rows: {}", value["left_out"]);
    let zero = value["gripper"]["zero_counts"].as_f64().unwrap();
    assert!((zero + 0.6 * 4096.0 / 360.0).abs() < 4.0, "{zero}");
    assert!(value["gripper"]["uncertainty"]["youngs_modulus"].as_f64().unwrap() > 0.0);
    let written = read_finger(&finger).unwrap();
    assert!((written.design.material.youngs_modulus - modulus).abs() < 1e-9);
    // What was not fitted is as the preset has it, to its comment and its digits.
    let text = std::fs::read_to_string(&finger).unwrap();
    for kept in [
        "# The finger of the discrete model's",
        "poissons_ratio = 0.48\n",
        "heights_mm = [9, 18, 27, 36, 45, 54, 63]\n",
    ] {
        assert!(text.contains(kept), "{kept}:\n{text}");
    }
    assert!(std::fs::read_to_string(&plot).unwrap().contains("residual"));
    assert!(value["outliers"].is_u64() && value["rms_of_all_n"].as_f64() >= value["rms_n"].as_f64(), "{value}");

    let options = "--elements reduced --fit youngs-modulus,zero";
    let output = fre(&words, options);
    let mut said = Transcript::default();
    let text = String::from_utf8(output.stdout).unwrap();
    let text = said::words(&text.replace(&format!("{}/", folder.0.path().display()), ""));
    said.add(&format!("fre calibrate {options}"), folder.0.path(), (output.status.code(), &text));
    snapbox::assert_data_eq!(said.text(), snapbox::file!["words/calibrated.txt"].raw());
}

#[test]
fn bad_input_is_named() {
    let folder = Folder::new();
    let (tables, cases) = files(&folder);
    let case = [tables[0].as_path(), Path::new("--case"), cases[0].as_path()];
    let two =
        [tables[0].as_path(), &tables[1], &tables[2], Path::new("--case"), &cases[0], Path::new("--case"), &cases[1]];
    let jaw = folder.file(
        "jaw.toml",
        "finger = \"preset:ladder-80\"\nobject = { shape = \"circle\", radius_mm = 40, centre_mm = [41, 45] }\n\
         motion = { direction = [1, 0], distances_mm = [5] }\n",
    );
    let jaw = [tables[0].as_path(), Path::new("--case"), jaw.as_path()];
    let distances = folder.file("d.csv", "distance_mm,force_n\n1,2\n");
    let distances = [distances.as_path(), Path::new("--case"), &cases[0]];
    let refused: [(&str, &[&Path], &[&str]); 12] = [
        ("one", &case, &["--fit", "youngs-modulus,colour"]),
        ("one", &case, &["--fit", "zero,zero"]),
        ("one", &case, &["--force-sd-n", "0"]),
        ("one", &case, &["--drive", "linear 1,0 20"]),
        ("one", &case, &["--fit", "zero,travel"]),
        ("three tables, two cases", &two, &[]),
        ("a jaw", &jaw, &[]),
        ("a jaw", &jaw, &["--drive", "sideways"]),
        ("a jaw", &jaw, &["--drive", "linear 1,0 0"]),
        ("a jaw", &jaw, &["--drive", "linear 0,1 20"]),
        ("distances", &distances, &[]),
        ("a table that is not there", &[Path::new("nowhere.csv"), Path::new("--case"), &cases[0]], &[]),
    ];
    let mut said = String::new();
    for (what, files, options) in refused {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fre"));
        let output = command.arg("calibrate").args(files).args(options).env("COLUMNS", "100").output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{what} {options:?}");
        let message = String::from_utf8(output.stderr).unwrap();
        let message = message.replace(&format!("{}/", folder.0.path().display()), "");
        said += &format!("{what}, {options:?}\n{message}\n");
    }
    snapbox::assert_data_eq!(said, snapbox::file!["words/calibrate.txt"].raw());
}

/// Without measurements: the motion along which to measure, and what it would tell.
#[test]
fn a_motion_is_planned_and_shows_what_it_would_determine() {
    let folder = Folder::new();
    let case = folder.file(
        "case.toml",
        "finger = \"preset:ladder-80\"\n[object]\nshape = \"circle\"\nradius_mm = 40\ncentre_mm = [41, 45]\n\
         [motion]\nmotor_angles_deg = [2, 8]\n",
    );
    let finger = include_str!("../../fre/src/case/presets/ladder-80.toml");
    let finger = finger.replacen("poissons_ratio", "prony = [[0.15, 1], [0.15, 30]]\npoissons_ratio", 1);
    let finger = folder.file("relaxing.toml", &finger);
    let relaxing = std::fs::read_to_string(&case).unwrap().replace("preset:ladder-80", finger.to_str().unwrap());
    let relaxing = folder.file("hold.toml", &relaxing);
    let motion = folder.0.path().join("motion.csv");
    let jaw = folder.file(
        "jaw.toml",
        "finger = \"preset:ladder-80\"\nobject = { shape = \"circle\", radius_mm = 40, centre_mm = [41, 45] }\n\
         motion = { direction = [1, 0], distances_mm = [5] }\n",
    );
    let mut said = Transcript::default();
    let memory = "--fit youngs-modulus,prony-g1,prony-tau1,prony-g2,prony-tau2";
    let cases: [(&Path, &str, i32); 11] = [
        (&relaxing, memory, 0),
        (&case, "--fit youngs-modulus,friction --to-deg 6 --speed-deg-per-s 2", 0),
        (&case, "--fit youngs-modulus,zero,object-x,object-y", 2),
        (&case, "--fit youngs-modulus,friction --torque-sd-nmm 2", 0),
        (&case, "--fit youngs-modulus,friction --torque-sd-nmm 2 --force-sd-n 0.05", 0),
        (&case, memory, 1),
        (&case, "--to-deg -3", 1),
        (&case, "--both-ways", 1),
        (&case, "--plot plan.svg", 1),
        (&jaw, "--drive linear:1,0:20", 1),
        (&case, "--speed-deg-per-s 0", 1),
    ];
    for (case, options, code) in cases {
        let words = [Path::new("--plan"), motion.as_path(), Path::new("--case"), case];
        let mut command = Command::new(env!("CARGO_BIN_EXE_fre"));
        command.arg("calibrate").args(words).args(["--force", "--elements", "reduced"]);
        let options: Vec<String> = options.split_whitespace().map(|word| word.replace(':', " ")).collect();
        let output = command.args(options.iter().map(|word| word.trim())).env("COLUMNS", "100").output().unwrap();
        let text = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
        let name = case.file_name().unwrap().to_string_lossy().into_owned();
        said.add(
            &format!("fre calibrate --plan motion.csv --case {name} {}", options.join(" ")),
            folder.0.path(),
            (output.status.code(), &text),
        );
        assert_eq!(output.status.code(), Some(code), "{options:?}: {text}");
        if code == 1 {
            continue;
        }
        let plan = Plan::parse("motion.csv", &std::fs::read_to_string(&motion).unwrap(), 0.0..=8.0).unwrap();
        assert!(text.starts_with(&format!("{} readings", plan.places.len())), "{text}");
    }
    snapbox::assert_data_eq!(said.text(), snapbox::file!["words/calibrate_plan.txt"].raw());
}

/// What a fit leaves uncertain of the terms goes to the gripper: deviations, and factors whose product is the fit's correlations.
#[test]
fn a_gripper_is_told_how_uncertain_the_terms_are() {
    let folder = Folder::new();
    let finger = include_str!("../../fre/src/case/presets/ladder-80.toml");
    let finger = finger.replacen("poissons_ratio", "prony = [[0.15, 1], [0.15, 30]]\npoissons_ratio", 1);
    folder.file("relaxing.toml", &finger);
    let case = folder.file(
        "hold.toml",
        "finger = \"relaxing.toml\"\n[object]\nshape = \"circle\"\nradius_mm = 40\ncentre_mm = [41, 45]\n\
         [motion]\nmotor_angles_deg = [2, 8]\n",
    );
    let motion = folder.0.path().join("motion.csv");
    let words = [Path::new("--plan"), motion.as_path(), Path::new("--case"), &case];
    let fitted = "youngs-modulus,zero,prony-g1,prony-tau1,prony-g2,prony-tau2";
    let output = fre(&words, &format!("--elements reduced --format json --fit {fitted}"));
    let text = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
    let value: Value = serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {text}"));
    let given: Uncertainty = serde_json::from_value(value["gripper"]["uncertainty"].clone()).unwrap();
    assert_eq!(given.validate(), Ok(()));
    let number = |value: &Value| value.as_f64().unwrap();
    let deviation = |at: usize| number(&value["parameters"][at]["standard_deviation"]);
    let near = |found: f32, expected: f64| {
        assert!((f64::from(found) - expected).abs() <= 1e-5 * expected, "{found} {expected}");
    };
    let memory = given.memory;
    near(memory.parts[0], deviation(2));
    near(memory.times[0], deviation(3) / number(&value["parameters"][3]["value"]));
    near(memory.parts[1], deviation(4));
    near(memory.times[1], deviation(5) / number(&value["parameters"][5]["value"]));
    assert_eq!((memory.parts[2..].to_vec(), memory.times[2..].to_vec()), (vec![0.0; 2], vec![0.0; 2]));

    // Rows of the factor: zero and modulus, then the four of the terms.
    let together = f64::from(given.correlations[0]);
    let mut rows = vec![vec![1.0], vec![together, (1.0 - together * together).sqrt()]];
    let mut among = memory.among.iter();
    for (k, others) in memory.with_others.iter().enumerate().take(4) {
        let entries = others[..2].iter().chain(among.by_ref().take(k));
        let mut row: Vec<f64> = entries.map(|&entry| f64::from(entry) / 127.0).collect();
        row.push((1.0 - row.iter().map(|x| x * x).sum::<f64>()).max(0.0).sqrt());
        rows.push(row);
    }
    // The fit's order is modulus, zero, terms.
    let place = [1, 0, 2, 3, 4, 5];
    let mut strongest = 0.0_f64;
    for i in 0..6 {
        for j in 0..i {
            let found: f64 = rows[i].iter().zip(&rows[j]).map(|(x, y)| x * y).sum();
            let expected = number(&value["correlation"][place[i]][place[j]]);
            assert!((found - expected).abs() < 0.02, "{i}, {j}: {found} {expected}");
            strongest = strongest.max(if i > 1 { expected.abs() } else { 0.0 });
        }
    }
    assert!(strongest > 0.5, "nothing goes together: {}", value["correlation"]);
}

#[test]
fn what_is_read_is_never_written() {
    let folder = Folder::new();
    let (tables, cases) = files(&folder);
    let words = [tables[0].as_path(), Path::new("--case"), cases[0].as_path()];
    let kept = [&tables[0], &cases[0]].map(|path| (path, std::fs::read(path).unwrap()));
    let link = folder.0.path().join("link.toml");
    std::os::unix::fs::symlink(&cases[0], &link).unwrap();
    let other = folder.file("finger.toml", "mine");
    let both = folder.0.path().join("both.svg");
    let mut said = Transcript::default();
    for options in [
        format!("--force --write {}", tables[0].display()),
        format!("--force --write {}", cases[0].display()),
        format!("--force --write {}", link.display()),
        format!("--write {}", other.display()),
        format!("--write {0} --plot {0}", both.display()),
    ] {
        let output = fre(&words, &options);
        assert_eq!(output.status.code(), Some(1), "{options}");
        let errors = String::from_utf8(output.stderr).unwrap();
        said.add(&format!("fre calibrate {options}"), folder.0.path(), (Some(1), &errors));
    }
    snapbox::assert_data_eq!(said.text(), snapbox::file!["words/calibrate_files.txt"].raw());
    for (path, bytes) in kept {
        assert!(std::fs::read(path).unwrap() == bytes, "{}", path.display());
    }
    assert_eq!(std::fs::read_to_string(&other).unwrap(), "mine");
}

/// A closing and an opening give friction beside modulus and zero. A closing alone does not: friction then looks like a stiffer finger.
#[test]
fn friction_comes_back_from_a_closing_and_an_opening() {
    const ALL: [Parameter; 3] = [Parameter::YoungsModulus, Parameter::Zero, Parameter::Friction];
    let design = design();
    let truth = Trial { parameters: ALL.to_vec(), values: vec![46.0, 0.3, 0.4] };
    let closing = Protocol::cylinders(&[[45.0, 40.0]], 24);
    let both = closing.clone().there_and_back();
    let fitted = |protocol: &Protocol, seed| {
        let runs = draw(&model(&design), &truth, protocol, Errors::USUAL, seed).unwrap();
        fit(&model(&design), &runs, &ALL, &Noise::default()).unwrap()
    };
    let mut squares = 0.0;
    for seed in 0..6 {
        let found = fitted(&both, seed);
        assert!(found.converged && found.undetermined.is_empty(), "{found:?}");
        for (estimate, value) in found.estimates.iter().zip(&truth.values) {
            squares += ((estimate.value - value) / estimate.standard_deviation).powi(2) / 18.0;
        }
        let friction = &found.estimates[2];
        assert!(friction.standard_deviation < 0.02, "{friction:?}");
    }
    assert!((0.2..2.5).contains(&squares), "mean square of errors over stated deviations {squares}");
    let (one_way, both) = (fitted(&closing, 1), fitted(&both, 1));
    println!("{squares}: {:?} {:?}, one way {:?}", both.estimates, both.correlation, one_way.estimates);
    assert!(one_way.estimates[2].standard_deviation > 2.5 * both.estimates[2].standard_deviation, "{one_way:?}");
    assert!(one_way.correlation[2][0] < -0.85 && both.correlation[2][0].abs() < 0.8, "{one_way:?} {both:?}");
}
