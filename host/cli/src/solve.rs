//! `fre solve`: one equilibrium per motor angle of a case.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::ValueEnum;
use model_core::discretise::DiscretiseError;

use crate::exit::{bad_input, detail, tell, trusted};
use crate::options::{ModelArgs, refused};
use crate::output::{Picture, PlotArgs, one_document, put_out, reads_case};
use crate::progress::ProgressLine;
use crate::standard::{self, Target, is_standard};
use fre::case::Case;
use fre::draw::{self, Scene};
use fre::study::pictures::{self, Kind};
use fre::study::run::{self, Run, Unsolved};
use fre::study::{csv, json, text};
use std::ops::ControlFlow;

/// Solve a case: one equilibrium per motor angle, by continuation from no contact.
///
/// The angles are solved in the case's order. Besides the force, the results have what a designer needs: the largest strains
/// (with a warning above finger.material.max_strain, or 30 % without it), the largest contact pressure, the stiffness that the object sees, and
/// the largest force on the first branch, before the finger snaps through. Along distances, motor_torque_nmm is the force against the motion, N.
///
/// Exit status: 0 all angles converged; 1 bad input; 2 some angle has no trustworthy solution.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The case file; - for standard input
    #[arg(value_name = "CASE.toml")]
    case: PathBuf,
    /// Form of the results on standard output
    #[arg(short, long, value_enum, default_value = "text")]
    format: Format,
    /// Draws the motion as a moving picture; - for standard output
    ///
    /// The picture has the finger and its force at each angle, in the case's order.
    #[arg(long, value_name = "FILE.svg")]
    animate: Option<PathBuf>,
    #[command(flatten)]
    plot: PlotArgs,
    /// What is drawn, one below the other, separated by commas
    ///
    /// The default is the finger at the last trustworthy angle and, for several angles, the force over the angle, or over time with the loop of
    /// a motion that comes back.
    #[arg(long, value_enum, value_delimiter = ',', value_name = "KIND,…", requires = "plot")]
    plot_kind: Vec<KindWord>,
    /// Place of the pictures finger, pressure and strain: one of the case's
    ///
    /// An angle in degrees, or a distance in mm. The default is the last place with a trustworthy solution.
    #[arg(long, value_name = "PLACE", requires = "plot", allow_hyphen_values = true)]
    plot_at: Option<f64>,
    #[command(flatten)]
    model: ModelArgs,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Format {
    /// A table.
    Text,
    /// An array with one object per angle.
    Json,
    /// One line per angle.
    Csv,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum KindWord {
    /// Deformed finger, object and contact forces to scale.
    Finger,
    /// Force over the motion, with branches and snap-throughs; where time passes, over time.
    Force,
    /// Force and torque while the motion closes and opens, and the work that is lost.
    Loop,
    /// Contact force per length of the front beam (N/mm).
    Pressure,
    /// Strain at the outer fibres of both beams and in the hinges (%), with the material's limit.
    Strain,
    /// All of them.
    All,
}

impl KindWord {
    fn kinds(self) -> &'static [Kind] {
        match self {
            Self::Finger => &[Kind::Finger],
            Self::Force => &[Kind::Force],
            Self::Loop => &[Kind::Loop],
            Self::Pressure => &[Kind::Pressure],
            Self::Strain => &[Kind::Strain],
            Self::All => &[Kind::Finger, Kind::Force, Kind::Loop, Kind::Pressure, Kind::Strain],
        }
    }
}

/// How long a moving picture shows each angle, s.
const FRAME_SECONDS: f64 = 0.4;

/// How near a place of the case --plot-at must be, degrees or mm.
const SAME_PLACE: f64 = 1e-6;

/// The pictures asked for; none if there is nothing to draw.
fn picture(args: &Args, case: &Case, run: &Run) -> Result<Option<Scene>, String> {
    let kinds: Vec<Kind> = args.plot_kind.iter().flat_map(|word| word.kinds()).copied().collect();
    let Some(place) = args.plot_at else {
        return Ok(match run.last_known() {
            Some(last) if !kinds.is_empty() => pictures::stacked(case, run, last, &kinds),
            _ => pictures::overview(case, run),
        });
    };
    let at = index_of(case, place)?;
    let kinds = if kinds.is_empty() { KindWord::Finger.kinds() } else { &kinds };
    Ok(pictures::stacked(case, run, at, kinds))
}

/// Which of a case's places this is; a motion that comes back meets it twice: the first is meant.
fn index_of(case: &Case, place: f64) -> Result<usize, String> {
    let places = &case.path.places;
    places.iter().position(|other| (other - place).abs() < SAME_PLACE).ok_or_else(|| {
        let places: Vec<String> = places.iter().map(f64::to_string).collect();
        format!("--plot-at {place}: is not a place of the case; allowed is one of {}", places.join(", "))
    })
}

/// The files of the pictures and of the moving one.
fn plots(args: &Args) -> Result<(Option<Picture>, Option<Target>), String> {
    let mut files = args.plot.files();
    reads_case(&mut files, &args.case).map_err(|error| error.to_string())?;
    let plot = args.plot.picture(&mut files)?;
    // The results as text give way to a picture.
    one_document([
        ("--plot -", args.plot.takes_output()),
        ("--animate -", args.animate.as_deref().is_some_and(is_standard)),
        ("--format json", matches!(args.format, Format::Json)),
        ("--format csv", matches!(args.format, Format::Csv)),
    ])?;
    let moving = args.animate.as_deref().map(|file| match draw::Format::of(file) {
        _ if is_standard(file) => Ok(Target::Standard),
        Ok(draw::Format::Svg) => Target::of(&mut files, file, "--animate").map_err(|error| error.to_string()),
        _ => Err(format!("--animate {}: a moving picture's file ends in .svg", file.display())),
    });
    Ok((plot, moving.transpose()?))
}

/// Solves the case, and says how far it is.
fn solved(args: &Args, case: &Case) -> Result<Run, DiscretiseError> {
    let mut line = ProgressLine::new(false);
    let solved = run::solve_watched(case, &args.model.options(), |progress| {
        let (done, total) = (progress.done, progress.total);
        line.show(false, || format!("solving: {done} of {total} places, {} last", progress.latest.at));
        ControlFlow::<std::convert::Infallible>::Continue(())
    });
    line.wipe();
    let run = solved.map_err(|error| match error {
        Unsolved::Discretise(error) => error,
        Unsolved::Stopped(never) => match never {},
    })?;
    let (places, unknowns, seconds) = (run.places.len(), run.model.unknowns, run.seconds());
    detail!("fre: {places} places with {unknowns} unknowns took {:.1} ms", 1e3 * seconds);
    Ok(run)
}

/// Runs the command.
pub fn run(args: &Args) -> ExitCode {
    // The pictures' names are checked before time is spent on solving.
    let (plot, moving) = match plots(args) {
        Ok(files) => files,
        Err(error) => return bad_input(&error),
    };
    let case = match standard::case(&args.case) {
        Ok(case) => case,
        Err(error) => return bad_input(&error),
    };
    if let Some(Err(error)) = args.plot_at.map(|place| index_of(&case, place)) {
        return bad_input(&error);
    }
    let solved = match solved(args, &case) {
        Ok(run) => run,
        Err(DiscretiseError::Design(error)) => {
            return bad_input(&format!("{}: finger.{error}", args.case.display()));
        }
        Err(error) => return bad_input(&refused(&error)),
    };
    let result = match args.format {
        Format::Text => text::text(&case, &solved),
        Format::Json => match json::json(&solved) {
            Ok(text) => text,
            Err(error) => return bad_input(&error),
        },
        Format::Csv => csv::csv(&solved),
    };
    // A picture on standard output replaces the text.
    let drawn = args.plot.takes_output() || args.animate.as_deref().is_some_and(is_standard);
    if !drawn && let Err(error) = put_out(&result) {
        return bad_input(&error);
    }
    if drawn || !matches!(args.format, Format::Text) {
        // The text has them already.
        for warning in &solved.warnings {
            tell!("fre: warning: {warning}");
        }
    }
    if let Some(plot) = plot {
        match picture(args, &case, &solved) {
            Ok(Some(scene)) => {
                if let Err(error) = plot.draw(&scene) {
                    return bad_input(&error);
                }
            }
            Ok(None) => tell!("fre: {}: nothing to draw, there is no trustworthy solution there", plot.file()),
            Err(error) => return bad_input(&error),
        }
    }
    if let (Some(path), Some(file)) = (&args.animate, moving) {
        let frames = pictures::film(&case, &solved);
        if frames.is_empty() {
            tell!("fre: {}: nothing to draw, there is no trustworthy solution", path.display());
        } else if let Err(error) = file.write(draw::moving_svg(&frames, FRAME_SECONDS).as_bytes()) {
            return bad_input(&error);
        }
    }
    trusted(solved.is_trustworthy())
}
