//! `fre calibrate`: the model's parameters from measurements.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::ValueEnum;
use model_core::discretise::{Discretisation, DiscretiseError};
use model_core::object::{Motion, ObjectDesign};
use serde_json::{Value, json};

use super::options::{ModelArgs, refused};
use super::{UNTRUSTWORTHY, bad_input, put_out};
use crate::calibrate::{
    Calibrated, Combination, Fit, Loss, Model, Noise, Parameter, Run, finger_file, fit, picture, send, uncertainty,
    zero_counts,
};
use crate::case::{Case, Finger};
use crate::draw;
use crate::link::{Address, Link};
use crate::measured::{Coordinate, Measured};
use crate::run::Precision;

/// Fit modulus, zero angle, object offset or dimensions to measurements, with uncertainties.
///
/// Each CSV belongs to the case in the same place (or to the only one): one object each, all with the same finger. Columns:
/// motor_angle_deg and force_n (or fx_n and fy_n), and front_x_mm and front_y_mm for outlines. Rows of an opening motion are left
/// out, as backlash shifts them. Exit status: 0 every parameter determined; 1 bad input; 2 some parameter not determined by
/// the data, or a fit that did not converge.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Measurements
    #[arg(value_name = "CSV", required = true)]
    measurements: Vec<PathBuf>,
    /// The case (finger and object) of the measurements; once, or once per CSV
    #[arg(long = "case", value_name = "CASE.toml", required = true)]
    cases: Vec<PathBuf>,
    /// What is fitted: youngs-modulus, zero, object-x, object-y, radius, front-thickness, back-thickness, hinge-thickness,
    /// hinge-length
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = parameter,
          default_value = "youngs-modulus,zero,object-x,object-y")]
    fit: Vec<Parameter>,
    /// Standard deviation of a measured force, N
    #[arg(long, value_name = "N", default_value_t = Noise::default().force_n, value_parser = positive)]
    force_sd_n: f64,
    /// Standard deviation of a measured angle, degrees [default: a servo's count over √12]
    #[arg(long, value_name = "DEG", value_parser = positive)]
    angle_sd_deg: Option<f64>,
    /// Standard deviation of a point of an outline, mm
    #[arg(long, value_name = "MM", default_value_t = Noise::default().outline_mm, value_parser = positive)]
    outline_sd_mm: f64,
    /// How readings far off count
    #[arg(long, value_enum, default_value = "huber")]
    loss: LossWord,
    /// Uses the rows of opening motions as well
    #[arg(long)]
    both_ways: bool,
    /// Writes the finger with the fitted values
    #[arg(long, value_name = "finger.toml")]
    write: Option<PathBuf>,
    /// Sends the finger, its zero position, the standard deviations and, if there is one run, its object to a gripper, and reads them back: unix:PATH,
    /// tcp:HOST:PORT, or a serial port as PORT or PORT@BAUD. Not if some parameter is undetermined
    #[arg(long, value_name = "LINK")]
    send: Option<Address>,
    /// The gripper's finger that was measured, from 0
    #[arg(long, value_name = "N", default_value_t = 0, requires = "send")]
    finger: u8,
    /// Form of the results on standard output
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
    /// Draws forces and residuals
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

#[derive(Clone, Copy, Debug, ValueEnum)]
enum LossWord {
    /// Linear beyond 1.345 standard deviations.
    Huber,
    /// Rejected beyond 4.685.
    Tukey,
    /// Squared throughout.
    Square,
}

fn parameter(word: &str) -> Result<Parameter, String> {
    Parameter::of(word).ok_or_else(|| {
        let words: Vec<&str> = Parameter::ALL.iter().map(|parameter| parameter.word()).collect();
        format!("allowed is {}", words.join(", "))
    })
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value <= 1000.0 => Ok(value),
        _ => Err("allowed is a number above 0, up to 1000".to_owned()),
    }
}

/// What was read.
struct Input {
    finger: Finger,
    objects: Vec<ObjectDesign>,
    runs: Vec<Run>,
    remarks: Vec<String>,
}

/// Runs the command.
pub fn run(args: &Args) -> ExitCode {
    if let Some(Err(error)) = args.plot.as_deref().map(draw::Format::of) {
        return bad_input(&error);
    }
    match calibrate(args) {
        Ok(whole) if whole => ExitCode::SUCCESS,
        Ok(_) => ExitCode::from(UNTRUSTWORTHY),
        Err(message) => bad_input(&message),
    }
}

fn calibrate(args: &Args) -> Result<bool, String> {
    let options = args.model.options();
    if options.precision != Precision::F64 {
        return Err("--precision f32: a fit needs f64".to_owned());
    }
    let input = read(args)?;
    let design = &input.finger.design;
    for (index, parameter) in args.fit.iter().enumerate() {
        if args.fit[..index].contains(parameter) {
            return Err(format!("--fit names {} twice", parameter.word()));
        }
        if let Some(obstacle) = parameter.obstacle(design, &input.objects) {
            return Err(format!("--fit {}: {obstacle}", parameter.word()));
        }
    }
    let default = Noise::default();
    let noise = Noise {
        force_n: args.force_sd_n,
        angle_deg: args.angle_sd_deg.unwrap_or(default.angle_deg),
        outline_mm: args.outline_sd_mm,
        loss: match args.loss {
            LossWord::Huber => Loss::Huber,
            LossWord::Tukey => Loss::Tukey,
            LossWord::Square => Loss::Square,
        },
    };
    let model = Model { design, discretisation: options.discretisation };
    let found = fit(&model, &input.runs, &args.fit, &noise).map_err(|error| match error {
        DiscretiseError::Design(error) => format!("{}: finger.{error}", args.cases[0].display()),
        error => refused(&error),
    })?;
    let text = match args.format {
        Format::Text => text(&input, &found),
        Format::Json => serde_json::to_string_pretty(&document(&input, &found)).map_err(|e| e.to_string())? + "\n",
    };
    put_out(&text)?;
    if let Some(file) = &args.write {
        write(file, &input.finger, &found)?;
    }
    if let Some(file) = &args.plot {
        draw::write(&picture(&input.finger.name, &input.runs, &found), file).map_err(|error| error.to_string())?;
    }
    let whole = found.converged && found.undetermined.is_empty();
    if let Some(address) = &args.send {
        if whole {
            transmit(args, address, &input, &found)?;
        } else {
            tell!("fre: nothing was sent: the fit is not whole");
        }
    }
    Ok(whole)
}

/// Sends the calibration to a gripper.
fn transmit(args: &Args, address: &Address, input: &Input, fit: &Fit) -> Result<(), String> {
    let design = &input.finger.design;
    let finger = messages::Finger {
        design: fit.trial.design(design),
        how: Discretisation::estimator(args.model.options().discretisation.physics),
    };
    let object = match input.objects.as_slice() {
        [one] => Some(fit.trial.object(*one, design)),
        // Which of them is in the gripper is not known.
        _ => None,
    };
    let calibrated =
        Calibrated { finger, zero_counts: zero_counts(fit, design), uncertainty: uncertainty(fit, design), object };
    let link = Link::open(address).map_err(|error| error.to_string())?;
    let [before, now] = send(&link, args.finger, &calibrated).map_err(|error| format!("--send {address}: {error}"))?;
    let and = if object.is_some() { " and object" } else { "" };
    tell!(
        "fre: sent to finger {} of the gripper at {address}, and read back: finger{and}, uncertainty, zero position {before:.2} → {now:.2} counts",
        args.finger
    );
    Ok(())
}

fn read(args: &Args) -> Result<Input, String> {
    let (files, cases) = (args.measurements.len(), args.cases.len());
    if cases != 1 && cases != files {
        return Err(format!("{files} files of measurements and {cases} cases; allowed is one case, or one per file"));
    }
    let cases = args.cases.iter().map(|path| Case::read(path).map_err(|error| error.to_string()));
    let cases: Vec<Case> = cases.collect::<Result<_, _>>()?;
    let finger = cases[0].finger.clone();
    for (case, path) in cases.iter().zip(&args.cases) {
        if case.finger.design != finger.design {
            return Err(format!("{}: its finger is not that of {}", path.display(), args.cases[0].display()));
        }
        if !matches!(case.path.motion, Motion::Rotating { .. }) {
            return Err(format!("{}: a calibration needs motor angles, not distances", path.display()));
        }
    }
    let (mut runs, mut objects, mut remarks) = (Vec::new(), Vec::new(), Vec::new());
    for (index, path) in args.measurements.iter().enumerate() {
        let measured = Measured::read(path).map_err(|error| error.to_string())?;
        let name = path.display().to_string();
        if measured.coordinate != Coordinate::MotorAngle {
            return Err(format!("{name}: has {}; needed is motor_angle_deg", measured.coordinate.column()));
        }
        let object = cases[if cases.len() == 1 { 0 } else { index }].object;
        let (run, opening) = if args.both_ways {
            (Run::all(&name, object, &measured), Vec::new())
        } else {
            // Three counts of a servo: readings of one place scatter by less.
            Run::closing(&name, object, &measured, 3.0 * 360.0 / 4096.0)
        };
        if !measured.aside.is_empty() {
            remarks.push(format!("left out: {name}: columns {}", measured.aside.join(", ")));
        }
        remarks.extend(measured.problems.iter().map(|problem| format!("left out: {name}:{problem}")));
        if let (Some(first), count @ 1..) = (opening.first(), opening.len()) {
            remarks.push(format!(
                "left out: {count} rows of {name} that belong to an opening motion (from line {first} on; --both-ways uses them)"
            ));
        }
        objects.push(object);
        runs.push(run);
    }
    Ok(Input { finger, objects, runs, remarks })
}

/// A combination as a person reads it.
fn words(combination: &Combination) -> String {
    let terms = combination
        .terms
        .iter()
        .map(|(parameter, change)| format!("{} {change:+.3} {}", parameter.word(), parameter.unit()));
    terms.collect::<Vec<_>>().join(" with ")
}

fn text(input: &Input, fit: &Fit) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = write_text(&mut out, input, fit);
    out
}

fn write_text(out: &mut String, input: &Input, fit: &Fit) -> std::fmt::Result {
    let design = &input.finger.design;
    let forces = fit.residuals.len();
    writeln!(out, "{}: {forces} forces of {} runs", input.finger.name, input.runs.len())?;
    writeln!(out, "{:<16} {:>10} {:>10} {:>10}  unit", "parameter", "start", "fitted", "σ")?;
    for estimate in &fit.estimates {
        let note = if estimate.determined { "" } else { "  not determined by the data" };
        writeln!(
            out,
            "{:<16} {:>10.4} {:>10.4} {:>10.4}  {}{note}",
            estimate.parameter.word(),
            estimate.start,
            estimate.value,
            estimate.standard_deviation,
            estimate.parameter.unit()
        )?;
    }
    for combination in &fit.undetermined {
        writeln!(out, "the data do not tell {} from no change", words(combination))?;
    }
    if fit.estimates.len() > 1 {
        writeln!(out, "correlation")?;
        for (i, estimate) in fit.estimates.iter().enumerate() {
            let row: Vec<String> = fit.correlation[i][..=i].iter().map(|value| format!("{value:>6.2}")).collect();
            writeln!(out, "{:<16} {}", estimate.parameter.word(), row.join(" "))?;
        }
    }
    writeln!(
        out,
        "residuals: rms {:.4} N, {:.2} times what the stated noise allows; {} passes{}",
        fit.rms_n(),
        fit.inflation,
        fit.passes,
        if fit.converged { "" } else { ", NOT CONVERGED" }
    )?;
    if let Some((points, rms)) = fit.outline {
        writeln!(out, "outlines: {points} points, rms distance {rms:.3} mm")?;
    }
    for residual in fit.residuals.iter().filter(|residual| residual.is_outlier()) {
        let name = &input.runs[residual.run].name;
        match residual.difference_n() {
            Some(difference) => writeln!(
                out,
                "outlier: {name}:{}: {:.3} N at {:.3}°, {difference:+.3} N off",
                residual.line, residual.measured_n, residual.angle_deg
            )?,
            None => writeln!(out, "no solution: {name}:{}: at {:.3}°", residual.line, residual.angle_deg)?,
        }
    }
    for remark in &input.remarks {
        writeln!(out, "{remark}")?;
    }
    let given = uncertainty(fit, design);
    writeln!(out, "for the gripper (--send does it):")?;
    writeln!(
        out,
        "  zero position {:+.2} counts, if its counts grow on closing and it has no gear",
        zero_counts(fit, design)
    )?;
    writeln!(out, "  finger        E = {:.4} MPa", fit.trial.design(design).material.youngs_modulus)?;
    for (run, object) in input.runs.iter().zip(&input.objects) {
        if let ObjectDesign::Circle { centre, radius } = fit.trial.object(*object, design) {
            writeln!(
                out,
                "  object        ({:.3}, {:.3}) mm, radius {radius:.3} mm ({})",
                centre[0], centre[1], run.name
            )?;
        }
    }
    writeln!(
        out,
        "  uncertainty   zero {:.4}°, E {:.2} %, place ({:.3}, {:.3}) mm, radius {:.3} mm",
        given.zero_angle.to_degrees(),
        100.0 * given.youngs_modulus,
        given.centre[0],
        given.centre[1],
        given.radius
    )
}

fn document(input: &Input, fit: &Fit) -> Value {
    let design = &input.finger.design;
    let estimates = fit.estimates.iter().map(|estimate| {
        json!({
            "parameter": estimate.parameter.word(),
            "unit": estimate.parameter.unit(),
            "start": estimate.start,
            "value": estimate.value,
            "standard_deviation": estimate.standard_deviation,
            "determined": estimate.determined,
        })
    });
    let combination = |combination: &Combination| -> Value {
        let terms = combination.terms.iter().map(|(p, change)| (p.word().to_owned(), json!(change)));
        Value::Object(terms.collect())
    };
    let residuals = fit.residuals.iter().map(|residual| {
        json!({
            "file": input.runs[residual.run].name,
            "line": residual.line,
            "motor_angle_deg": residual.angle_deg,
            "measured_n": residual.measured_n,
            "fitted_n": residual.predicted_n,
            "standard_deviation_n": residual.standard_deviation_n,
            "weight": residual.weight,
        })
    });
    json!({
        "converged": fit.converged,
        "passes": fit.passes,
        "parameters": estimates.collect::<Vec<_>>(),
        "correlation": fit.correlation,
        "undetermined": fit.undetermined.iter().map(combination).collect::<Vec<_>>(),
        "rms_n": fit.rms_n(),
        "inflation": fit.inflation,
        "outline": fit.outline.map(|(points, rms)| json!({ "points": points, "rms_mm": rms })),
        "residuals": residuals.collect::<Vec<_>>(),
        "left_out": input.remarks,
        "gripper": {
            "zero_counts": zero_counts(fit, design),
            "youngs_modulus_mpa": fit.trial.design(design).material.youngs_modulus,
            "uncertainty": uncertainty(fit, design),
        },
    })
}

fn write(file: &Path, finger: &Finger, fit: &Fit) -> Result<(), String> {
    let design = &finger.design;
    let mut remarks = vec!["written by `fre calibrate`; standard deviations in brackets".to_owned()];
    for estimate in &fit.estimates {
        let mut remark = format!(
            "{} = {:.5} ({:.5}) {}",
            estimate.parameter.word(),
            estimate.value,
            estimate.standard_deviation,
            estimate.parameter.unit()
        );
        if !estimate.determined {
            let _ = write!(remark, ", not determined by the data");
        }
        remarks.push(remark);
    }
    remarks.push("zero and object offset belong to the gripper and the case; they are not part of a finger".to_owned());
    let fitted = Finger { design: fit.trial.design(design), ..finger.clone() };
    std::fs::write(file, finger_file(&fitted, &remarks)).map_err(|error| format!("{}: {error}", file.display()))
}
