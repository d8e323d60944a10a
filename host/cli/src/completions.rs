//! `fre completions`: what a shell needs to complete the program's words.

use std::process::ExitCode;

use clap::Command;
use clap_complete::{Shell, generate};

use crate::exit::bad_input;
use crate::standard::put_out;

/// Print a shell's completions of this program's commands and options
///
/// Write them where the shell looks for them, and open a new one.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The shell
    #[arg(value_enum, value_name = "SHELL")]
    shell: Shell,
}

/// Runs the command.
pub fn run(args: &Args, mut command: Command) -> ExitCode {
    let mut text = Vec::new();
    generate(args.shell, &mut command, "fre", &mut text);
    match put_out(&text) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => bad_input(&error),
    }
}
