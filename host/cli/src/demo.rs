//! `fre demo`: the firmware in QEMU beside the full-resolution references.

use std::io::IsTerminal;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;

use crate::exit::{UNTRUSTWORTHY, bad_input};
use crate::options::PhysicsWord;
use crate::output::ForceArgs;
#[cfg(feature = "web")]
use crate::output::put_out;
use crate::signals::stop_flag;
use crate::standard::only_folder;
use crate::view::page_address;
use fre::files::{FileError, Folder};
use fre_gripper::demo::{self, Options, Pace};

/// Run the firmware in QEMU while a finger closes and opens, and check its forces
///
/// The references are the full-resolution models on this PC.
///
/// `cargo xtask demo` builds the firmware and runs this command. It ends by itself with a table and a report; Ctrl-C ends it
/// earlier.
///
/// Exit status: 0 the forces are within their tolerance; 1 the demonstration did not work; 2 some force is not within its
/// tolerance.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The gripper's firmware for QEMU's mps2-an500
    #[arg(long, value_name = "ELF")]
    firmware: PathBuf,
    /// Length of the demonstration, 4 to 600
    #[arg(long, value_name = "S", default_value_t = 20.0)]
    seconds: f64,
    /// Folder for the report
    #[arg(long, value_name = "FOLDER", default_value = "target/demo", value_parser = only_folder)]
    report: PathBuf,
    #[command(flatten)]
    force: ForceArgs,
    /// QEMU's time per instruction: 2^N ns, N from 0 to 10, or off
    ///
    /// off is as fast as QEMU can; costs are then wall time.
    #[arg(long, value_name = "N|off", default_value = "2", value_parser = pace)]
    icount: Pace,
    /// Physics of the target, the references and the servo's load
    #[arg(long, value_enum, default_value = "extended")]
    physics: PhysicsWord,
    /// Serves a live page and goes on until it is stopped
    ///
    /// Needs a build with `--features web`, which is on by default.
    #[arg(long, conflicts_with = "seconds")]
    live: bool,
    /// Address of the live page
    ///
    /// Without a port it is 7878. If other machines can reach it, the page needs the token that is printed with it.
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:7878", requires = "live", conflicts_with = "seconds", value_parser = page_address)]
    listen: SocketAddr,
}

/// The report's folder, where these files will be written.
fn folder(args: &Args, names: &[&str]) -> Result<Folder, FileError> {
    let mut files = args.force.files();
    files.input(&args.firmware, "--firmware")?;
    files.folder(&args.report, names, "--report")
}

/// QEMU's pace from an argument.
pub fn pace(words: &str) -> Result<Pace, String> {
    match words.parse::<u8>() {
        Ok(shift @ 0..=10) => Ok(Pace::Counted { shift }),
        _ if words == "off" => Ok(Pace::Free),
        _ => Err("allowed is 0 to 10, or off".to_owned()),
    }
}

/// Runs the command.
pub fn run(args: Args) -> ExitCode {
    let stop = match stop_flag() {
        Ok(stop) => stop,
        Err(error) => return bad_input(&format!("no signals: {error}")),
    };
    if args.live {
        return live(&args, &stop);
    }
    let mut folder = match folder(&args, &demo::FILES) {
        Ok(folder) => folder,
        Err(error) => return bad_input(&error),
    };
    let Args { firmware, seconds, icount, physics, .. } = args;
    let mut out = std::io::stdout();
    let terminal = out.is_terminal();
    let physics = physics.physics();
    let options = Options { firmware, seconds, pace: icount, physics, terminal };
    match demo::run(&options, &mut folder, &mut out, &stop) {
        Ok(summary) if summary.faults.is_empty() => ExitCode::SUCCESS,
        Ok(_) => ExitCode::from(UNTRUSTWORTHY),
        Err(error) => bad_input(&error),
    }
}

#[cfg(not(feature = "web"))]
fn live(_: &Args, _: &AtomicBool) -> ExitCode {
    bad_input(&"--live: this program was built without `web`; `cargo xtask demo --live` builds it with it")
}

#[cfg(feature = "web")]
fn live(args: &Args, stop: &AtomicBool) -> ExitCode {
    let mut folder = match folder(args, &[demo::LOG]) {
        Ok(folder) => folder,
        Err(error) => return bad_input(&error),
    };
    let ready = |url: &str| {
        // Whoever does not read the address can still open the page.
        let _ = put_out(&format!("live page   {url}\n            Ctrl-C ends the demonstration\n"));
        fre_gripper::web::open_browser(url);
    };
    match demo::live(&args.firmware, &mut folder, args.icount, args.physics.physics(), args.listen, stop, ready) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => bad_input(&error),
    }
}
