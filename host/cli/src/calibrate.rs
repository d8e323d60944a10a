//! `fre calibrate`: the model's parameters from measurements.

use std::convert::Infallible;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::ValueEnum;
use model_core::discretise::{Discretisation, DiscretiseError};
use model_core::drive::Drive;

use crate::exit::{UNTRUSTWORTHY, bad_input, tell};
use crate::options::{ModelArgs, refused};
use crate::output::{self, Picture, PlotArgs, put_out, reads_case};
use crate::progress::ProgressLine;
use crate::send::{Address, transmit};
use crate::standard::{self, Target, is_standard};
use fre::case::{CaseError, Coordinate, Document, MotionPath};
use fre::files::FileError;
use fre::fit::calibrate::{
    FitError, Input, Loss, Noise, Parameter, Plan, Predictor, Quantity, document, expect, fit_watched, fitted_finger,
    picture, plan_text, text,
};
use fre::fit::measured::MeasuredError;
use fre::study::model::Precision;

/// Arguments that need measurements, which a plan has not.
const MEASURED: [&str; 8] = ["measurements", "both_ways", "write", "send", "finger", "on_top", "plot", "plot_theme"];

/// Fit modulus, zero angle, object offset or dimensions to measurements, with uncertainties.
///
/// The first CSV belongs to the first case, and so on; a single case serves all CSVs. Each case has its own object, all have
/// the same finger. Columns: motor_angle_deg and force_n (or fx_n and fy_n), or motor_torque_nmm with --torque-sd-nmm; and
/// front_x_mm and front_y_mm for outlines. Rows of an opening motion are left out, because backlash shifts them. If the case's
/// material has memory, every row counts and needs time_s, the time since the motion began with an open hand. --plot draws
/// forces or torques, and residuals.
///
/// Exit status: 0 every parameter is determined; 1 bad input; 2 some parameter is not determined by the data, or the fit did
/// not converge.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Measurements; - for standard input
    #[arg(value_name = "CSV", required_unless_present = "plan")]
    measurements: Vec<PathBuf>,
    /// The case (finger and object) of the measurements; once, or once per CSV
    #[arg(short, long = "case", value_name = "CASE.toml", required = true)]
    cases: Vec<PathBuf>,
    /// What is fitted, separated by commas
    ///
    /// youngs-modulus, zero, object-x, object-y, radius, friction, travel, front-thickness, back-thickness, hinge-thickness, hinge-length;
    /// of a material with memory prony-g1 and prony-tau1 to prony-g4 and prony-tau4, the terms of finger.material.prony in their order.
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = parameter,
          default_value = "youngs-modulus,zero,object-x,object-y")]
    fit: Vec<Parameter>,
    /// How the motor moves the finger
    ///
    /// rotating, "linear X,Y MM_PER_RAD" (parallel jaws; X,Y: the direction of closing), or "table X,Y DEG:MM DEG:MM …" (crank
    /// linkages). The measurements have the motor's angles either way.
    #[arg(long, value_name = "DRIVE", default_value = "rotating", value_parser = super::options::drive)]
    drive: Drive,
    // Not clap's default: a plan has forces beside torques only if this was given.
    #[arg(long, value_name = "N", value_parser = positive, help = force_help(" "), long_help = force_help("\n\n"))]
    force_sd_n: Option<f64>,
    /// Standard deviation of a measured motor torque, N·mm; default: left out
    ///
    /// Along a --plan torques are then read instead of forces, or beside them if --force-sd-n is given as well.
    #[arg(long, value_name = "NMM", value_parser = positive)]
    torque_sd_nmm: Option<f64>,
    /// Standard deviation of a measured angle, degrees
    ///
    /// The default is a servo's count (0.088°) over √12, the rounding of its encoder.
    #[arg(long, value_name = "DEG", value_parser = positive)]
    angle_sd_deg: Option<f64>,
    /// Standard deviation of a point of an outline, mm
    #[arg(long, value_name = "MM", default_value_t = Noise::default().outline_mm, value_parser = positive)]
    outline_sd_mm: f64,
    /// Weight of readings far from the model
    #[arg(long, value_enum, default_value = "huber")]
    loss: LossWord,
    /// Uses the rows of opening motions as well, in the file's order
    ///
    /// Friction needs them: it raises the force while a finger closes, and lowers it or leaves it as it is while it opens.
    #[arg(long)]
    both_ways: bool,
    /// Writes the finger with the fitted values
    ///
    /// - is standard output, which then has the finger in place of the results.
    #[arg(short, long, value_name = "finger.toml")]
    write: Option<PathBuf>,
    /// Writes a motion to measure along; shows what it determines
    ///
    /// No CSV is read. The table has the columns time_s and motor_angle_deg, a row per reading; `fre gripper run` moves a finger along it.
    /// The values of the cases take the place of the truth. For friction it closes and opens; for a material with memory it closes, holds, opens,
    /// rests, and closes at a tenth of the speed. - is standard output, which then has the table in place of the results.
    #[arg(long, value_name = "MOTION.csv", conflicts_with_all = MEASURED)]
    plan: Option<PathBuf>,
    /// Highest motor angle of the plan [default: that of the first case]
    #[arg(long, value_name = "DEG", requires = "plan", conflicts_with_all = MEASURED, allow_negative_numbers = true)]
    to_deg: Option<f64>,
    /// Speed of the plan's closing [default: 10 with memory, else 1]
    #[arg(long, value_name = "DEG/S", requires = "plan", conflicts_with_all = MEASURED, value_parser = positive)]
    speed_deg_per_s: Option<f64>,
    /// Sends the calibration to a gripper, and reads it back
    ///
    /// Sent are the finger, its zero position, its drive, the standard deviations and, if there is one CSV, its object. Nothing
    /// is sent if some parameter is undetermined. LINK is unix:PATH, tcp:HOST:PORT, or a serial port as PORT or PORT@BAUD.
    #[arg(long, value_name = "LINK")]
    send: Option<Address>,
    /// The gripper's finger that was measured, from 0
    #[arg(long, value_name = "N", default_value_t = 0, requires = "send")]
    finger: u8,
    /// Adds to the zero of another calibration without asking
    ///
    /// A fitted zero is a difference to the one with which the CSV was measured. The same calibration is never added twice.
    #[arg(long, requires = "send")]
    on_top: bool,
    /// Form of the results on standard output
    #[arg(short, long, value_enum, default_value = "text")]
    format: Format,
    #[command(flatten)]
    plot: PlotArgs,
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

/// Help of `--force-sd-n`, with what separates it from its default.
fn force_help(separator: &str) -> String {
    format!("Standard deviation of a measured force, N{separator}[default: {}]", Noise::default().force_n)
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

/// Runs the command.
pub fn run(args: &Args) -> ExitCode {
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
    one_document(args)?;
    if let Some(path) = &args.plan {
        return plan(args, path);
    }
    let (write, plot) = outputs(args)?;
    let input = input(args)?;
    check(args, &input)?;
    let design = &input.finger.design;
    let noise = noise(args);
    let (discretisation, drive, prony) = (options.discretisation, input.drive, input.finger.prony.as_slice());
    let model = Predictor { design, discretisation, drive, prony };
    let mut line = ProgressLine::new(false);
    let found = fit_watched(&model, &input.runs, &args.fit, &noise, |progress| {
        line.show(false, || format!("fitting: pass {} of at most {}", progress.passes, progress.most));
        ControlFlow::Continue(())
    });
    line.wipe();
    let found = found.map_err(|error| failed(args, error))?;
    let text = match args.format {
        Format::Text => text(&input, &found),
        Format::Json => serde_json::to_string_pretty(&document(&input, &found)).map_err(|e| e.to_string())? + "\n",
    };
    if !args.plot.takes_output() && !args.write.as_deref().is_some_and(is_standard) {
        put_out(&text)?;
    }
    if let Some(file) = write {
        file.write(fitted_finger(&input, &found).as_bytes())?;
    }
    if let Some(file) = plot {
        file.draw(&picture(&input.finger.name, &input.runs, &found))?;
    }
    let whole = found.converged && found.undetermined.is_empty();
    if let Some(address) = &args.send {
        if whole {
            let how = Discretisation::estimator(options.discretisation.physics);
            transmit(address, args.finger, how, &input, &found, args.on_top)?;
        } else {
            tell!("fre: nothing was sent, because the fit did not converge or some parameter is undetermined");
        }
    }
    Ok(whole)
}

/// Refuses two documents on standard output; the results as text give way to another one.
fn one_document(args: &Args) -> Result<(), String> {
    let there = |path: &Option<PathBuf>| path.as_deref().is_some_and(is_standard);
    output::one_document([
        ("--write -", there(&args.write)),
        ("--plan -", there(&args.plan)),
        ("--plot -", args.plot.takes_output()),
        ("--format json", matches!(args.format, Format::Json)),
    ])
}

/// Refuses what cannot be fitted to these cases.
fn check(args: &Args, input: &Input) -> Result<(), String> {
    for (index, parameter) in args.fit.iter().enumerate() {
        if args.fit[..index].contains(parameter) {
            return Err(format!("--fit names {} twice", parameter.word()));
        }
        let obstacle = parameter.obstacle(&input.finger.design, &input.finger.prony, &input.objects, &input.drive);
        if let Some(obstacle) = obstacle {
            return Err(format!("--fit {}: {obstacle}", parameter.word()));
        }
    }
    Ok(())
}

fn noise(args: &Args) -> Noise {
    let default = Noise::default();
    Noise {
        force_n: args.force_sd_n.unwrap_or(default.force_n),
        torque_nmm: args.torque_sd_nmm.unwrap_or(default.torque_nmm),
        angle_deg: args.angle_sd_deg.unwrap_or(default.angle_deg),
        outline_mm: args.outline_sd_mm,
        loss: match args.loss {
            LossWord::Huber => Loss::Huber,
            LossWord::Tukey => Loss::Tukey,
            LossWord::Square => Loss::Square,
        },
    }
}

/// What is read along a plan: torques where their standard deviation is given, and forces unless it is given alone.
fn planned(args: &Args) -> &'static [Quantity] {
    match (args.force_sd_n, args.torque_sd_nmm) {
        (Some(_), Some(_)) => &Quantity::ALL,
        (None, Some(_)) => &[Quantity::Torque],
        (_, None) => &[Quantity::Force],
    }
}

/// What went wrong with the model, with the case that it is of.
fn failed(args: &Args, error: FitError<Infallible>) -> String {
    match error {
        FitError::Discretise(DiscretiseError::Design(error)) => {
            format!("{}: finger.{error}", args.cases[0].display())
        }
        FitError::Discretise(error) => refused(&error),
        FitError::NoParameters => format!("--fit: {error}"),
        FitError::Stopped(never) => match never {},
    }
}

/// Writes a motion to measure along; whether it determines everything.
fn plan(args: &Args, path: &Path) -> Result<bool, String> {
    let mut files = args.plot.files();
    let words = |error: FileError| error.to_string();
    args.cases.iter().try_for_each(|path| reads_case(&mut files, path)).map_err(words)?;
    let file = Target::of(&mut files, path, "--plan").map_err(words)?;
    let documents = documents(args)?;
    let first = documents.first().ok_or("needed is --case")?.1.case().map_err(|error| error.to_string())?;
    let (from_deg, to_deg) = ends(args, &first.path)?;
    let prony = first.finger.prony;
    let there_and_back = args.fit.contains(&Parameter::Friction);
    let speed_deg_per_s = args.speed_deg_per_s.unwrap_or(if prony.is_empty() { 1.0 } else { 10.0 });
    let plan = Plan::new(from_deg, to_deg, speed_deg_per_s, &prony, there_and_back);
    let mut input = Input::planned(&plan, &documents, args.drive).map_err(|error| error.to_string())?;
    check(args, &input)?;
    let (design, discretisation) = (input.finger.design.clone(), args.model.options().discretisation);
    let model = Predictor { design: &design, discretisation, drive: input.drive, prony: &prony };
    let noise = noise(args);
    let found = expect(&model, &mut input, &args.fit, planned(args), &noise).map_err(|error| failed(args, error))?;
    if !is_standard(path) {
        put_out(&match args.format {
            Format::Text => plan_text(&plan, &input, &found, &noise),
            Format::Json => serde_json::to_string_pretty(&document(&input, &found)).map_err(|e| e.to_string())? + "\n",
        })?;
    }
    file.write(plan.csv().as_bytes())?;
    Ok(found.converged && found.undetermined.is_empty())
}

/// Where a plan begins and how far it goes, degrees.
fn ends(args: &Args, case: &MotionPath) -> Result<(f64, f64), String> {
    let mut ends = (0.0_f64, f64::NEG_INFINITY);
    if case.along() == Coordinate::Angle {
        ends = case.places.iter().fold(ends, |(least, most), place| (least.min(*place), most.max(*place)));
    }
    let to_deg = args.to_deg.unwrap_or(ends.1);
    if to_deg > ends.0 && to_deg <= 180.0 {
        return Ok((ends.0, to_deg));
    }
    let given = if to_deg.is_finite() { format!(" {to_deg}") } else { String::new() };
    Err(format!("--to-deg{given}: needed is the plan's highest motor angle, above {} and up to 180", ends.0))
}

fn documents(args: &Args) -> Result<Vec<(String, Document)>, String> {
    let documents = args.cases.iter().map(|path| Ok((path.display().to_string(), standard::document(path)?)));
    documents.collect::<Result<_, CaseError>>().map_err(|error| error.to_string())
}

/// What is read: the cases first, so that a slip in one is reported before a long file is read.
fn input(args: &Args) -> Result<Input, String> {
    let documents = documents(args)?;
    let measured = args.measurements.iter().map(|path| Ok((path.display().to_string(), standard::measured(path)?)));
    let measured = measured.collect::<Result<Vec<_>, MeasuredError>>().map_err(|error| error.to_string())?;
    let input = Input::of_measured(measured, documents, args.both_ways, args.drive);
    let input = input.and_then(|input| if args.torque_sd_nmm.is_some() { Ok(input) } else { input.without_torques() });
    input.map_err(|error| error.to_string())
}

/// The files that are written: the finger and the picture.
fn outputs(args: &Args) -> Result<(Option<Target>, Option<Picture>), String> {
    let mut files = args.plot.files();
    let words = |error: FileError| error.to_string();
    let measured = args.measurements.iter().filter(|path| !is_standard(path));
    measured.clone().try_for_each(|path| files.input(path, "the measurements")).map_err(words)?;
    args.cases.iter().try_for_each(|path| reads_case(&mut files, path)).map_err(words)?;
    let write = args.write.as_deref().map(|path| Target::of(&mut files, path, "--write")).transpose().map_err(words)?;
    Ok((write, args.plot.picture(&mut files)?))
}
