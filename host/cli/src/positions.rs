//! `fre replay FILE.csv`: a plain table of times and motor positions, which gets the forces that belong to them.

use std::io::Write;
use std::path::Path;

use crate::output::reads;
use crate::standard::{self, Target, is_standard};
use fre::case::Case;
use fre::delimited;
use fre::drive::fits_finger;
use fre::files::Files;
use fre::study::model::Precision;
use fre_gripper::estimator::{AnyEstimator, estimator};
use fre_gripper::link::set;
use messages::{Calibration, Mount, Settings};
use model_core::discretise::Discretisation;
use model_core::estimator::Estimate;
use model_core::newton::Hessian;

/// Columns that are added, and those that come with friction or memory: between which values the force lies.
const ADDED: [&str; 6] = ["force_x_n", "force_y_n", "force_n", "standard_deviation_n", "torque_nmm", "status"];
const INTERVAL: [&str; 2] = ["force_interval_low_n", "force_interval_high_n"];
/// With friction or memory the force depends on the way, which is straight and even from position to position: at most so far at once, rad.
const AT_ONCE: f64 = 0.25 * std::f64::consts::PI / 180.0;
/// Columns of which one says where the motor is.
const POSITIONS: &str = "`angle_deg`, `angle_rad` or `position_counts`";
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

    let text = standard::bytes(path)?;
    let mut reader = csv::Reader::from_reader(&text[..]);
    let head = reader.headers().map_err(|error| format!("{name}: {error}"))?.clone();
    let columns = Columns::find(&head).map_err(|why| format!("{name}:1: {why}"))?;
    let rubs = model.case.friction > 0.0 || !model.case.finger.prony.is_empty();
    let interval: &[&str] = if rubs { &INTERVAL } else { &[] };
    if let Some(there) = interval.iter().find(|added| head.iter().any(|name| name.trim() == **added)) {
        return Err(format!("{name}:1: there is a column `{there}` already").into());
    }
    out.write_all(delimited::line(head.iter().chain(ADDED).chain(interval.iter().copied())).as_bytes())?;
    let (mut rows, mut trusted, mut before, mut last) = (0_u64, 0_u64, f64::NEG_INFINITY, None);
    for row in reader.records() {
        let row = row.map_err(|error| match error.kind() {
            csv::ErrorKind::UnequalLengths { pos, expected_len, len } => {
                format!(
                    "{name}:{}: has {len} cells; needed are {expected_len}, as in the first line",
                    delimited::line_number(&text, pos.as_ref())
                )
            }
            _ => format!("{name}: {error}"),
        })?;
        let at = |why: String| format!("{name}:{}: {why}", delimited::line_number(&text, row.position()));
        let (time, angle) = columns.read(&row, &calibration).map_err(at)?;
        if time <= before {
            return Err(at(format!("time_s is {time}; allowed is above {before}, that of the line before")).into());
        }
        let seconds = if before.is_finite() { time - before } else { 0.0 };
        before = time;
        let estimate = match last.replace(angle).filter(|_| rubs) {
            Some(from) => along(estimator.as_mut(), from, angle, seconds),
            None => settled(estimator.as_mut(), angle, seconds, rubs),
        };
        rows += 1;
        trusted += u64::from(is_known(&estimate));
        let between = estimate.interval.filter(|_| is_known(&estimate)).map(|interval| interval.magnitude);
        let between = [0, 1].map(|end| between.map_or_else(String::new, |ends| ends[end].to_string()));
        let added = cells(&estimate).into_iter().chain(between.into_iter().filter(|_| rubs));
        out.write_all(delimited::line(row.iter().map(str::to_owned).chain(added)).as_bytes())?;
    }
    out.finish()?;
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

/// Cells of the added columns; a force that must not be used is an empty one.
fn cells(estimate: &Estimate) -> [String; ADDED.len()] {
    let cell = |number: f32| if is_known(estimate) { number.to_string() } else { String::new() };
    let [x, y] = estimate.force;
    let numbers = [x, y, estimate.force_magnitude(), estimate.standard_deviation, estimate.torque].map(cell);
    let [x, y, size, deviation, torque] = numbers;
    [x, y, size, deviation, torque, estimate.status.word().to_owned()]
}

/// Where the columns are.
struct Columns {
    time: usize,
    position: usize,
    unit: Unit,
}

#[derive(Clone, Copy)]
enum Unit {
    Degrees,
    Radians,
    Counts,
}

impl Columns {
    fn find(head: &csv::StringRecord) -> Result<Self, String> {
        let find = |name: &str| head.iter().position(|cell| cell.trim() == name);
        let names: Vec<&str> = head.iter().collect();
        let time = find("time_s").ok_or_else(|| format!("no column `time_s`; the columns are {}", names.join(", ")))?;
        let units = [("angle_deg", Unit::Degrees), ("angle_rad", Unit::Radians), ("position_counts", Unit::Counts)];
        let found: Vec<_> = units.into_iter().filter_map(|(name, unit)| Some((find(name)?, unit))).collect();
        if let Some(there) = ADDED.iter().find(|added| find(added).is_some()) {
            return Err(format!("there is a column `{there}` already"));
        }
        match found[..] {
            [(position, unit)] => Ok(Self { time, position, unit }),
            [] => Err(format!("no column {POSITIONS}; the columns are {}", names.join(", "))),
            _ => Err(format!("several columns of positions; allowed is one of {POSITIONS}")),
        }
    }

    /// Time, s, and the finger's motor angle, rad.
    fn read(&self, row: &csv::StringRecord, calibration: &Calibration) -> Result<(f64, f64), String> {
        let number = |column: usize, name: &str| {
            let cell = row.get(column).unwrap_or_default().trim();
            let number = cell.parse::<f64>().ok().filter(|number| number.is_finite());
            number.ok_or_else(|| format!("{name} is `{cell}`; allowed is a number"))
        };
        let time = number(self.time, "time_s")?;
        let angle = match self.unit {
            Unit::Degrees => number(self.position, "angle_deg")?.to_radians(),
            Unit::Radians => number(self.position, "angle_rad")?,
            Unit::Counts => {
                let counts = number(self.position, "position_counts")?;
                if counts.fract() != 0.0 || counts.abs() > 1_044_479.0 {
                    return Err(format!("position_counts is {counts}; allowed are whole numbers to ±1044479"));
                }
                calibration.finger_angle(counts as i32)
            }
        };
        Ok((time, angle))
    }
}
