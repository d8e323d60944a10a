//! `fre monitor`: what a gripper, or the estimator on this PC, reports.

use std::process::ExitCode;
use std::time::Duration;

use crate::keep::KeepArgs;
use crate::output::put_out;
use crate::signals::stop_flag;
use crate::source::SourceArgs;
use crate::view::{Stop, ViewArgs};
use fre_gripper::link::Ends;

/// Show the forces of a gripper (--link) or of servos on this PC's own bus (--bus)
///
/// They are shown on a page in the browser (--web), live in the terminal (in a build with `--features terminal`), or as one
/// line per report if the output is not a terminal (or with --lines). Without --link or --bus, the serial ports of this
/// machine are listed.
///
/// Columns of the lines: the gripper's time, motor angle and goal, force on the object (magnitude, x, y in the world frame),
/// torque demanded of the motor, the servo's current, status and its age in ticks. A force whose status is not converged,
/// tracking, snapped or no-contact is out of date.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    source: SourceArgs,
    /// Stops after this time
    ///
    /// Without it, lines stop when the link closes, and a live view waits for the gripper to come back.
    #[arg(long, value_name = "S")]
    seconds: Option<f64>,
    #[command(flatten)]
    view: ViewArgs,
    #[command(flatten)]
    keep: KeepArgs,
}

/// Runs the command.
pub fn run(args: &Args) -> ExitCode {
    watch(args).map_or_else(Stop::exit, |()| ExitCode::SUCCESS)
}

fn watch(args: &Args) -> Result<(), Stop> {
    let length = match args.seconds {
        Some(seconds) => Some(
            Duration::try_from_secs_f64(seconds)
                .map_err(|_| Stop::Input(format!("--seconds is {seconds}; allowed is 0 and more")))?,
        ),
        None => None,
    };
    let stop = stop_flag()?;
    let mut files = args.keep.files();
    args.source.reads(&mut files)?;
    let kept = args.keep.claim(&mut files)?;
    // Lines end with the gripper; who watches waits for it to come back.
    let ends = if args.view.is_live() { Ends::WithItsUser } else { Ends::WithTheGripper };
    let source = args.source.open(ends)?;
    let keeping = kept.start(&source, &stop)?;
    let result = args.view.show(&source, length, &stop);
    // What was kept is whole whatever became of the view.
    let kept = keeping.finish().map_err(Stop::Input)?;
    result?;
    put_out(&kept.concat()).map_err(Stop::Input)
}
