//! `fre compare`: a case against finite elements or measurements, with the paper's metrics.

mod pictures;
mod words;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::ValueEnum;
use model_core::design::{Design, HingeFrom, HingeKind, MaterialLaw, PlaneStrain};
use model_core::discretise::{DiscretiseError, Physics, plate_factor};
use model_core::object::Motion;
use serde::Serialize;

use pictures::{overlay, residual_chart};
use words::{csv, outlier_lines, text};

use super::options::{ModelArgs, ThemeWord, refused};
use super::{UNTRUSTWORTHY, bad_input, put_out};
use crate::case::Case;
use crate::draw::{self, Scene, short};
use crate::fea::{Analysis, Plan, Pose};
use crate::measured::{Coordinate, Measured, Measurement, outliers};
use crate::metrics::{Point, deviation, deviation_of_outlines, distance, force_error};
use crate::run::{self, Solution};
use crate::warn;

/// Compare a case with finite elements (--fea) or measurements (--measured).
///
/// Shape deviation: distance from each point of the reference's front centreline to the nearest point of the model's; its
/// mean along the finger and its largest value. Force error: magnitude of the model's net force less the reference's.
///
/// --fea meshes the finger with its real thicknesses (straight or bowed, tapered; flexible, pinned or welded lamellae), presses
/// it on the object (any shape) with CalculiX (`ccx`; `cargo xtask setup --fea` installs it) and compares at every place of
/// the case's motion.
///
/// --measured reads a CSV whose header names the columns, in any order, with units: motor_angle_deg (or distance_mm); force_n
/// (magnitude) or fx_n, fy_n (on the object, world frame); front_x_mm, front_y_mm (points of the front centreline, finger
/// frame: lists separated by blanks, or one point per row). Semicolons or tabs instead of commas will do, then with decimal
/// commas too; up to 64 MB. Rows of one place belong together: several forces of a place are averaged, several outlines count alike. Rows that
/// cannot be used are left out and named with their line. Outliers (readings, and points of the outline, much farther from the
/// model than the others) are named with their line and count all the same; the figures without them are told beside.
/// The case's places are replaced by the measured ones, in ascending order: a closing motion (--order).
///
/// Exit status: 0 all compared; 1 bad input; 2 some place without a trustworthy solution or out of CalculiX's reach.
#[derive(Debug, clap::Args)]
#[command(group = clap::ArgGroup::new("reference").required(true).args(["fea", "measured"]))]
pub struct Args {
    /// The case file
    #[arg(value_name = "CASE.toml")]
    case: PathBuf,
    /// Compares with finite elements
    #[arg(long)]
    fea: bool,
    /// Compares with measurements
    #[arg(long, value_name = "FILE.csv")]
    measured: Option<PathBuf>,
    /// Refinement of the finite elements: every element becomes N by N
    #[arg(long, value_name = "N", default_value_t = 1, conflicts_with = "measured")]
    mesh: usize,
    /// Order in which the measured places are visited
    #[arg(long, value_enum, default_value = "closing", conflicts_with = "fea")]
    order: Order,
    /// Folder for CalculiX's files [default: the case's name with -fea, in the current folder]
    #[arg(long, value_name = "FOLDER", conflicts_with = "measured")]
    folder: Option<PathBuf>,
    /// Form of the results on standard output
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
    /// Draws both shapes at the last place (--fea), or forces and residuals (--measured)
    #[arg(long, value_name = "FILE.svg|FILE.png")]
    plot: Option<PathBuf>,
    /// Colours of a PNG; an SVG follows its viewer's
    #[arg(long, value_enum, default_value = "light", requires = "plot")]
    plot_theme: ThemeWord,
    #[command(flatten)]
    model: ModelArgs,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Format {
    /// A table.
    Text,
    /// One object.
    Json,
    /// One line per place; notes go to standard error.
    Csv,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Order {
    /// Ascending, whatever the file's order.
    Closing,
    /// The file's: closing and opening again, with the finger's hysteresis.
    File,
}

/// A place at which both sides were asked.
#[derive(Debug, Serialize)]
struct Row {
    /// Degrees or mm.
    place: f64,
    status: String,
    force_n: Option<f64>,
    reference_force_n: Option<f64>,
    difference_n: Option<f64>,
    error_percent: Option<f64>,
    shape_mean_mm: Option<f64>,
    shape_max_mm: Option<f64>,
    shape_max_at_mm: Option<Point>,
    /// Measurements: a reading's residual lies far from the others'.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    outlier: bool,
    /// Measurements: line of the file, the place's first.
    #[serde(skip_serializing_if = "Option::is_none")]
    line: Option<usize>,
    /// Measurements: the forces that `reference_force_n` is the mean of.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    readings: Vec<Reading>,
    /// Measurements: points of the outline that lie far from the model, compared with the others.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    outlying_points: Vec<OutlyingPoint>,
    /// Measurements: the same place without its outlying readings and points, if it has any.
    #[serde(skip_serializing_if = "Option::is_none")]
    without_outliers: Option<Box<Row>>,
}

/// A measured force.
#[derive(Debug, Serialize)]
struct Reading {
    /// Line of the file.
    line: usize,
    force_n: f64,
    /// Model less reading.
    difference_n: Option<f64>,
    outlier: bool,
}

/// A point of a measured outline.
#[derive(Debug, Serialize)]
struct OutlyingPoint {
    /// Which of the place's points it is.
    #[serde(skip)]
    index: usize,
    /// Line of the file.
    line: usize,
    point_mm: Point,
    /// Distance to the model's line.
    distance_mm: f64,
}

impl Row {
    fn new(solution: &Solution, reference_force: Option<f64>, reference_front: &[Point]) -> Self {
        let force = solution.force_magnitude_n;
        let error = force.zip(reference_force).map(|(force, reference)| force_error(force, reference));
        let shape = deviation(&solution.front_mm, reference_front);
        Self {
            place: solution.place(),
            status: solution.status.to_string(),
            force_n: force,
            reference_force_n: reference_force,
            difference_n: error.map(|e| e.difference),
            error_percent: error.and_then(|e| e.percent),
            shape_mean_mm: shape.map(|s| s.mean),
            shape_max_mm: shape.map(|s| s.max),
            shape_max_at_mm: shape.map(|s| s.at),
            outlier: false,
            line: None,
            readings: Vec::new(),
            outlying_points: Vec::new(),
            without_outliers: None,
        }
    }

    /// A measured place.
    fn measured(solution: &Solution, measurement: &Measurement) -> Self {
        let force = solution.force_magnitude_n;
        let reading = |&(line, force_n): &(usize, f64)| {
            let difference_n = force.map(|force| force_error(force, force_n).difference);
            Reading { line, force_n, difference_n, outlier: false }
        };
        let outlines = measurement.outlines();
        let outlines = outlines.into_iter().map(|part| &measurement.front[part]);
        let shape = deviation_of_outlines(&solution.front_mm, outlines);
        Self {
            line: Some(measurement.line),
            readings: measurement.forces.iter().map(reading).collect(),
            shape_mean_mm: shape.map(|s| s.mean),
            shape_max_mm: shape.map(|s| s.max),
            shape_max_at_mm: shape.map(|s| s.at),
            ..Self::new(solution, measurement.force, &[])
        }
    }

    /// Computes the place once more without its outliers, if it has any.
    fn leave_outliers_out(&mut self, solution: &Solution, measurement: &Measurement) {
        let readings = self.readings.iter().enumerate().filter(|(_, reading)| reading.outlier);
        let readings: Vec<usize> = readings.map(|(index, _)| index).collect();
        let points: Vec<usize> = self.outlying_points.iter().map(|point| point.index).collect();
        if !readings.is_empty() || !points.is_empty() {
            let rest = measurement.without(&readings, &points);
            self.without_outliers = Some(Box::new(Self::measured(solution, &rest)));
        }
    }

    /// Lines of the readings that are outliers.
    fn outlier_lines(&self) -> Vec<String> {
        self.readings.iter().filter(|reading| reading.outlier).map(|reading| reading.line.to_string()).collect()
    }
}

/// Everything that JSON shows.
#[derive(Debug, Serialize)]
struct Comparison {
    reference: &'static str,
    rows: Vec<Row>,
    model_seconds: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    fea: Option<FeaFigures>,
    /// What the two sides do not have in common.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    notes: Vec<String>,
    /// Rows of the file that were left out.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    left_out: Vec<String>,
}

#[derive(Debug, Serialize)]
struct FeaFigures {
    seconds: f64,
    /// FEA's time over the model's.
    speed_ratio: f64,
    elements: usize,
    nodes: usize,
    increments: usize,
    failed_attempts: usize,
    iterations: usize,
    folder: String,
}

/// Runs the command.
pub fn run(args: &Args) -> ExitCode {
    if let Some(Err(error)) = args.plot.as_deref().map(draw::Format::of) {
        return bad_input(&error);
    }
    let mut case = match Case::read(&args.case) {
        Ok(case) => case,
        Err(error) => return bad_input(&error),
    };
    let compared = match &args.measured {
        Some(file) => with_measurements(args, &mut case, file),
        None => with_fea(args, &case),
    };
    let (comparison, scene) = match compared {
        Ok(compared) => compared,
        Err(message) => return bad_input(&message),
    };
    let text = match args.format {
        Format::Text => text(&case, &comparison),
        Format::Csv => {
            for note in &comparison.notes {
                tell!("fre: note: {note}");
            }
            for problem in &comparison.left_out {
                tell!("fre: left out: {problem}");
            }
            for line in outlier_lines(&case, &comparison) {
                tell!("fre: {line}");
            }
            csv(&case, &comparison)
        }
        Format::Json => match serde_json::to_string_pretty(&comparison) {
            Ok(text) => text + "\n",
            Err(error) => return bad_input(&error),
        },
    };
    if let Err(error) = put_out(&text) {
        return bad_input(&error);
    }
    if let Some(file) = &args.plot {
        match scene {
            Some(scene) => {
                if let Err(error) = draw::write_in(&scene, file, args.plot_theme.theme()) {
                    return bad_input(&error);
                }
            }
            None => tell!("fre: {}: nothing to draw, no place has both results", file.display()),
        }
    }
    let complete = |row: &Row| row.force_n.is_some() && (comparison.fea.is_none() || row.reference_force_n.is_some());
    if comparison.rows.iter().all(complete) { ExitCode::SUCCESS } else { ExitCode::from(UNTRUSTWORTHY) }
}

type Compared = (Comparison, Option<Scene>);

fn solve(args: &Args, case: &Case) -> Result<(Vec<Solution>, f64), String> {
    let solutions = run::solve(case, &args.model.options()).map_err(|error| match error {
        DiscretiseError::Design(error) => format!("{}: finger.{error}", args.case.display()),
        error => refused(&error),
    })?;
    let seconds = solutions.iter().map(|solution| solution.elapsed_us * 1e-6).sum();
    Ok((solutions, seconds))
}

fn with_fea(args: &Args, case: &Case) -> Result<Compared, String> {
    let folder = args.folder.clone().unwrap_or_else(|| {
        let stem = args.case.file_stem().unwrap_or_default().to_string_lossy();
        PathBuf::from(format!("{stem}-fea"))
    });
    let plan = Plan::of(case, args.mesh).map_err(|error| format!("{}: {error}", args.case.display()))?;
    let (solutions, model_seconds) = solve(args, case)?;
    tell!("CalculiX: {} elements, {} increments …", plan.mesh.elements.len(), plan.path.len());
    let analysis = plan.run(case, &folder).map_err(|error| error.to_string())?;
    let rows = solutions.iter().zip(&analysis.poses).map(|(solution, pose)| {
        let front = pose.as_ref().map_or(&[][..], |pose| &pose.front);
        Row::new(solution, pose.as_ref().map(Pose::magnitude), front)
    });
    let rows: Vec<Row> = rows.collect();
    let Analysis { elements, nodes, progress, seconds, unread, doubts, .. } = analysis;
    let figures = FeaFigures {
        seconds,
        speed_ratio: seconds / model_seconds.max(1e-9),
        elements,
        nodes,
        increments: progress.increments,
        failed_attempts: progress.failed_attempts,
        iterations: progress.iterations,
        folder: folder.display().to_string(),
    };
    let both = solutions.iter().zip(&analysis.poses).rev();
    let last = both.filter_map(|(s, p)| p.as_ref().map(|p| (s, p))).find(|(s, _)| s.status.is_trustworthy());
    let scene =
        last.map(|(solution, pose)| overlay(case, solution, pose)).transpose().map_err(|error| error.to_string())?;
    let mut notes = notes(case, args, &solutions);
    notes.extend(warn::warnings(case, &solutions));
    notes.extend(doubts);
    notes.extend(unread.map(|error| format!("{error}: the deformed mesh is not drawn")));
    let comparison =
        Comparison { reference: "fea", rows, model_seconds, fea: Some(figures), notes, left_out: Vec::new() };
    Ok((comparison, scene))
}

fn with_measurements(args: &Args, case: &mut Case, file: &Path) -> Result<Compared, String> {
    let measured = Measured::read(file).map_err(|error| error.to_string())?;
    let wanted = match case.path.motion {
        Motion::Rotating { .. } => Coordinate::MotorAngle,
        Motion::Translating { .. } => Coordinate::Distance,
    };
    if measured.coordinate != wanted {
        let (found, needed) = (measured.coordinate.column(), wanted.column());
        return Err(format!("{}: has {found}; the case's motion needs {needed}", file.display()));
    }
    let measurements = match args.order {
        Order::Closing => measured.closing(),
        Order::File => measured.visits(),
    };
    case.path.places = measurements.iter().map(|m| m.place).collect();
    let (solutions, model_seconds) = solve(args, case)?;
    let mut rows: Vec<Row> = solutions.iter().zip(&measurements).map(|(s, m)| Row::measured(s, m)).collect();
    mark_outliers(&mut rows);
    for (row, (solution, measurement)) in rows.iter_mut().zip(solutions.iter().zip(&measurements)) {
        row.outlying_points = outlying_points(measurement, &solution.front_mm);
        row.leave_outliers_out(solution, measurement);
    }
    let scene = rows.iter().any(|row| row.difference_n.is_some()).then(|| residual_chart(case, &rows));
    let left_out = measured.problems.iter().map(|problem| format!("{}:{problem}", file.display())).collect();
    let mut notes = doubts(args, case, &measured, &measurements, &rows);
    notes.extend(warn::warnings(case, &solutions));
    let comparison = Comparison { reference: "measured", rows, model_seconds, fea: None, notes, left_out };
    Ok((comparison, scene))
}

/// Part of the largest reference force below which forces are not told apart: a load cell's accuracy.
const LEAST_FORCE: f64 = 0.01;
/// The same of an outline's points, mm.
const LEAST_DISTANCE: f64 = 0.05;

/// Marks readings whose residual lies far from the others'.
fn mark_outliers(rows: &mut [Row]) {
    let most = rows.iter().flat_map(|row| &row.readings).map(|reading| reading.force_n).fold(0.0, f64::max);
    let mut known: Vec<&mut Reading> =
        rows.iter_mut().flat_map(|row| &mut row.readings).filter(|reading| reading.difference_n.is_some()).collect();
    let residuals: Vec<f64> = known.iter().filter_map(|reading| reading.difference_n).collect();
    for index in outliers(&residuals, LEAST_FORCE * most) {
        known[index].outlier = true;
    }
    for row in rows {
        row.outlier = row.readings.iter().any(|reading| reading.outlier);
    }
}

/// Points much farther from the model's line, or nearer to it, than the two before and the two behind them: a wrong digit, not a
/// wrong shape. The outermost two of an outline have too few beside them to tell.
fn outlying_points(measurement: &Measurement, line: &[Point]) -> Vec<OutlyingPoint> {
    let distances: Vec<f64> = measurement.front.iter().map_while(|&point| distance(point, line)).collect();
    let mut steps = vec![0.0; distances.len()];
    for outline in measurement.outlines() {
        let Some(of_one) = distances.get(outline.clone()) else { break };
        for (index, near) in of_one.windows(5).enumerate() {
            let mut sorted = near.to_vec();
            sorted.sort_by(f64::total_cmp);
            steps[outline.start + index + 2] = near[2] - sorted[2];
        }
    }
    let far = outliers(&steps, LEAST_DISTANCE).into_iter();
    far.filter_map(|index| {
        let (&line, &point_mm) = (measurement.front_lines.get(index)?, measurement.front.get(index)?);
        Some(OutlyingPoint { index, line, point_mm, distance_mm: distances[index] })
    })
    .collect()
}

/// Measured forces so many times the model's, or the other way round, are probably in another unit.
const DOUBTFUL_RATIO: f64 = 20.0;
/// An outline that covers less of the front beam's length is probably in another unit.
const DOUBTFUL_COVER: f64 = 0.25;

/// What a reader of the results must know of the measurements.
fn doubts(args: &Args, case: &Case, measured: &Measured, measurements: &[Measurement], rows: &[Row]) -> Vec<String> {
    let mut notes = Vec::new();
    if !measured.aside.is_empty() {
        notes.push(format!("columns left aside: {}", measured.aside.join(", ")));
    }
    if args.order == Order::Closing
        && let Some(line) = measured.turns_at()
    {
        notes.push(format!(
            "the places go back at line {line}; every reading is compared with a closing motion (--order file follows the file)"
        ));
    }
    let known = rows.iter().filter_map(|row| row.force_n.zip(row.reference_force_n));
    let mut ratios: Vec<f64> =
        known.filter(|(force, reference)| *force > 0.0 && *reference > 0.0).map(|(f, r)| r / f).collect();
    ratios.sort_by(f64::total_cmp);
    if let Some(&ratio) = ratios.get(ratios.len() / 2).filter(|r| !(1.0 / DOUBTFUL_RATIO..DOUBTFUL_RATIO).contains(*r))
    {
        notes.push(format!(
            "the measured forces are about {} times the model's: check the units (N, and degrees or mm) and where the case has \
             its object",
            if ratio >= 1.0 { format!("{ratio:.0}") } else { format!("{ratio:.2}") }
        ));
    }
    let length = case.finger.design.front.length();
    for m in measurements.iter().filter(|m| m.front.len() > 1) {
        let span = |part: &[Point]| part.windows(2).map(|p| (p[1][0] - p[0][0]).hypot(p[1][1] - p[0][1])).sum::<f64>();
        let span = m.outlines().into_iter().map(|part| span(&m.front[part])).fold(0.0, f64::max);
        if span < DOUBTFUL_COVER * length {
            notes.push(format!(
                "the outline of line {} is {span:.1} mm long, the front beam {length:.1} mm: only that part is compared",
                m.line
            ));
        }
    }
    notes
}

/// What finite elements have otherwise than the model.
fn notes(case: &Case, args: &Args, solutions: &[Solution]) -> Vec<String> {
    let design = &case.finger.design;
    let mut notes = Vec::new();
    if design.material.law != MaterialLaw::StVenantKirchhoff {
        notes.push("the finite elements' material is St. Venant–Kirchhoff; the case has another law".to_owned());
    }
    if args.model.options().discretisation.physics == Physics::Paper {
        notes.push(
            "the finite elements are the finger as it is built; the model has the paper's simplifications (--physics paper)"
                .to_owned(),
        );
    } else if design.hinge.kind == HingeKind::Flexible && design.hinge.from == HingeFrom::Centreline {
        notes.push(
            "finger.hinge.from = \"centreline\": the model's hinges bend from the beams' centrelines, the mesh's necks from the \
             faces"
                .to_owned(),
        );
    }
    notes.extend(plates(design, args.model.options().discretisation.physics));
    let length = design.front.length();
    let at_tip = |solution: &Solution| solution.contacts.iter().any(|contact| contact.arc > length - TIP);
    if solutions.iter().any(at_tip) {
        notes.push(format!(
            "the object touches the tip: the model's is round, {} mm beyond the end of the centreline, the mesh's is cut square \
             at that end; pressed on its end, the model touches that much earlier",
            short(0.5 * design.front.thickness.at(length), 3)
        ));
    }
    if design.hinge.kind == HingeKind::Pinned {
        notes.push(
            "pinned lamellae are stiff links between the centrelines in the mesh, and have no thickness there"
                .to_owned(),
        );
    }
    notes
}

/// A contact so near to the end of the front beam, mm, is one of its tip.
const TIP: f64 = 1e-6;

/// What the two sides make of a finger that bends as a plate: the model's physics have the factor in bending only.
fn plates(design: &Design, physics: Physics) -> Option<String> {
    let factor = plate_factor(design, design.width.at(0.0), design.front.thickness.at(0.0));
    if physics == Physics::Paper || factor == 1.0 {
        return None;
    }
    match design.plane_strain {
        PlaneStrain::Stress => None,
        PlaneStrain::Auto => Some(format!(
            "finger.plane_strain = \"auto\": beams and necks bend as plates, {factor:.3} times as stiff at the front beam's base, \
             and stretch as bars on both sides; the factor is the model's own in the mesh too (as stiffer outer layers), so it is \
             not put to the test"
        )),
        // Measured on the preset dhas-80 with "strain", Ø80 at (41, 45) mm, by `fre compare --fea`.
        PlaneStrain::Strain => Some(format!(
            "finger.plane_strain = \"strain\": the mesh is in plane strain throughout, {factor:.3} times as stiff in stretch as \
             well; the model has that factor in bending only, as a wide strip with free edges has it, and its force is smaller \
             (dhas-80 on Ø80 at mid-height: by 3.4 % at 2°, 13 % at 10°)"
        )),
    }
}

fn unit(case: &Case) -> &'static str {
    case.path.unit().trim_start()
}
