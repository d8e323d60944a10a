//! `fre solve`: one equilibrium per motor angle of a case.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::ValueEnum;
use model_core::discretise::DiscretiseError;

use super::options::ModelArgs;
use super::{UNTRUSTWORTHY, bad_input};
use crate::case::Case;
use crate::{draw, report, run};

/// Solve a case: one equilibrium per motor angle, by continuation from no contact.
///
/// The path leads through the angles in the case's order. Exit status: 0 all converged; 1 bad input; 2 some angle
/// without a trustworthy solution.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The case file
    #[arg(value_name = "CASE.toml")]
    case: PathBuf,
    /// Form of the results on standard output
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
    /// Draws the finger at the last trustworthy angle and, for several angles, the force over the angle
    #[arg(long, value_name = "FILE.svg|FILE.png")]
    plot: Option<PathBuf>,
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

/// Runs the command.
pub fn run(args: &Args) -> ExitCode {
    // The plot's name is checked before time is spent on solving.
    if let Some(Err(error)) = args.plot.as_deref().map(draw::Format::of) {
        return bad_input(&error);
    }
    let case = match Case::read(&args.case) {
        Ok(case) => case,
        Err(error) => return bad_input(&error),
    };
    let solutions = match run::solve(&case, &args.model.options()) {
        Ok(solutions) => solutions,
        Err(DiscretiseError::Design(error)) => {
            return bad_input(&format!("{}: finger.{error}", args.case.display()));
        }
        Err(error) => return bad_input(&format!("--{error}")),
    };
    let text = match args.format {
        Format::Text => report::text(&case, &solutions),
        Format::Json => match report::json(&solutions) {
            Ok(text) => text,
            Err(error) => return bad_input(&error),
        },
        Format::Csv => report::csv(&solutions),
    };
    // A reader that stops early (`fre … | head`) is no failure.
    let _ = std::io::Write::write_all(&mut std::io::stdout(), text.as_bytes());
    if let Some(file) = &args.plot {
        match report::picture(&case, &solutions) {
            Some(scene) => {
                if let Err(error) = draw::write(&scene, file) {
                    return bad_input(&error);
                }
            }
            None => eprintln!("fre: {}: nothing to draw, no angle has a trustworthy solution", file.display()),
        }
    }
    if solutions.iter().all(|solution| solution.status.is_trustworthy()) {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(UNTRUSTWORTHY)
    }
}
