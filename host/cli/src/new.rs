//! `fre new`: a case to start from.

use std::path::PathBuf;
use std::process::ExitCode;

use fre::case::NEW;

use crate::exit::bad_input;
use crate::output::{ForceArgs, put_out};
use crate::standard::is_standard;

/// Write a commented case with a whole finger, to be edited.
///
/// Example: `fre new my-finger.toml`, then `fre solve my-finger.toml`. Without a name, or as -, the case goes to standard output.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The file to write
    #[arg(value_name = "CASE.toml")]
    file: Option<PathBuf>,
    #[command(flatten)]
    force: ForceArgs,
}

/// Runs the command.
pub fn run(args: &Args) -> ExitCode {
    let written = match args.file.as_ref().filter(|path| !is_standard(path)) {
        None => put_out(NEW),
        Some(path) => args
            .force
            .files()
            .output(path, "the case")
            .and_then(|output| output.write(NEW.as_bytes()))
            .map_err(|error| error.to_string()),
    };
    match written {
        Ok(_) => ExitCode::SUCCESS,
        Err(message) => bad_input(&message),
    }
}
