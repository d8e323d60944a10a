//! The main job, shown: the firmware in QEMU estimates the contact force from the angle of a simulated servo, beside the
//! full-resolution model on this PC.
//!
//! [`run()`] boots the gripper ([`Machine`]), leads its finger ([`Lead`]) to an object and back, hands every estimate's
//! angle to the references ([`Reference`]), shows both while they come ([`Live`]), and ends with a table ([`Summary`])
//! and a folder with pictures and data (the report).

mod error;
mod lead;
mod live;
mod machine;
#[cfg(feature = "web")]
mod page;
mod pictures;
mod reference;
mod report;
mod sample;
mod summary;

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use messages::{Counters, Mount, Report, Settings, Version, Which};
use model_core::design::Design;
use model_core::discretise::{Discretisation, Physics, Scheme};
use model_core::drive::Drive;
use model_core::object::ObjectDesign;
use model_core::status::Status;

use crate::link::{Link, Told};
use crate::servo::{Clock, Config, Gains, Load, OnBranch, Servo};
use crate::source::Statistics;
use fre::case::preset;
use fre::files::Folder;
use fre::metrics::along;
use fre::shape::{Contact, Shape};
use fre::study::model::{self, physics_word};

pub use error::DemoError;
pub use fre_qemu::Pace;
pub use lead::{CLOSED_DEG, Lead, OPEN_DEG, Order};
pub use live::Live;
pub use machine::Machine;
#[cfg(feature = "web")]
pub use page::live;
pub use reference::{Answer, Followed, Reference};
pub use report::{FILES, write as write_report};
pub use sample::{FLOOR_N, REFERENCES, Sample, Way};
pub use summary::{Difference, Summary};

/// The finger.
const PRESET: &str = "ladder-80";
/// Ø80 at Mid height, world frame, mm.
const OBJECT: ObjectDesign = ObjectDesign::Circle { centre: CENTRE, radius: RADIUS };
/// Its centre, mm.
const CENTRE: [f64; 2] = [41.0, 45.0];
/// Its radius, mm.
const RADIUS: f64 = 40.0;
/// The servo's table reaches so far beyond the closed finger, degrees.
const MARGIN_DEG: f64 = 3.0;
/// Ticks per shape: QEMU takes every byte of the link by itself, so that shapes cost more than estimates.
const SHAPE_EVERY: u16 = 50;
/// How long the first estimate may take, and any later one.
const FIRST: Duration = Duration::from_secs(20);
const SILENCE: Duration = Duration::from_secs(5);
/// How long the references may take for what is left to do at the end.
const REST: Duration = Duration::from_secs(30);
/// How often is looked whether there is something to do.
const GLANCE: Duration = Duration::from_millis(20);
/// Name of the firmware's log (defmt frames) in the report's folder.
pub const LOG: &str = "firmware.defmt";
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

/// All that was seen.
pub struct Seen {
    /// The finger.
    pub design: Design,
    /// Physics of the target and both references.
    pub physics: Physics,
    /// The gripper.
    pub version: Version,
    /// How QEMU's time passed.
    pub pace: Pace,
    /// Every report, in order.
    pub samples: Vec<Sample>,
    /// The trustworthy shape with the greatest force.
    pub shape: Option<messages::Shape>,
    /// Shapes that came.
    pub shapes: u64,
    /// Time from the first report to the last, s, by this PC's clock.
    pub wall_s: f64,
    /// Whole closings and openings.
    pub cycles: u32,
    /// The gripper's counters at the beginning and at the end.
    pub counters: [Counters; 2],
    /// The link's.
    pub link: [Statistics; 2],
    /// Bytes lost on the bus.
    pub lost_on_bus: u64,
    /// What the references leave, in the order of [`REFERENCES`].
    pub followed: [Followed; 2],
    /// Samples that a reference had no room or no time for.
    pub left_out: [u64; 2],
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

/// A gripper that knows its finger and its object, and whose first estimate has come.
struct Booted {
    machine: Machine,
    link: Link,
    heard: Heard,
    version: Version,
    design: Design,
    servo: Config,
    /// Force of the closed finger, N.
    hardest: f64,
}

/// Boots the firmware with a servo on its bus; `log` takes its log.
fn boot(
    firmware: &Path,
    log: File,
    pace: Pace,
    physics: Physics,
    shape_every: u16,
    stop: &AtomicBool,
) -> Result<Booted, DemoError> {
    let design = preset(PRESET).ok_or(DemoError::Preset(PRESET))??.design;
    let truth = model::Options { discretisation: Discretisation::full(Scheme::Paper, physics), ..Load::REFERENCE };
    let load = Arc::new(Load::of(&design, OBJECT, &Drive::Rotating, &truth, CLOSED_DEG + MARGIN_DEG)?);
    let [x, y] = load.at(CLOSED_DEG.to_radians(), &mut OnBranch::default()).force;
    let servo = Config {
        baud_rate: 1_000_000,
        return_delay_us: 0,
        clock: Clock::Wall,
        start_deg: Some(OPEN_DEG),
        noise_ma: 3.0,
        gains: Gains::GREATEST,
        load,
        ..Config::default()
    };
    let (mut machine, link) = Machine::boot(firmware, Servo::new(servo.clone())?, log, pace, stop)?;
    let mut heard = Heard { told: link.listen(), last: Instant::now() };
    let version = link.version().map_err(|error| machine.blame(error))?;
    let finger = messages::Finger { design: design.clone(), how: Discretisation::estimator(physics) };
    let mount = Mount { open_angle: OPEN_DEG.to_radians() as f32, ..Mount::DEFAULT };
    let settings = Settings { shape_every, ..Settings::of(mount) };
    let told = link
        .set_finger(0, &finger)
        .and_then(|()| link.set_object(0, OBJECT))
        .and_then(|()| link.set_settings(&settings));
    told.map_err(|error| machine.blame(error))?;
    heard.until_ready(&mut machine, stop)?;
    Ok(Booted { machine, link, heard, version, design, servo, hardest: x.hypot(y) })
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

/// The gripper's words as they come.
struct Heard {
    told: Receiver<Told>,
    last: Instant,
}

impl Heard {
    /// The next one, or none after a short while.
    fn next(&mut self, machine: &mut Machine) -> Result<Option<Told>, DemoError> {
        match self.told.recv_timeout(GLANCE) {
            Ok(told) => {
                self.last = Instant::now();
                Ok(Some(told))
            }
            Err(RecvTimeoutError::Timeout) => {
                machine.check()?;
                if self.last.elapsed() > SILENCE {
                    return Err(machine.timeout("report from the gripper", SILENCE));
                }
                Ok(None)
            }
            Err(RecvTimeoutError::Disconnected) => {
                // QEMU's end closes its sockets a little before it can be seen.
                std::thread::sleep(10 * GLANCE);
                Err(machine.timeout("report from the gripper: the link is closed", self.last.elapsed()))
            }
        }
    }

    /// What came before does not count.
    fn forget(&mut self) {
        self.told.try_iter().for_each(drop);
        self.last = Instant::now();
    }

    /// Waits for a trustworthy estimate.
    fn until_ready(&mut self, machine: &mut Machine, stop: &AtomicBool) -> Result<(), DemoError> {
        let end = Instant::now() + FIRST;
        while Instant::now() < end {
            if stop.load(Ordering::Relaxed) {
                return Err(DemoError::Stopped);
            }
            if let Some(Told::Report(Report { estimate, .. })) = self.next(machine)?
                && estimate.status.is_trustworthy()
            {
                return Ok(());
            }
        }
        Err(machine.timeout("trustworthy estimate", FIRST))
    }
}

/// What was told, with what the references say to it.
struct Log {
    servo: Config,
    samples: Vec<Sample>,
    /// The trustworthy shape with the greatest force, and that force.
    shape: Option<(messages::Shape, f64)>,
    shapes: u64,
    /// Samples up to here have both answers, or will have none.
    answered: usize,
}

impl Log {
    fn new(servo: Config) -> Self {
        Self { servo, samples: Vec::new(), shape: None, shapes: 0, answered: 0 }
    }

    fn take(&mut self, told: Told, references: &mut [Reference; 2]) {
        match told {
            Told::Report(report) => self.report(report, references),
            Told::Shape(shape) => {
                self.shapes += 1;
                let (mut x, mut y) = (0.0, 0.0);
                shape.contacts.iter().for_each(|contact| (x, y) = (x + contact.force[0], y + contact.force[1]));
                let force = f64::from(x.hypot(y));
                if shape.status.is_trustworthy() && self.shape.as_ref().is_none_or(|(_, best)| force > *best) {
                    self.shape = Some((*shape, force));
                }
            }
            // They are in the firmware's log.
            Told::Event(_) | Told::Grasp(_) | Told::Setup(_) => {}
        }
    }

    fn report(&mut self, report: Report, references: &mut [Reference; 2]) {
        let angle = self.servo.angle(f64::from(report.position));
        let last = self.samples.last();
        let before = last.map_or((Way::Closing, 1), |last| (last.way, last.cycle));
        let moved = last.map_or(0, |last| report.position - last.report.position);
        let (way, cycle) = match before {
            (Way::Opening, cycle) if moved > 0 => (Way::Closing, cycle + 1),
            (Way::Closing, cycle) if moved < 0 => (Way::Opening, cycle),
            same => same,
        };
        let first_us = self.samples.first().map_or(report.time_us, |first| first.report.time_us);
        let index = self.samples.len();
        self.samples.push(Sample {
            report,
            time_s: report.time_us.saturating_sub(first_us) as f64 * 1e-6,
            angle_deg: angle.to_degrees(),
            way,
            cycle,
            references: [None; 2],
        });
        // A stale report has no angle of its own.
        if report.estimate.status != Status::Stale {
            references.iter_mut().for_each(|reference| reference.ask(index, report.position, angle));
        }
    }

    fn answer(&mut self, which: usize, answer: Answer) {
        if let Some(sample) = self.samples.get_mut(answer.index) {
            sample.references[which] = answer.force;
        }
    }

    /// The latest sample with both answers; if there is none for a while, the latest one.
    fn answered(&mut self, now: f64) -> Option<&Sample> {
        let both = |sample: &Sample| sample.references.iter().all(Option::is_some);
        let fresh = self.samples[self.answered..].iter().rposition(both);
        if let Some(fresh) = fresh {
            self.answered += fresh;
        }
        match fresh {
            Some(_) => self.samples.get(self.answered),
            // The references take a moment to begin.
            None => self.samples.last().filter(|_| now > 1.0),
        }
    }

    fn unanswered(&self, which: usize) -> u64 {
        self.samples.iter().filter(|sample| sample.is_fresh() && sample.references[which].is_none()).count() as u64
    }
}

impl Seen {
    /// The target's shape with the greatest force, the trapezoid reference's at the same angle, and that angle, rad.
    fn shape_beside_reference(&self) -> Option<(Shape, &Shape, f64)> {
        let told = self.shape.as_ref()?;
        let report = self.samples.iter().find(|sample| sample.report.sequence == told.sequence)?.report;
        let reference = self.followed[0].shapes.get(&report.position)?;
        Some((shape_of(told), reference, f64::from(told.motor_angle)))
    }
}

/// A gripper's shape as pictures take it. It does not have arc lengths: those are taken along the polyline, to its nearest point.
fn shape_of(told: &messages::Shape) -> Shape {
    let double = |point: &[f32; 2]| point.map(f64::from);
    let front: Vec<[f64; 2]> = told.front.iter().map(double).collect();
    let contact = |contact: &messages::Contact| {
        let [x, y] = double(&contact.force);
        let force = x.hypot(y);
        let length = force.max(f64::MIN_POSITIVE);
        Contact {
            arc: along(double(&contact.position), &front).unwrap_or(0.0),
            position: double(&contact.position),
            normal: [-x / length, -y / length],
            force,
        }
    };
    let contacts = told.contacts.iter().map(contact).collect();
    let lamellae = told.lamella_front.iter().zip(&told.lamella_back).map(|(a, b)| [double(a), double(b)]).collect();
    Shape { back: told.back.iter().map(double).collect(), lamellae, contacts, front }
}
