//! `fre finger`: a finger as a drawing or a solid, and back.

#[cfg(not(feature = "cad"))]
use std::process::ExitCode;

#[cfg(feature = "cad")]
mod command;
#[cfg(feature = "cad")]
mod urdf;
#[cfg(feature = "cad")]
pub use command::{Args, run};

/// Write a finger's outline as a drawing or a solid (needs a build with `--features cad`)
#[cfg(not(feature = "cad"))]
#[derive(Debug, clap::Args)]
#[command(disable_help_flag = true)]
pub struct Args {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    _all: Vec<String>,
}

#[cfg(not(feature = "cad"))]
pub fn run(_: &Args) -> ExitCode {
    crate::exit::bad_input(
        &"this program was built without `finger`; build it with: cargo run --release -p fre-cli --features cad --bin fre -- finger …",
    )
}
