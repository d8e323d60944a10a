//! Statuses and ages as `diagnostic_msgs/DiagnosticStatus`.

use messages::{Phase, Report};
use model_core::status::Status;

use crate::message::{DiagnosticStatus, KeyValue, Level};
use crate::wrench::{self, is_trusted};

/// What a finger's diagnostics have beside its newest report.
#[derive(Clone, Debug)]
pub struct Circumstances<'a> {
    /// Which finger, from 0.
    pub finger: u8,
    /// Which gripper, bus or file.
    pub hardware: &'a str,
    /// s since the last trustworthy force; infinite before the first one.
    pub age: f64,
    /// s since the newest report, whatever its status.
    pub silence: f64,
    /// Reports missing so far.
    pub missing: u64,
    /// The last event, in words.
    pub event: &'a str,
}

/// Without a report for this long a finger is stale, s.
pub const SILENCE_S: f64 = 0.5;

/// Of a finger's newest report, if there was one.
pub fn status(report: Option<&Report>, about: &Circumstances<'_>) -> DiagnosticStatus {
    let silent = about.silence > SILENCE_S;
    let (level, message) = match report {
        None => (Level::Stale, "no report yet".to_owned()),
        Some(_) if silent => (Level::Stale, format!("nothing for {:.1} s", about.silence)),
        Some(report) => (level(report), words(report)),
    };
    let mut values = vec![
        ("age_s", format!("{:.3}", about.age)),
        ("silence_s", format!("{:.3}", about.silence)),
        ("missing_reports", about.missing.to_string()),
        ("last_event", about.event.to_owned()),
        ("wrench", wrench::DESCRIPTION.to_owned()),
    ];
    if let Some(report) = report {
        let estimate = &report.estimate;
        values.splice(
            0..0,
            [
                ("status", estimate.status.to_string()),
                ("trusted", (is_trusted(report) && !silent).to_string()),
                ("age_ticks", estimate.age.to_string()),
                ("phase", report.phase.to_string()),
                ("motor_angle_deg", format!("{:.3}", estimate.motor_angle.to_degrees())),
                ("current_ma", format!("{:.1}", report.current)),
                ("sequence", report.sequence.to_string()),
            ],
        );
    }
    DiagnosticStatus {
        level: level as u8,
        name: format!("fre: finger {}", about.finger),
        message,
        hardware_id: about.hardware.to_owned(),
        values: values.into_iter().map(|(key, value)| KeyValue { key: key.to_owned(), value }).collect(),
    }
}

fn level(report: &Report) -> Level {
    match (report.estimate.status, report.phase) {
        (Status::Stale, _) => Level::Stale,
        _ if !is_trusted(report) => Level::Error,
        (_, Phase::Waiting(_)) => Level::Warn,
        _ => Level::Ok,
    }
}

fn words(report: &Report) -> String {
    match report.phase {
        Phase::Waiting(_) => format!("{}, {}", report.estimate.status, report.phase),
        _ => report.estimate.status.to_string(),
    }
}
