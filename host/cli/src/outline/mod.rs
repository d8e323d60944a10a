//! `fre outline`: the front beam's shape from a photograph.

#[cfg(not(feature = "outline"))]
use std::process::ExitCode;

#[cfg(feature = "outline")]
mod command;
#[cfg(feature = "outline")]
pub use command::{Args, run};

/// Take the front beam's shape from a photograph (needs `--features outline`)
#[cfg(not(feature = "outline"))]
#[derive(Debug, clap::Args)]
#[command(disable_help_flag = true)]
pub struct Args {
    /// Whatever the command takes when it is built in
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    _all: Vec<String>,
}

/// Says how to build the command in.
#[cfg(not(feature = "outline"))]
pub fn run(_: &Args) -> ExitCode {
    crate::exit::bad_input(
        &"this program was built without `outline`; build it with: cargo run --release -p fre-cli --features outline --bin fre -- outline …",
    )
}
