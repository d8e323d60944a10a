//! `fre compare`: a case against finite elements or measurements, with the metrics of *Geometrico-Static Modelling of a FRE Finger*.

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::ValueEnum;
use model_core::discretise::DiscretiseError;

use crate::exit::{bad_input, tell, trusted};
use crate::options::{ModelArgs, refused};
use crate::output::{Picture, PlotArgs, one_document, put_out, reads_case};
use crate::progress::ProgressLine;
use crate::standard::{self, is_standard, only_folder};
use fre::case::Case;
use fre::compare::{self, CompareError, Comparison, with_elements_watched, with_measurements_watched};
use fre::fea::DECK;
use fre::files::FileError;

/// Compare a case with finite elements (--fea) or measurements (--measured).
///
/// Shape deviation is the distance from each point of the reference's front centreline to the nearest point of the model's:
/// its mean along the finger and its largest value. Force error is the magnitude of the model's net force minus the
/// reference's.
///
/// --fea meshes the finger with its real thicknesses (straight or bowed, tapered; flexible, pinned or welded lamellae, ribs with a gap; solid tips), presses
/// it on the object (any shape) with CalculiX (`ccx`; `cargo xtask setup --fea` installs it) and compares at every place of
/// the case's motion. --plot draws both shapes at the last place.
///
/// --measured reads a CSV file of up to 64 MB. Its header names the columns, in any order, with units: motor_angle_deg (or
/// distance_mm); force_n (magnitude) or fx_n, fy_n (on the object, world frame); front_x_mm, front_y_mm (points of the front
/// centreline, finger frame: lists separated by blanks, or one point per row). Cells may be separated by semicolons or tabs
/// instead of commas; numbers may then have decimal commas. Forces measured at the same place are averaged; outlines of the
/// same place have equal weight. Rows that cannot be used are left out and listed with their line. Outliers (readings or
/// outline points much farther from the model than the others) are included in the statistics and listed with their line;
/// the statistics without them are shown as well. The case's places are replaced by the measured ones in ascending order,
/// as in a closing motion (--order). --plot draws forces and residuals.
///
/// Exit status: 0 all compared; 1 bad input; 2 some place has no trustworthy solution or was not reached by CalculiX.
#[derive(Debug, clap::Args)]
#[command(group = clap::ArgGroup::new("reference").required(true).args(["fea", "measured"]))]
pub struct Args {
    /// The case file; - for standard input
    #[arg(value_name = "CASE.toml")]
    case: PathBuf,
    /// Compares with finite elements
    #[arg(long)]
    fea: bool,
    /// Compares with measurements; - for standard input
    #[arg(short, long, value_name = "FILE.csv")]
    measured: Option<PathBuf>,
    /// Refinement of the finite elements: every element becomes N by N
    #[arg(long, value_name = "N", default_value_t = 1, conflicts_with = "measured")]
    mesh: usize,
    /// Order in which the measured places are visited
    #[arg(long, value_enum, default_value = "closing", conflicts_with = "fea")]
    order: Order,
    /// Folder for CalculiX's files
    ///
    /// The default is the case's name with -fea, in the current folder.
    #[arg(long, value_name = "FOLDER", value_parser = only_folder, conflicts_with = "measured")]
    folder: Option<PathBuf>,
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

impl From<Order> for compare::Order {
    fn from(order: Order) -> Self {
        match order {
            Order::Closing => Self::Closing,
            Order::File => Self::File,
        }
    }
}

/// CalculiX' folder.
fn folder(args: &Args) -> PathBuf {
    args.folder.clone().unwrap_or_else(|| {
        let stem = args.case.file_stem().unwrap_or_default().to_string_lossy();
        PathBuf::from(format!("{stem}-fea"))
    })
}

/// The file of the picture; no other one is lost by this run.
fn plot(args: &Args) -> Result<Option<Picture>, String> {
    let mut files = args.plot.files();
    let words = |error: FileError| error.to_string();
    // The results as text give way to a picture.
    one_document([
        ("--plot -", args.plot.takes_output()),
        ("--format json", matches!(args.format, Format::Json)),
        ("--format csv", matches!(args.format, Format::Csv)),
    ])?;
    reads_case(&mut files, &args.case).map_err(words)?;
    match &args.measured {
        Some(measured) if is_standard(measured) => {}
        Some(measured) => files.input(measured, "--measured").map_err(words)?,
        None => {
            let deck = folder(args).join(DECK);
            if deck.exists() {
                // CalculiX writes its files itself: that they may be lost is all that is asked here.
                drop(files.output(&deck, "--folder").map_err(words)?);
            }
        }
    }
    args.plot.picture(&mut files)
}

/// Runs the command.
pub fn run(args: &Args) -> ExitCode {
    let plot = match plot(args) {
        Ok(plot) => plot,
        Err(error) => return bad_input(&error),
    };
    let mut case = match standard::case(&args.case) {
        Ok(case) => case,
        Err(error) => return bad_input(&error),
    };
    let comparison = match compared(args, &mut case) {
        Ok(comparison) => comparison,
        Err(message) => return bad_input(&message),
    };
    let text = match args.format {
        Format::Text => comparison.text(&case),
        Format::Csv => {
            for note in &comparison.notes {
                tell!("fre: note: {note}");
            }
            for problem in &comparison.left_out {
                tell!("fre: left out: {problem}");
            }
            for line in comparison.outlier_lines(&case) {
                tell!("fre: {line}");
            }
            comparison.csv(&case)
        }
        Format::Json => match comparison.json() {
            Ok(text) => text,
            Err(error) => return bad_input(&error),
        },
    };
    if !args.plot.takes_output()
        && let Err(error) = put_out(&text)
    {
        return bad_input(&error);
    }
    if let Some(plot) = plot {
        match &comparison.picture {
            Some(scene) => {
                if let Err(error) = plot.draw(scene) {
                    return bad_input(&error);
                }
            }
            None => tell!("fre: {}: nothing to draw, no place has both results", plot.file()),
        }
    }
    trusted(comparison.is_complete())
}

fn compared(args: &Args, case: &mut Case) -> Result<Comparison, String> {
    let options = args.model.options();
    let compared = match &args.measured {
        Some(file) => {
            let measured = standard::measured(file).map_err(|error| error.to_string())?;
            let mut line = ProgressLine::new(false);
            let compared = with_measurements_watched(case, &options, &measured, file, args.order.into(), |progress| {
                line.show(false, || format!("solving: {} of {} measured places", progress.done, progress.total));
                ControlFlow::Continue(())
            });
            line.wipe();
            compared
        }
        None => {
            let mut line = ProgressLine::new(false);
            let mut told = false;
            let compared = with_elements_watched(case, &options, args.mesh, &folder(args), |progress| {
                if !std::mem::replace(&mut told, true) {
                    tell!("fre: CalculiX: {} elements, {} increments …", progress.elements, progress.total);
                }
                line.show(false, || format!("CalculiX: {} of {} increments", progress.done, progress.total));
                ControlFlow::Continue(())
            });
            line.wipe();
            compared
        }
    };
    compared.map_err(|error| match error {
        CompareError::Discretise(DiscretiseError::Design(error)) => format!("{}: finger.{error}", args.case.display()),
        CompareError::Discretise(error) => refused(&error),
        CompareError::Mesh(error) => format!("{}: {error}", args.case.display()),
        error => error.to_string(),
    })
}
