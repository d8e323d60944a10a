//! `fre monitor`: what a gripper, or the estimator on this PC, tells.

use std::io::Write;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};

use messages::{PROTOCOL_VERSION, Report};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

use super::keep::KeepArgs;
use super::source::SourceArgs;
use super::{BAD_INPUT, bad_input};
use crate::link::Statistics;
use crate::source::{Origin, Source, Told, WAITING};

/// How long a gripper may tell nothing before that is said.
const SILENCE: Duration = Duration::from_secs(2);
/// How often is looked whether somebody has stopped it.
const GLANCE: Duration = Duration::from_millis(100);

/// Show what a gripper estimates, a line per report, and what happens to it.
///
/// Columns: the gripper's time, motor angle and goal, force on the object (magnitude, x, y in the world frame), torque
/// demanded of the motor, the servo's current, status and its age in ticks. A force whose status is not converged,
/// tracking, snapped or no-contact is an old one.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    source: SourceArgs,
    /// Ends after this time [default: when the link closes]
    #[arg(long, value_name = "S")]
    seconds: Option<f64>,
    /// Shows every N-th report
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(1..))]
    every: u32,
    #[command(flatten)]
    keep: KeepArgs,
}

/// Runs the command.
pub fn run(args: &Args) -> ExitCode {
    match watch(args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(stop) => exit(stop),
    }
}

/// Tells the person.
pub(super) fn exit(stop: Stop) -> ExitCode {
    match stop {
        Stop::Input(message) => bad_input(&message),
        // Whoever reads the lines has read enough.
        Stop::Output(error) if error.kind() == std::io::ErrorKind::BrokenPipe => ExitCode::SUCCESS,
        Stop::Output(error) => {
            eprintln!("fre: cannot write: {error}");
            ExitCode::from(BAD_INPUT)
        }
    }
}

/// Why there are no more lines.
pub(super) enum Stop {
    Input(String),
    Output(std::io::Error),
}

impl From<std::io::Error> for Stop {
    fn from(error: std::io::Error) -> Self {
        Self::Output(error)
    }
}

impl From<Box<dyn std::error::Error>> for Stop {
    fn from(error: Box<dyn std::error::Error>) -> Self {
        Self::Input(error.to_string())
    }
}

fn watch(args: &Args) -> Result<(), Stop> {
    let length = match args.seconds {
        Some(seconds) => Some(
            Duration::try_from_secs_f64(seconds)
                .map_err(|_| Stop::Input(format!("--seconds is {seconds}; allowed is 0 and more")))?,
        ),
        None => None,
    };
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM, SIGHUP] {
        signal_hook::flag::register(signal, stop.clone())?;
    }
    let source = args.source.open()?;
    let keeping = args.keep.start(&source)?;
    let result = lines(&source, length, args.every, &stop);
    // What was kept is whole whatever became of the lines.
    let kept = keeping.finish()?;
    result?;
    for line in kept {
        println!("{line}");
    }
    Ok(())
}

/// Lines of text until the time is over, somebody stops it, or nothing more comes.
pub(super) fn lines(
    source: &Arc<dyn Source>,
    length: Option<Duration>,
    every: u32,
    stop: &AtomicBool,
) -> Result<(), Stop> {
    let setup = source.setup().map_err(|error| Stop::Input(error.to_string()))?;
    let mut out = std::io::stdout().lock();
    match setup.origin {
        Origin::Gripper => writeln!(out, "gripper {} on {}, protocol {}", setup.firmware, setup.board, setup.protocol)?,
        Origin::Bus => writeln!(out, "servos on {}, estimated on this PC", setup.place)?,
        Origin::Recording => writeln!(out, "recording {}", setup.place)?,
    }
    if setup.protocol != PROTOCOL_VERSION {
        writeln!(out, "this program speaks protocol {PROTOCOL_VERSION}: what follows may be incomplete")?;
    }
    writeln!(out, "   time_s  angle_deg   goal_deg  force_n     fx_n     fy_n  torque_nmm  current_ma  status")?;
    let told = source.hear(WAITING);
    let start = Instant::now();
    let mut heard = start;
    let mut reports = 0_u64;
    let closed = loop {
        let left = length.map(|length| length.saturating_sub(start.elapsed()));
        if left == Some(Duration::ZERO) || stop.load(Ordering::Relaxed) {
            break false;
        }
        match told.recv_timeout(left.map_or(GLANCE, |left| left.min(GLANCE))) {
            Ok(Told::Report(report)) => {
                heard = Instant::now();
                reports += 1;
                if report.sequence.is_multiple_of(every) {
                    writeln!(out, "{}", line(&report))?;
                }
            }
            Ok(Told::Event(notice)) => {
                writeln!(out, "{:9.3}  * {}", notice.time_us as f64 * 1e-6, notice.event)?;
            }
            Ok(Told::Grasp(_) | Told::Shape(_) | Told::Setup(_)) => {}
            Err(RecvTimeoutError::Timeout) if heard.elapsed() > SILENCE => {
                heard = Instant::now();
                writeln!(out, "           * nothing for {} s", SILENCE.as_secs())?;
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break true,
        }
        out.flush()?;
    };
    let Statistics { missing_reports, damaged, .. } = source.statistics();
    let rate = reports as f64 / start.elapsed().as_secs_f64();
    let words = match setup.origin {
        Origin::Bus => "questions unanswered",
        Origin::Gripper | Origin::Recording => "frames damaged",
    };
    let end = match (closed, setup.origin) {
        (false, _) => "",
        (true, Origin::Gripper) => "; the link was closed",
        (true, Origin::Bus) => "; the port is gone",
        (true, Origin::Recording) => "; the recording is over",
    };
    writeln!(out, "{reports} reports, {rate:.0} a second; {missing_reports} missing, {damaged} {words}{end}")?;
    Ok(())
}

fn line(report: &Report) -> String {
    let Report { estimate, .. } = report;
    let [fx, fy] = estimate.force;
    let age = if estimate.age > 0 { format!(" ({} ticks old)", estimate.age) } else { String::new() };
    format!(
        "{:9.3}  {:9.3}  {:9.3}  {:7.3}  {fx:7.3}  {fy:7.3}  {:10.1}  {:10.1}  {}{age}",
        report.time_us as f64 * 1e-6,
        estimate.motor_angle.to_degrees(),
        report.goal.to_degrees(),
        estimate.force_magnitude(),
        estimate.torque,
        report.current,
        estimate.status,
    )
}
