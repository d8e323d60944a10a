//! `fre compare`: a case against finite elements or measurements, with the paper's metrics.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::ValueEnum;
use model_core::design::{HingeFrom, HingeKind, MaterialLaw};
use model_core::discretise::{DiscretiseError, Physics};
use model_core::object::Motion;
use serde::Serialize;

use super::options::ModelArgs;
use super::{UNTRUSTWORTHY, bad_input};
use crate::case::Case;
use crate::draw::{self, Chart, Mark, Panel, Scene, Series, Style};
use crate::fea::{self, Analysis, FeaError, Plan, Pose};
use crate::measured::{Coordinate, Measured, outliers};
use crate::metrics::{Point, deviation, force_error, mean_and_max};
use crate::run::{self, Solution};

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
/// frame: lists separated by blanks, or one point per row). Rows of one place belong together. Rows that cannot be used
/// are left out and named with their line. The case's places are replaced by the measured ones, in ascending order: a closing
/// motion.
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
    #[arg(long, value_name = "N", default_value_t = 1, requires = "fea")]
    mesh: usize,
    /// Folder for CalculiX's files [default: the case's name with -fea, in the current folder]
    #[arg(long, value_name = "FOLDER", requires = "fea")]
    folder: Option<PathBuf>,
    /// Form of the results on standard output
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
    /// Draws both shapes at the last place (--fea), or forces and residuals (--measured)
    #[arg(long, value_name = "FILE.svg|FILE.png")]
    plot: Option<PathBuf>,
    #[command(flatten)]
    model: ModelArgs,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Format {
    /// A table.
    Text,
    /// One object.
    Json,
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
    /// Measurements: the force's residual lies far from the others.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    outlier: bool,
    /// Measurements: line of the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    line: Option<usize>,
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
        }
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
        Format::Json => match serde_json::to_string_pretty(&comparison) {
            Ok(text) => text + "\n",
            Err(error) => return bad_input(&error),
        },
    };
    // A reader that stops early is no failure.
    let _ = std::io::Write::write_all(&mut std::io::stdout(), text.as_bytes());
    if let Some(file) = &args.plot {
        match scene {
            Some(scene) => {
                if let Err(error) = draw::write(&scene, file) {
                    return bad_input(&error);
                }
            }
            None => eprintln!("fre: {}: nothing to draw, no place has both results", file.display()),
        }
    }
    let complete = |row: &Row| row.force_n.is_some() && (comparison.fea.is_none() || row.reference_force_n.is_some());
    if comparison.rows.iter().all(complete) { ExitCode::SUCCESS } else { ExitCode::from(UNTRUSTWORTHY) }
}

type Compared = (Comparison, Option<Scene>);

fn solve(args: &Args, case: &Case) -> Result<(Vec<Solution>, f64), String> {
    let solutions = run::solve(case, &args.model.options()).map_err(|error| match error {
        DiscretiseError::Design(error) => format!("{}: finger.{error}", args.case.display()),
        error => format!("--{error}"),
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
    eprintln!("CalculiX: {} elements, {} increments …", plan.mesh.elements.len(), plan.path.len());
    let analysis = plan.run(case, &folder).map_err(|error| error.to_string())?;
    let rows = solutions.iter().zip(&analysis.poses).map(|(solution, pose)| {
        let front = pose.as_ref().map_or(&[][..], |pose| &pose.front);
        Row::new(solution, pose.as_ref().map(Pose::magnitude), front)
    });
    let rows: Vec<Row> = rows.collect();
    let Analysis { elements, nodes, progress, seconds, .. } = analysis;
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
    let notes = notes(case, args);
    let comparison =
        Comparison { reference: "fea", rows, model_seconds, fea: Some(figures), notes, left_out: Vec::new() };
    Ok((comparison, scene))
}

fn with_measurements(args: &Args, case: &mut Case, file: &Path) -> Result<Compared, String> {
    let mut measured = Measured::read(file).map_err(|error| error.to_string())?;
    let wanted = match case.path.motion {
        Motion::Rotating { .. } => Coordinate::MotorAngle,
        Motion::Translating { .. } => Coordinate::Distance,
    };
    if measured.coordinate != wanted {
        let (found, needed) = (measured.coordinate.column(), wanted.column());
        return Err(format!("{}: has {found}; the case's motion needs {needed}", file.display()));
    }
    measured.measurements.sort_by(|a, b| a.place.total_cmp(&b.place));
    case.path.places = measured.measurements.iter().map(|m| m.place).collect();
    let (solutions, model_seconds) = solve(args, case)?;
    let mut rows: Vec<Row> = solutions
        .iter()
        .zip(&measured.measurements)
        .map(|(s, m)| Row { line: Some(m.line), ..Row::new(s, m.force, &m.front) })
        .collect();
    let known: Vec<usize> = (0..rows.len()).filter(|&i| rows[i].difference_n.is_some()).collect();
    let residuals: Vec<f64> = known.iter().filter_map(|&i| rows[i].difference_n).collect();
    for index in outliers(&residuals) {
        rows[known[index]].outlier = true;
    }
    let scene = (!known.is_empty()).then(|| residual_chart(case, &rows));
    let left_out = measured.problems.iter().map(|problem| format!("{}:{problem}", file.display())).collect();
    let comparison = Comparison { reference: "measured", rows, model_seconds, fea: None, notes: Vec::new(), left_out };
    Ok((comparison, scene))
}

/// What finite elements have otherwise than the model.
fn notes(case: &Case, args: &Args) -> Vec<String> {
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
    if design.hinge.kind == HingeKind::Welded {
        notes.push(
            "welded lamellae: the model's are rigid, the mesh's bend as the beams do, and the model's force is too large \
             (by 22 % for fea-80 with lamellae of 3 mm)"
                .to_owned(),
        );
    }
    if design.hinge.kind == HingeKind::Pinned {
        notes.push(
            "pinned lamellae are stiff links between the centrelines in the mesh, and have no thickness there"
                .to_owned(),
        );
    }
    notes
}

fn unit(case: &Case) -> &'static str {
    match case.path.motion {
        Motion::Rotating { .. } => "°",
        Motion::Translating { .. } => "mm",
    }
}

fn text(case: &Case, comparison: &Comparison) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = write_text(&mut out, case, comparison);
    out
}

fn write_text(out: &mut String, case: &Case, comparison: &Comparison) -> std::fmt::Result {
    let number = |value: Option<f64>, decimals: usize| value.map_or("–".into(), |v| format!("{v:.decimals$}"));
    let signed = |value: Option<f64>, decimals: usize| value.map_or("–".into(), |v| format!("{v:+.decimals$}"));
    let reference = if comparison.fea.is_some() { "FEA" } else { "measured" };
    let place = format!("at {}", unit(case));
    writeln!(
        out,
        "{place:>8} {:>10} {:>10} {:>9} {:>8} {:>14} {:>13}  status",
        "force N",
        format!("{reference} N"),
        "diff. N",
        "error %",
        "shape mean mm",
        "shape max mm"
    )?;
    for row in &comparison.rows {
        writeln!(
            out,
            "{:>8.3} {:>10} {:>10} {:>9} {:>8} {:>14} {:>13}  {}{}",
            row.place,
            number(row.force_n, 4),
            number(row.reference_force_n, 4),
            signed(row.difference_n, 4),
            signed(row.error_percent, 2),
            number(row.shape_mean_mm, 3),
            number(row.shape_max_mm, 3),
            row.status,
            match (row.outlier, row.line) {
                (true, Some(line)) => format!(", outlier (line {line})"),
                _ => String::new(),
            }
        )?;
    }
    if let Some([mean, max]) = mean_and_max(comparison.rows.iter().filter_map(|row| row.error_percent)) {
        writeln!(out, "force error: mean {mean:.2} %, max {max:.2} %")?;
    }
    let means = mean_and_max(comparison.rows.iter().filter_map(|row| row.shape_mean_mm));
    let maxima = mean_and_max(comparison.rows.iter().filter_map(|row| row.shape_max_mm));
    if let (Some([mean, _]), Some([_, max])) = (means, maxima) {
        writeln!(out, "shape deviation (nearest distance): mean {mean:.3} mm, max {max:.3} mm")?;
    }
    if let Some(fea) = &comparison.fea {
        writeln!(
            out,
            "CalculiX: {} elements, {} nodes, {} increments ({} attempts failed), {} iterations; files in {}",
            fea.elements, fea.nodes, fea.increments, fea.failed_attempts, fea.iterations, fea.folder
        )?;
        writeln!(
            out,
            "time: CalculiX {:.1} s, model {:.2} ms: {:.0} times faster",
            fea.seconds,
            1e3 * comparison.model_seconds,
            fea.speed_ratio
        )?;
    }
    for note in &comparison.notes {
        writeln!(out, "note: {note}")?;
    }
    let missing = comparison.rows.iter().filter(|row| row.reference_force_n.is_none()).count();
    if missing > 0 {
        writeln!(out, "{missing} of {} places have no {reference} force", comparison.rows.len())?;
    }
    if !comparison.left_out.is_empty() {
        writeln!(out, "left out:")?;
        for problem in &comparison.left_out {
            writeln!(out, "  {problem}")?;
        }
    }
    Ok(())
}

/// Both shapes over each other, finger frame.
fn overlay(case: &Case, solution: &Solution, pose: &Pose) -> Result<Scene, FeaError> {
    let series = |name: &str, colour, style, points: &[Point]| Series {
        name: name.to_owned(),
        colour,
        style,
        points: points.to_vec(),
    };
    // Scale of the picture, px per mm, and what its titles and axes take.
    let scale = 6.5;
    let lines = [&pose.front, &pose.back, &solution.front_mm, &solution.back_mm];
    let mut low = [f64::INFINITY; 2];
    let mut high = [f64::NEG_INFINITY; 2];
    for p in lines.into_iter().flatten() {
        for axis in 0..2 {
            low[axis] = low[axis].min(p[axis] - 3.0);
            high[axis] = high[axis].max(p[axis] + 3.0);
        }
    }
    high[0] += 12.0;
    let middle = [high[0], 0.5 * (low[1] + high[1])];
    let object: Vec<Point> = fea::object_line(case, pose.place, middle, 2.0 * (high[1] - low[1]))
        .into_iter()
        .map(|[x, y]| {
            // The axes end where the finger does; the rest of the object is not drawn.
            let inside = (low[0]..=high[0]).contains(&x) && (low[1]..=high[1]).contains(&y);
            if inside { [x, y] } else { [f64::NAN; 2] }
        })
        .collect();
    let mut chart = Chart::new(
        format!("{}: model and finite elements", case.finger.name),
        format!(
            "{}{}, force {:.3} N, FEA {:.3} N; finger frame",
            pose.place,
            if unit(case) == "°" { "°" } else { " mm" },
            solution.force_magnitude_n.unwrap_or(0.0),
            pose.magnitude()
        ),
        "*x* (mm)",
    );
    chart.x_range = Some([low[0], high[0]]);
    chart.width = scale * (high[0] - low[0]) + 90.0;
    chart.height = scale * (high[1] - low[1]) + 150.0;
    chart.panels.push(Panel {
        y_title: "*y* (mm)".to_owned(),
        y_range: Some([low[1], high[1]]),
        series: vec![
            series("object", 6, Style::Line, &object),
            series("FEA", 1, Style::Line, &pose.front),
            series("FEA", 1, Style::Line, &pose.back),
            series("model", 0, Style::Dashed, &solution.front_mm),
            series("model", 0, Style::Dashed, &solution.back_mm),
        ],
        ..Panel::default()
    });
    Ok(chart.scene())
}

/// Forces over the place, and below them the residuals.
fn residual_chart(case: &Case, rows: &[Row]) -> Scene {
    let points = |value: &dyn Fn(&Row) -> Option<f64>| -> Vec<Point> {
        rows.iter().map(|row| [row.place, value(row).unwrap_or(f64::NAN)]).collect()
    };
    let x_title = match case.path.motion {
        Motion::Rotating { .. } => "motor angle *α* (°)",
        Motion::Translating { .. } => "distance *d* (mm)",
    };
    let subtitle = format!(
        "{} measured forces; residual: model less measured",
        rows.iter().filter(|row| row.reference_force_n.is_some()).count()
    );
    let mut chart = Chart::new(format!("{}: model and measurements", case.finger.name), subtitle, x_title);
    let series = |name: &str, colour, style, points| Series { name: name.to_owned(), colour, style, points };
    chart.panels.push(Panel {
        y_title: "*F* (N)".to_owned(),
        share: 2.0,
        series: vec![
            series("model", 0, Style::Line, points(&|row| row.force_n)),
            series("measured", 1, Style::Dots, points(&|row| row.reference_force_n)),
        ],
        ..Panel::default()
    });
    let rings = rows
        .iter()
        .filter(|row| row.outlier)
        .filter_map(|row| row.difference_n.map(|y| Mark::Ring { at: [row.place, y], words: "outlier".to_owned() }));
    chart.panels.push(Panel {
        y_title: "residual (N)".to_owned(),
        share: 1.0,
        marks: rings.collect(),
        series: vec![series("residual", 4, Style::LineAndDots, points(&|row| row.difference_n))],
        ..Panel::default()
    });
    chart.scene()
}
