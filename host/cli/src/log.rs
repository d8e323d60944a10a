//! `fre log`: a board's log as text, through a debug probe or out of QEMU.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

#[cfg(feature = "probe")]
use crate::environment::{self, PROBE};
use crate::exit::bad_input;
use fre_gripper::probe::{Board, ProbeError};

/// Show a board's log: time, level, message, and place in the source.
///
/// The firmware keeps running while its log is read. Ctrl-C ends the command. A board needs a `fre` built with debug probes:
/// cargo run --release -p fre-cli --features probe --bin fre -- log BOARD; --qemu boots the image for QEMU and needs a build with
/// `--features log`, but no probe.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[arg(value_name = "BOARD", help = Board::names(), value_parser = Board::named, required_unless_present = "qemu", conflicts_with = "qemu")]
    board: Option<Board>,
    /// Boots the gripper in QEMU (mps2-an500) with nothing on its bus
    #[arg(long)]
    qemu: bool,
    /// The image for QEMU [default: where `cargo xtask firmware` puts it]
    #[arg(long, value_name = "ELF")]
    image: Option<PathBuf>,
    /// The probe, if there are several [env: FRE_PROBE]
    #[arg(long, value_name = "VID:PID[:SERIAL]", conflicts_with = "qemu")]
    probe: Option<String>,
    /// Stops after this time [default: never]
    #[arg(long, value_name = "S")]
    seconds: Option<f64>,
}

/// Runs the command.
pub fn run(args: &Args) -> ExitCode {
    let longest = match args.seconds.map(Duration::try_from_secs_f64).transpose() {
        Ok(longest) => longest,
        Err(_) => return bad_input(&"--seconds is not a time; allowed is 0 and more"),
    };
    let shown = match args.board {
        None => emulate(args, longest),
        Some(board) => listen(args, &board, longest),
    };
    match shown {
        Ok(()) => ExitCode::SUCCESS,
        // Whoever reads the lines has read enough.
        Err(ProbeError::Log { source, .. }) if source.kind() == std::io::ErrorKind::BrokenPipe => ExitCode::SUCCESS,
        Err(error) => bad_input(&error),
    }
}

#[cfg(feature = "log")]
fn emulate(args: &Args, longest: Option<Duration>) -> Result<(), ProbeError> {
    use fre_gripper::probe::emulated;
    use std::io::Write;
    use std::ops::ControlFlow;

    let image = args.image.clone().unwrap_or_else(emulated::image);
    let mut out = std::io::stdout().lock();
    emulated::log(&image, longest, |_, lines| {
        for line in lines {
            writeln!(out, "{line}")?;
        }
        out.flush()?;
        Ok(ControlFlow::Continue(()))
    })
}

#[cfg(not(feature = "log"))]
fn emulate(_: &Args, _: Option<Duration>) -> Result<(), ProbeError> {
    Err(ProbeError::NoLog)
}

#[cfg(feature = "probe")]
fn listen(args: &Args, board: &Board, longest: Option<Duration>) -> Result<(), ProbeError> {
    use fre_gripper::probe::{Image, session};
    let image = Image::read(&args.image.clone().unwrap_or_else(|| board.image()), board.name)?;
    let probe = args.probe.clone().or_else(|| environment::value(PROBE));
    let selector = session::selector(probe.as_deref())?;
    session::log(board, &image, selector.as_ref(), longest, &mut std::io::stdout())
}

#[cfg(not(feature = "probe"))]
fn listen(args: &Args, _board: &Board, _longest: Option<Duration>) -> Result<(), ProbeError> {
    let _ = &args.probe;
    Err(ProbeError::NotBuilt)
}
