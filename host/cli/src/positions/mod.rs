//! `fre replay FILE.csv`: a plain table of times and motor positions, which gets the forces that belong to them.

mod table;

use std::io::Write;
use std::path::Path;

use crate::output::reads;
use crate::standard::{self, Target, is_standard};
use fre::case::Case;
use fre::drive::fits_finger;
use fre::files::Files;
use fre::spreadsheet;
use fre::study::model::Precision;
use fre_gripper::estimator::{AnyEstimator, estimator};
use fre_gripper::link::set;
use messages::{Calibration, Mount, Settings};
use model_core::discretise::Discretisation;
use model_core::estimator::Estimate;
use model_core::newton::Hessian;
use table::Table;

/// Columns that are added, and those that come with friction or memory: between which values the force lies.
const ADDED: [&str; 6] = ["force_x_n", "force_y_n", "force_n", "standard_deviation_n", "torque_nmm", "status"];
const INTERVAL: [&str; 2] = ["force_interval_low_n", "force_interval_high_n"];
/// With friction or memory the force depends on the way, which is straight and even from position to position: at most so far at once, rad.
const AT_ONCE: f64 = 0.25 * std::f64::consts::PI / 180.0;
/// Ticks at the end of a way after which the median of the last angles is the last one.
const MEDIAN: u32 = 3;
/// Ticks at one position until its estimate is no longer on the way from the position before.
const TICKS: usize = 400;

type Failure = Box<dyn std::error::Error>;

/// How the forces are estimated.
pub struct Model {
    /// What the case is called in messages.
    pub name: String,
    /// Finger and object.
    pub case: Case,
    /// How the finger is modelled.
    pub how: Discretisation,
    /// In which precision.
    pub precision: Precision,
    /// Settings of finger 0 as KEY=VALUE: zero, direction, gear ratio, play, drive.
    pub settings: Vec<String>,
}

/// A table that has its forces.
pub struct Labelled {
    /// A line for people.
    pub words: String,
    /// Whether every row has a trustworthy force.
    pub whole: bool,
}

/// Whether a file is such a table. Standard input is: a recording is read from a file only.
pub fn is_table(path: &Path) -> bool {
    is_standard(path) || path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("csv"))
}

/// Writes the table with its forces.
///
/// # Errors
/// A file, a line of the table, or what the estimator refuses.
pub fn label(path: &Path, out: &Path, model: &Model, files: &mut Files) -> Result<Labelled, Failure> {
    let name = standard::name(path);
    reads(files, path, "the table")?;
    let mut out = Target::of(files, out, "--csv")?.draft()?;
    let mut settings = Settings::of(Mount::DEFAULT);
    model.settings.iter().try_for_each(|words| set(&mut settings, words).map_err(|error| format!("--set {error}")))?;
    let mount = settings.fingers[0].unwrap_or_default();
    fits_finger(&model.case.path.motion, &mount.drive, 0).map_err(|why| format!("{}: {why}", model.name))?;
    let calibration = Calibration::new(&mount.gear());
    let mut estimator = make(model, &mount)?;

    let text = spreadsheet::exactly(&standard::bytes(path)?)
        .map_err(|line| format!("{name}:{line}: is not text; allowed is a table in UTF-8 or UTF-16"))?;
    let rubs = model.case.friction > 0.0 || !model.case.finger.prony.is_empty();
    let added: Vec<&str> = ADDED.into_iter().chain(INTERVAL.into_iter().filter(|_| rubs)).collect();
    let table = Table::read(&name, &text, &added, &calibration)?;
    let sheet = table.sheet;
    out.write_all(table.style.line(sheet.heads().iter().map(String::as_str).chain(added)).as_bytes())?;
    let (mut trusted, mut before) = (0_u64, None);
    for (cells, &[time, angle]) in sheet.filter_map(|row| row.cells.ok()).zip(&table.places) {
        let estimate = match before.replace([time, angle]) {
            Some([since, from]) if rubs => along(estimator.as_mut(), from, angle, time - since),
            before => settled(estimator.as_mut(), angle, before.map_or(0.0, |[since, _]| time - since), rubs),
        };
        trusted += u64::from(is_known(&estimate));
        let between = estimate.interval.filter(|_| is_known(&estimate)).map(|interval| interval.magnitude);
        let between = [0, 1].map(|end| between.map_or_else(String::new, |ends| ends[end].to_string()));
        let forces = estimated(&estimate).into_iter().chain(between.into_iter().filter(|_| rubs));
        let forces = forces.map(|cell| table.style.number(cell));
        out.write_all(table.style.line(cells.into_iter().chain(forces)).as_bytes())?;
    }
    out.finish()?;
    let rows = table.places.len() as u64;
    let words = format!("{name}: {rows} positions, {trusted} with a trustworthy force\n");
    Ok(Labelled { words, whole: rows == trusted })
}

fn make(model: &Model, mount: &Mount) -> Result<Box<dyn AnyEstimator>, Failure> {
    let mut made = estimator(model.precision, Hessian::default());
    made.configure(&model.case.finger.design, &model.how)?;
    made.set_drive(mount.drive)?;
    made.set_object(model.case.object)?;
    made.set_friction(model.case.friction)?;
    made.set_prony(&model.case.finger.prony)?;
    made.set_uncertainty(mount.uncertainty(None))?;
    Ok(made)
}

/// The estimate at a position, with friction also its derivatives. Tables of slow loops leap: the estimator gets there in several of its own
/// ticks.
fn settled(estimator: &mut dyn AnyEstimator, angle: f64, seconds: f64, rubs: bool) -> Estimate {
    let mut estimate = estimator.update_after(angle, seconds);
    for _ in 1..TICKS {
        if is_known(&estimate) && (!rubs || estimate.standard_deviation.is_finite()) {
            break;
        }
        estimate = estimator.update(angle);
    }
    estimate
}

/// The estimate at a position with friction, on the straight way from the one before.
fn along(estimator: &mut dyn AnyEstimator, from: f64, to: f64, seconds: f64) -> Estimate {
    let steps = ((to - from).abs() / AT_ONCE).ceil().clamp(1.0, 1e6);
    for step in 1..steps as u32 {
        settled(estimator, from + (to - from) * f64::from(step) / steps, seconds / steps, false);
    }
    estimator.update_after(to, seconds / steps);
    // The history follows the middle one of the last angles.
    for _ in 1..MEDIAN {
        estimator.update(to);
    }
    settled(estimator, to, 0.0, true)
}

fn is_known(estimate: &Estimate) -> bool {
    estimate.status.is_trustworthy() && estimate.age == 0
}

/// Cells of the added columns, without the interval; a force that must not be used is an empty one.
fn estimated(estimate: &Estimate) -> [String; ADDED.len()] {
    let cell = |number: f32| if is_known(estimate) { number.to_string() } else { String::new() };
    let [x, y] = estimate.force;
    let numbers = [x, y, estimate.force_magnitude(), estimate.standard_deviation, estimate.torque].map(cell);
    let [x, y, size, deviation, torque] = numbers;
    [x, y, size, deviation, torque, estimate.status.word().to_owned()]
}
