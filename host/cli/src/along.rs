//! `fre gripper run`: moves a finger along a planned motion and writes down where its motor was.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use fre::delimited;
use fre::files::Files;
use fre::fit::calibrate::Plan;
use fre::spreadsheet;
use fre_gripper::link::{Link, LinkError, Told, alive};
use fre_gripper::source::{Order, OrderError, Source as _};
use messages::{Phase, Report, Which};
use model_core::status::Status;

use crate::exit::{INTERRUPTED, UNTRUSTWORTHY, tell};
use crate::output::{ForceArgs, reads};
use crate::progress::ProgressLine;
use crate::signals::stop_flag;
use crate::standard::{self, Target};

/// Move a finger along a planned motion, and record it
///
/// `fre calibrate --plan` writes the motion; a spreadsheet may have saved it with semicolons and decimal commas. The finger goes to the motion's first angle, rests there for --after seconds, and then follows
/// the times. The table has a row per reading: the time, the motor's angle and current, and what the gripper makes of its force. Add a column
/// force_n with what you have measured at these times, and give it to `fre calibrate`.
///
/// Exit status: 0 the whole motion was made; 2 the finger stopped before its end; 130 you have stopped the command (Ctrl-C), and the finger
/// holds. The rows until there are written.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The motion: columns time_s and motor_angle_deg
    #[arg(value_name = "MOTION.csv")]
    motion: PathBuf,
    /// Writes the table; - for standard output
    #[arg(short, long, value_name = "FILE.csv", default_value = "-")]
    csv: PathBuf,
    /// The finger that moves, from 0
    #[arg(long, value_name = "N", default_value_t = 0)]
    finger: u8,
    /// Seconds at the first angle before the motion begins
    #[arg(long, value_name = "S", default_value_t = 3.0)]
    after: f64,
    #[command(flatten)]
    force: ForceArgs,
}

/// Columns of the table.
const COLUMNS: [&str; 6] = ["time_s", "motor_angle_deg", "current_ma", "estimate_n", "standard_deviation_n", "status"];
/// Nearer than this to the first angle the finger is there, rad: a loaded motor stays behind.
const THERE: f32 = 0.01;
/// How long it may take to the first angle.
const PATIENCE: Duration = Duration::from_secs(30);
/// Reports stop for longer than this only if something is wrong.
const SILENCE: Duration = Duration::from_secs(2);
/// How often is looked whether to stop.
const GLANCE: Duration = Duration::from_millis(50);

type Failure = Box<dyn std::error::Error>;

/// Runs the command.
pub fn run(link: &Link, args: &Args) -> Result<ExitCode, Failure> {
    let mut files: Files = args.force.files();
    reads(&mut files, &args.motion, "the motion")?;
    let name = standard::name(&args.motion);
    let text = spreadsheet::decoded(&standard::bytes(&args.motion)?);
    let out = Target::of(&mut files, &args.csv, "--csv")?;
    let mount = link.settings()?.fingers.get(usize::from(args.finger)).copied().flatten();
    let mount = mount.ok_or_else(|| format!("--finger {}: the gripper has no such finger", args.finger))?;
    // A range in degrees is stored in radians, of single precision.
    let [least, most] = mount.range.map(|end| (f64::from(end.to_degrees()) * 1e3).round() * 1e-3);
    let plan = Plan::parse(&name, &text, least..=most)?;
    let after = Duration::try_from_secs_f64(args.after).map_err(|_| "--after: not a time")?;

    let stop = stop_flag()?;
    let finger = Finger { link, number: args.finger, told: link.listen(), stop: &stop };
    let (mut rows, mut line) = (Vec::new(), ProgressLine::new(false));
    let made = alive(link, || {
        finger.begin(&plan, after)?;
        finger.follow(&plan, &mut rows, &mut line)
    });
    // Before the table, which may take its time.
    let held = if let Err(Stop::Asked) = made { finger.hold() } else { Ok(()) };
    line.wipe();
    // What was read until something failed is kept.
    if made.is_ok() || !rows.is_empty() {
        let lines = rows.iter().map(delimited::line);
        out.write((delimited::line(COLUMNS) + &lines.collect::<String>()).as_bytes())?;
    }
    let (number, readings) = (args.finger, format!("{} of {} readings", rows.len(), plan.places.len()));
    match (made, held) {
        (Ok(()), _) => Ok(ExitCode::SUCCESS),
        (Err(Stop::Finger(phase)), _) => {
            tell!("fre: finger {number} is {phase}: {readings}");
            Ok(ExitCode::from(UNTRUSTWORTHY))
        }
        (Err(Stop::Asked), Ok(())) => {
            tell!("fre: stopped; finger {number} holds: {readings}");
            Ok(ExitCode::from(INTERRUPTED))
        }
        (Err(Stop::Asked), Err(error)) => {
            Err(format!("stopped, but finger {number} may go on: {error}: {readings}").into())
        }
        (Err(Stop::Failed(error)), _) => Err(format!("{error}: {readings}").into()),
    }
}

/// Why a motion has ended before its end.
enum Stop {
    /// This program is asked to stop.
    Asked,
    /// The finger does something else.
    Finger(Phase),
    /// The gripper does not answer, or refuses.
    Failed(String),
}

impl From<LinkError> for Stop {
    fn from(error: LinkError) -> Self {
        Self::Failed(error.to_string())
    }
}

/// The finger that moves.
struct Finger<'a> {
    link: &'a Link,
    number: u8,
    told: Receiver<Told>,
    stop: &'a AtomicBool,
}

impl Finger<'_> {
    /// The finger's next report.
    fn next(&self) -> Result<Report, Stop> {
        let end = Instant::now() + SILENCE;
        while !self.stop.load(Ordering::Acquire) {
            match self.told.recv_timeout(GLANCE) {
                Ok(Told::Report(report)) if report.finger == self.number => return Ok(report),
                Ok(_) | Err(RecvTimeoutError::Timeout) if Instant::now() < end => {}
                _ => return Err(Stop::Failed("no report comes from the gripper any more".to_owned())),
            }
        }
        Err(Stop::Asked)
    }

    fn hold(&self) -> Result<(), OrderError> {
        self.link.order(&Order::Hold(Which::One(self.number)))
    }

    fn close(&self, angle_deg: f64, speed_deg_per_s: Option<f64>) -> Result<(), LinkError> {
        let speed = speed_deg_per_s.map(|speed| speed.to_radians() as f32);
        self.link.close(Which::One(self.number), angle_deg.to_radians() as f32, speed)
    }

    /// Goes to the first angle and rests there.
    fn begin(&self, plan: &Plan, rest: Duration) -> Result<(), Stop> {
        let [_, first_deg] = plan.places[0];
        self.close(first_deg, None)?;
        let (target, end) = (first_deg.to_radians() as f32, Instant::now() + PATIENCE);
        loop {
            let report = self.next()?;
            let is_there = (report.goal - target).abs() < 1e-4 && (report.estimate.motor_angle - target).abs() < THERE;
            if report.phase == Phase::Moving && is_there {
                break;
            }
            if Instant::now() > end {
                return Err(Stop::Failed(format!(
                    "finger {} does not reach the first angle, {first_deg}°",
                    self.number
                )));
            }
        }
        let end = Instant::now() + rest;
        while Instant::now() < end {
            self.next()?;
        }
        Ok(())
    }

    /// Follows the motion's times by the gripper's clock, a row per reading.
    fn follow(&self, plan: &Plan, rows: &mut Vec<[String; 6]>, line: &mut ProgressLine) -> Result<(), Stop> {
        let begin_us = self.next()?.time_us;
        let first_s = plan.places[0][0];
        let since = |report: &Report| first_s + report.time_us.saturating_sub(begin_us) as f64 * 1e-6;
        let moves = plan.moves();
        let mut ahead = moves.iter().peekable();
        for place in &plan.places {
            loop {
                let report = self.next()?;
                let now_s = since(&report);
                if report.phase != Phase::Moving {
                    return Err(Stop::Finger(report.phase));
                }
                if let Some([begin, end]) = ahead.next_if(|[begin, _]| begin[0] <= now_s) {
                    let way = end[1] - begin[1];
                    if way != 0.0 {
                        // What the beginning was late for is made up for on the way.
                        self.close(end[1], Some(way.abs() / (end[0] - now_s).max(1e-3)))?;
                    }
                }
                // A report whose position is old waits for the next one; its row has its own time.
                if now_s >= place[0] && report.estimate.status != Status::Stale {
                    rows.push(row(now_s, &report));
                    line.show(false, || format!("{now_s:.0} s of {:.0} s", plan.length_s()));
                    break;
                }
            }
        }
        Ok(())
    }
}

fn row(time_s: f64, report: &Report) -> [String; 6] {
    let estimate = &report.estimate;
    let trusted = estimate.status.is_trustworthy() && estimate.age == 0;
    let known = |number: f32| if trusted && number.is_finite() { format!("{number:.4}") } else { String::new() };
    [
        format!("{time_s:.4}"),
        format!("{:.4}", estimate.motor_angle.to_degrees()),
        format!("{:.1}", report.current),
        known(estimate.force_magnitude()),
        known(estimate.standard_deviation),
        estimate.status.word().to_owned(),
    ]
}
