//! What a source reports, as lines of text.

use std::io::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};

use messages::{PROTOCOL_VERSION, Report};

use super::stop::Stop;
use fre_gripper::source::{Ended, Origin, Source, Statistics, Told, WAITING};

/// How long a gripper may be silent before the silence is reported.
const SILENCE: Duration = Duration::from_secs(2);
/// How often is looked whether somebody has stopped it.
const GLANCE: Duration = Duration::from_millis(100);

/// Lines of text until the time is over, somebody stops it, or nothing more comes.
pub fn show(source: &Arc<dyn Source>, length: Option<Duration>, every: u32, stop: &AtomicBool) -> Result<(), Stop> {
    let setup = source.setup()?;
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
    let ended = Ended { reports, after: start.elapsed(), closed };
    writeln!(out, "{}", ending(&ended, setup.origin, &source.statistics()))?;
    Ok(())
}

/// What it comes to.
pub fn ending(ended: &Ended, origin: Origin, statistics: &Statistics) -> String {
    let &Ended { reports, after, closed } = ended;
    let Statistics { missing_reports, damaged, .. } = statistics;
    let rate = reports as f64 / after.as_secs_f64().max(1e-3);
    let words = match origin {
        Origin::Bus => "questions unanswered",
        Origin::Gripper | Origin::Recording => "frames damaged",
    };
    let end = match (closed, origin) {
        (false, _) => "",
        (true, Origin::Gripper) => "; the link was closed",
        (true, Origin::Bus) => "; the port is gone",
        (true, Origin::Recording) => "; the recording is over",
    };
    format!("{reports} reports, {rate:.0} a second; {missing_reports} missing, {damaged} {words}{end}")
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
