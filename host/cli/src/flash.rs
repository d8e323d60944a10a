//! `fre flash`: an image into a board's flash, through a debug probe or the board's own boot loader.

use std::path::PathBuf;
use std::process::ExitCode;

#[cfg(feature = "probe")]
use crate::environment::{self, PROBE};
use crate::exit::bad_input;
use fre_gripper::loader::{LoaderError, Patience, update};
use fre_gripper::probe::{Board, Image, ProbeError};

/// Flash a board: write its image, read it back, start it.
///
/// `cargo xtask firmware BOARD` builds the image; another board's image is refused. With --port the board's own boot loader takes it
/// (OpenCR). Otherwise a debug probe is needed, and a `fre` built with debug probes: cargo run --release -p fre-cli --features probe
/// --bin fre -- flash BOARD
#[derive(Debug, clap::Args)]
pub struct Args {
    #[arg(value_name = "BOARD", help = Board::names(), value_parser = Board::named)]
    board: Board,
    /// The image [default: where `cargo xtask firmware` puts it]
    #[arg(long, value_name = "ELF")]
    image: Option<PathBuf>,
    /// The probe, if there are several [env: FRE_PROBE]
    #[arg(long, value_name = "VID:PID[:SERIAL]")]
    probe: Option<String>,
    /// The board's serial port: its boot loader takes the image
    #[arg(long, value_name = "PORT", conflicts_with = "probe")]
    port: Option<String>,
}

/// Runs the command.
pub fn run(args: &Args) -> ExitCode {
    match flash(args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => bad_input(&error),
    }
}

fn flash(args: &Args) -> Result<(), LoaderError> {
    let image = Image::read(&args.image.clone().unwrap_or_else(|| args.board.image()), args.board.name)?;
    image.fits(&args.board)?;
    match &args.port {
        Some(port) => update(&args.board, &image, port, Patience::default(), &mut std::io::stdout()),
        None => Ok(write(args, &image)?),
    }
}

#[cfg(feature = "probe")]
fn write(args: &Args, image: &Image) -> Result<(), ProbeError> {
    use fre_gripper::probe::session;
    let probe = args.probe.clone().or_else(|| environment::value(PROBE));
    let selector = session::selector(probe.as_deref())?;
    session::flash(&args.board, image, selector.as_ref(), &mut std::io::stdout())
}

#[cfg(not(feature = "probe"))]
fn write(args: &Args, _image: &Image) -> Result<(), ProbeError> {
    let _ = &args.probe;
    Err(ProbeError::NotBuilt)
}
