//! `fre monitor`: what a gripper tells, as lines of text.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};

use messages::{PROTOCOL_VERSION, Report};

use super::{BAD_INPUT, bad_input};
use crate::link::{Address, Link, LinkError, Told};

/// How long a gripper may tell nothing before that is said.
const SILENCE: Duration = Duration::from_secs(2);

/// Show what a gripper estimates, a line per report, and what happens to it.
///
/// Columns: the gripper's time, motor angle and goal, force on the object (magnitude, x, y in the world frame), torque
/// demanded of the motor, the servo's current, status and its age in ticks. A force whose status is not converged,
/// tracking, snapped or no-contact is an old one.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Where the gripper is: unix:PATH, tcp:HOST:PORT, or a serial port as PORT or PORT@BAUD
    #[arg(long, value_name = "LINK")]
    link: Address,
    /// Ends after this time [default: when the link closes]
    #[arg(long, value_name = "S")]
    seconds: Option<f64>,
    /// Shows every N-th report
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(1..))]
    every: u32,
    /// Writes every report to a CSV file
    #[arg(long, value_name = "FILE")]
    log: Option<PathBuf>,
}

/// Runs the command.
pub fn run(args: &Args) -> ExitCode {
    match watch(args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(Stop::Input(message)) => bad_input(&message),
        // Whoever reads the lines has read enough.
        Err(Stop::Output(error)) if error.kind() == std::io::ErrorKind::BrokenPipe => ExitCode::SUCCESS,
        Err(Stop::Output(error)) => {
            eprintln!("fre: cannot write: {error}");
            ExitCode::from(BAD_INPUT)
        }
    }
}

/// Why there are no more lines.
enum Stop {
    Input(String),
    Output(std::io::Error),
}

impl From<std::io::Error> for Stop {
    fn from(error: std::io::Error) -> Self {
        Self::Output(error)
    }
}

impl From<LinkError> for Stop {
    fn from(error: LinkError) -> Self {
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
    let mut log = args.log.as_deref().map(Log::create).transpose()?;
    let link = Link::open(&args.link)?;
    let version = link.version()?;
    let mut out = std::io::stdout().lock();
    writeln!(out, "gripper {} on {}, protocol {}", version.firmware, version.board, version.protocol)?;
    if version.protocol != PROTOCOL_VERSION {
        writeln!(out, "this program speaks protocol {PROTOCOL_VERSION}: what follows may be incomplete")?;
    }
    writeln!(out, "   time_s  angle_deg   goal_deg  force_n     fx_n     fy_n  torque_nmm  current_ma  status")?;
    let told = link.listen();
    let start = Instant::now();
    let mut reports = 0_u64;
    let closed = loop {
        let left = length.map(|length| length.saturating_sub(start.elapsed()));
        if left == Some(Duration::ZERO) {
            break false;
        }
        match told.recv_timeout(left.map_or(SILENCE, |left| left.min(SILENCE))) {
            Ok(Told::Report(report)) => {
                reports += 1;
                if let Some(log) = &mut log {
                    log.write(&report)?;
                }
                if report.sequence.is_multiple_of(args.every) {
                    writeln!(out, "{}", line(&report))?;
                }
            }
            Ok(Told::Event(notice)) => {
                writeln!(out, "{:9.3}  * {}", notice.time_us as f64 * 1e-6, notice.event)?;
            }
            Ok(Told::Grasp(_) | Told::Shape(_) | Told::Setup(_)) => {}
            Err(RecvTimeoutError::Timeout) if left.is_none_or(|left| left > SILENCE) => {
                writeln!(out, "           * nothing for {} s", SILENCE.as_secs())?;
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break true,
        }
        out.flush()?;
    };
    let statistics = link.statistics();
    let rate = reports as f64 / start.elapsed().as_secs_f64();
    writeln!(
        out,
        "{reports} reports, {rate:.0} a second; {} missing, {} frames damaged{}",
        statistics.missing_reports,
        statistics.damaged,
        if closed { "; the link was closed" } else { "" }
    )?;
    if let Some(log) = log {
        log.finish()?;
    }
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

/// Every report, a row each.
struct Log {
    file: BufWriter<File>,
}

impl Log {
    fn create(path: &Path) -> Result<Self, Stop> {
        let file = File::create(path).map_err(|error| Stop::Input(format!("{}: {error}", path.display())))?;
        let mut file = BufWriter::new(file);
        writeln!(
            file,
            "sequence,time_us,motor_angle_deg,goal_deg,position_counts,current_ma,status,age,force_x_n,force_y_n,\
             contact_x_mm,contact_y_mm,contact_extent_mm,torque_nmm,distance_mm,iterations,residual_nmm,cost,finger,phase,\
             force_x_per_deg_n,force_y_per_deg_n,standard_deviation_n,sensitivity_age"
        )?;
        Ok(Self { file })
    }

    fn write(&mut self, report: &Report) -> std::io::Result<()> {
        let Report { sequence, finger, phase, time_us, estimate, goal, position, current, cost } = report;
        let (angle, goal) = (estimate.motor_angle.to_degrees(), goal.to_degrees());
        let ([fx, fy], [cx, cy]) = (estimate.force, estimate.contact_centre);
        writeln!(
            self.file,
            "{sequence},{time_us},{angle},{goal},{position},{current},{},{},{fx},{fy},{cx},{cy},{},{},{},{},{},{cost},{finger},{},\
             {},{},{},{}",
            estimate.status,
            estimate.age,
            estimate.contact_extent,
            estimate.torque,
            estimate.distance,
            estimate.iterations,
            estimate.residual,
            phase.word(),
            // Per degree: a radian's worth times π/180.
            estimate.force_per_angle[0].to_radians(),
            estimate.force_per_angle[1].to_radians(),
            estimate.standard_deviation,
            estimate.sensitivity_age
        )
    }

    fn finish(mut self) -> std::io::Result<()> {
        self.file.flush()
    }
}
