//! The demonstration from beginning to end.

use std::fs::File;
use std::io::Write;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use messages::{Version, Which};
use model_core::discretise::{Discretisation, Physics, Scheme};

use super::boot::{Booted, boot};
use super::error::DemoError;
use super::lead::{CLOSED_DEG, Lead, OPEN_DEG, Order};
use super::live::Live;
use super::log::Log;
use super::reference::Reference;
use super::report::write as write_report;
use super::seen::Seen;
use super::summary::Summary;
use super::task::{CENTRE, LOG, OBJECT, PRESET, RADIUS};
use fre::files::Folder;
use fre::study::model::physics_word;
use fre_qemu::Pace;

/// Ticks per shape: QEMU takes every byte of the link by itself, so that shapes cost more than estimates.
const SHAPE_EVERY: u16 = 50;
/// How long the references may take for what is left to do at the end.
const REST: Duration = Duration::from_secs(30);
/// Least and greatest duration, s.
const SECONDS: [f64; 2] = [4.0, 600.0];

/// What to show.
#[derive(Clone, Debug)]
pub struct Options {
    /// The firmware's ELF for QEMU.
    pub firmware: PathBuf,
    /// How long, s.
    pub seconds: f64,
    /// How QEMU's time passes.
    pub pace: Pace,
    /// Physics of the servo's load, the target and both references.
    pub physics: Physics,
    /// Whether a person looks on: more lines.
    pub terminal: bool,
}

/// Shows it.
///
/// # Errors
/// Whatever keeps the gripper, a reference or the report from working. What they do wrong is in the summary.
pub fn run(
    options: &Options,
    folder: &mut Folder,
    out: &mut dyn Write,
    stop: &AtomicBool,
) -> Result<Summary, DemoError> {
    if !(SECONDS[0]..=SECONDS[1]).contains(&options.seconds) {
        return Err(DemoError::Seconds(options.seconds));
    }
    let log = folder.stream(LOG)?;
    let seen = watch(options, log, out, stop)?;
    let summary = Summary::of(&seen);
    let files = write_report(folder, &seen, &summary)?;
    let mut end = || -> std::io::Result<()> {
        write!(out, "\n{}", summary.text())?;
        writeln!(out, "\nreport      {}", files.join("\n            "))?;
        out.flush()
    };
    end().map_err(DemoError::Output)?;
    Ok(summary)
}

/// Boots, leads and listens.
fn watch(options: &Options, log: File, out: &mut dyn Write, stop: &AtomicBool) -> Result<Seen, DemoError> {
    let physics = options.physics;
    let booted = boot(&options.firmware, log, options.pace, physics, SHAPE_EVERY, stop)?;
    let Booted { mut machine, link, mut heard, version, design, servo, hardest } = booted;

    let from = OPEN_DEG.to_radians();
    let mut references = [
        Reference::spawn(&Discretisation::full(Scheme::Trapezoid, physics), &design, OBJECT, from)?,
        Reference::spawn(&Discretisation::full(Scheme::Paper, physics), &design, OBJECT, from)?,
    ];
    let mut lead = Lead::new(options.seconds);
    introduce(out, options, &version, &lead).map_err(DemoError::Output)?;
    let mut live = Live::new(options.terminal, options.pace, version.cost_hz, hardest);
    let mut log = Log::new(servo);
    let counters = link.counters().map_err(|error| machine.blame(error))?;
    let statistics = link.statistics();
    heard.forget();
    let start = Instant::now();
    let mut shown = 0;
    let wall_s = loop {
        let now = start.elapsed().as_secs_f64();
        // A slow PC gets some more time for its first closing and opening, not for ever.
        let over = now >= options.seconds && (lead.is_round() || now >= 2.0 * options.seconds);
        if over || stop.load(Ordering::Relaxed) {
            break now;
        }
        if let Some(told) = heard.next(&mut machine)? {
            log.take(told, &mut references);
        }
        for (which, reference) in references.iter().enumerate() {
            reference.answers().for_each(|answer| log.answer(which, answer));
        }
        if let Some(last) = log.samples.last()
            && let Some(Order { angle_deg, speed_deg }) = lead.step(now, f64::from(last.report.goal).to_degrees())
        {
            let closing = link.close(Which::All, angle_deg.to_radians() as f32, Some(speed_deg.to_radians() as f32));
            closing.map_err(|error| machine.blame(error))?;
        }
        if now * live.rate() >= f64::from(shown)
            && let Some(sample) = log.answered(now)
        {
            live.show(out, now, sample).map_err(DemoError::Output)?;
            shown = (now * live.rate()) as u32 + 1;
        }
    };
    let counters = [counters, link.counters().map_err(|error| machine.blame(error))?];
    let statistics = [statistics, link.statistics()];
    let lost_on_bus = machine.lost_on_bus();
    drop((link, machine));

    let mut left_out = references.each_ref().map(|reference| reference.left_out);
    let mut which = 0;
    let followed = references.map(|reference| {
        let (followed, whole) = reference.finish(REST, |answer| log.answer(which, answer));
        if !whole {
            left_out[which] += log.unanswered(which);
        }
        which += 1;
        followed
    });
    Ok(Seen {
        design,
        physics,
        version,
        pace: options.pace,
        shape: log.shape.map(|(shape, _)| shape),
        shapes: log.shapes,
        samples: log.samples,
        wall_s,
        cycles: lead.cycles(),
        counters,
        link: statistics,
        lost_on_bus,
        followed,
        left_out,
    })
}

fn introduce(out: &mut dyn Write, options: &Options, version: &Version, lead: &Lead) -> std::io::Result<()> {
    let cycles = match lead.planned() {
        1 => "once".to_owned(),
        more => format!("{more} times"),
    };
    let time = match options.pace {
        Pace::Free => "as fast as it can".to_owned(),
        Pace::Counted { shift } | Pace::CountedWithoutWaiting { shift } => {
            format!("counting instructions of {} ns", 1_u32 << shift.min(31))
        }
    };
    writeln!(out, "target      {}, firmware {} in QEMU, {time}", version.board, version.firmware)?;
    let physics = physics_word(options.physics);
    writeln!(out, "            model simpson 17/1 in single precision, 500 estimates per second wanted")?;
    writeln!(out, "physics     {physics}, of the target, the references and the servo's load")?;
    writeln!(
        out,
        "finger      {PRESET}, on a simulated XM430-W350-T (Dynamixel Protocol 2.0, 1 Mbaud, 0.088° per count)"
    )?;
    writeln!(out, "object      cylinder Ø{} mm at ({}, {}) mm", 2.0 * RADIUS, CENTRE[0], CENTRE[1])?;
    writeln!(out, "motion      {OPEN_DEG}° … {CLOSED_DEG}° … {OPEN_DEG}°, {cycles}, {:.1}°/s", lead.speed_deg())?;
    writeln!(out, "references  trapezoid and paper 170/20 in double precision on this PC, at the same quantised angle")
}
