//! `fre gripper`: what a gripper's page can do, for scripts.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use clap::Subcommand;
use messages::{
    CarryTo, Event, Finger, Gravity, GripMargin, GripTo, Heed, Heeds, Notice, Object, Phase, Report, Which,
};
use model_core::discretise::Discretisation;
use model_core::uncertainty::Uncertainty;

use super::{along, commission, identify};
use crate::environment::{self, LINK};
use crate::exit::{bad_input, trusted};
use crate::options::PhysicsWord;
use crate::output::put_out;
use crate::standard;
use fre::case::{Case, CaseError, object_keys};
use fre::drive::fits_finger;
use fre_gripper::link::{Address, Link, LinkError, Told, alive, pairs, set};

/// Query a gripper, change its settings, and make it grip.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Where the gripper is [env: FRE_LINK]
    ///
    /// unix:PATH, tcp:HOST:PORT, or a serial port as PORT or PORT@BAUD.
    #[arg(short, long, value_name = "LINK", global = true, required = false)]
    link: Option<Address>,
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// Firmware, last start and counters
    Info,
    /// Settings as KEY = VALUE, fingers and objects
    Get,
    /// Change settings by KEY=VALUE, and give a finger the design and object of a case
    Set {
        /// What to change; `get` shows the keys
        #[arg(value_name = "KEY=VALUE", required_unless_present = "case")]
        pairs: Vec<String>,
        /// Takes finger and object from a case file
        #[arg(long, value_name = "CASE.toml")]
        case: Option<PathBuf>,
        /// The finger that the case is for
        #[arg(long, value_name = "N", default_value_t = 0, requires = "case")]
        finger: u8,
        /// How the finger is modelled
        #[arg(long, value_enum, default_value = "extended", requires = "case")]
        physics: PhysicsWord,
        /// Only places the case's object, and stores nothing
        ///
        /// For objects that change often: every stored value wears the gripper's flash.
        #[arg(long, requires = "case", conflicts_with_all = ["pairs", "physics"])]
        object_only: bool,
    },
    /// Close until a force is reached, and hold it
    ///
    /// With --hold-mass-kg all fingers close until together they bear a weight by their friction, and press no harder than that takes.
    Grip {
        /// Force of each finger on the object, N
        ///
        /// With --hold-mass-kg its greatest force; the default is then the settings' limit.
        #[arg(long, value_name = "N", required_unless_present = "hold_mass_kg")]
        force_n: Option<f32>,
        /// Mass of the object that the grip is to bear
        #[arg(long, value_name = "KG", requires = "gravity_deg", conflicts_with = "which")]
        hold_mass_kg: Option<f32>,
        /// Where its weight pulls, or `normal`: across the fingers' plane
        ///
        /// Degrees from x of the gripper frame, counter-clockwise.
        #[arg(long, value_name = "DEG|normal", requires = "hold_mass_kg", conflicts_with = "which", value_parser = gravity, allow_hyphen_values = true)]
        gravity_deg: Option<Gravity>,
        /// How many times the weight the grip is to bear before the object slips
        #[arg(long, value_name = "FACTOR", default_value_t = 2.0, requires = "hold_mass_kg", conflicts_with = "which")]
        safety: f32,
        /// Greatest speed [default: the settings' own]
        #[arg(long, value_name = "DEG/S")]
        speed_deg_per_s: Option<f32>,
        /// Motor angle beyond which no finger closes [default: the settings' range]
        #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
        limit_deg: Option<f32>,
        #[command(flatten)]
        which: Fingers,
        /// Waits for the force at most this long; exit status 2 if it is not reached
        #[arg(long, value_name = "S")]
        wait: Option<f64>,
    },
    Identify(identify::Args),
    Run(along::Args),
    Commission(commission::Args),
    /// Open
    Release(Fingers),
    /// Stop, and stay there
    #[command(visible_alias = "stop")]
    Hold(Fingers),
    /// Switch the torque off: the fingers yield and let go
    ///
    /// The next motion switches it on again.
    Relax(Fingers),
    /// Search the bus for servos at every baud rate
    ///
    /// This takes some seconds. No finger may grip, and estimates are stale meanwhile.
    Scan,
}

#[derive(Clone, Copy, Debug, clap::Args)]
struct Fingers {
    /// One finger only, from 0 [default: all]
    #[arg(long = "finger", value_name = "N", id = "which")]
    finger: Option<u8>,
}

impl Fingers {
    fn which(self) -> Which {
        self.finger.map_or(Which::All, Which::One)
    }
}

/// Runs the command.
pub fn run(args: &Args) -> ExitCode {
    let address = match environment::or_else(args.link.as_ref(), LINK) {
        Ok(Some(address)) => address,
        Ok(None) => return bad_input(&"needed is --link LINK, or FRE_LINK in the environment: where the gripper is"),
        Err(error) => return bad_input(&error),
    };
    match act(&address, &args.action) {
        Ok(code) => code,
        Err(error) => bad_input(&error),
    }
}

fn act(address: &Address, action: &Action) -> Result<ExitCode, Box<dyn std::error::Error>> {
    let link = Link::open(address)?;
    match action {
        Action::Info => put_out(&info(&link)?)?,
        Action::Get => put_out(&get(&link)?)?,
        Action::Set { pairs: _, case: Some(path), finger, physics: _, object_only: true } => {
            link.place_object(*finger, object(&standard::case(path)?))?;
        }
        Action::Set { pairs, case, finger, physics, .. } => {
            // Nothing is sent of what does not fit together.
            let case = case.as_ref().map(|path| Ok::<_, CaseError>((standard::name(path), standard::case(path)?)));
            let case = case.transpose()?;
            let mut settings = link.settings()?;
            pairs.iter().try_for_each(|pair| set(&mut settings, pair))?;
            let mount = settings.fingers.get(usize::from(*finger)).copied().flatten();
            if let (Some((name, case)), Some(mount)) = (&case, mount) {
                let fits = fits_finger(&case.path.motion, &mount.drive, usize::from(*finger));
                fits.map_err(|why| format!("{name}: {why}"))?;
            }
            if !pairs.is_empty() {
                link.set_settings(&settings)?;
            }
            if let Some((_, case)) = case {
                let how = Discretisation::estimator(physics.physics());
                let object = object(&case);
                let design = Finger::elastic(case.finger.design, how).relaxing(&case.finger.prony);
                link.set_finger(*finger, &design)?;
                link.set_object(*finger, object)?;
            }
        }
        Action::Grip { force_n, hold_mass_kg, gravity_deg, safety, speed_deg_per_s, limit_deg, which, wait } => {
            let told = link.listen();
            let (speed, limit) = (speed_deg_per_s.map(f32::to_radians), limit_deg.map(f32::to_radians));
            let weight = hold_mass_kg.map(|mass| mass * G);
            match (weight, gravity_deg, force_n) {
                (Some(weight), Some(gravity), force) => {
                    let (gravity, safety, force) = (*gravity, *safety, *force);
                    link.carry(&CarryTo { weight, gravity, safety, force, speed, limit })?;
                }
                (_, _, Some(force)) => link.grip(&GripTo { fingers: which.which(), force: *force, speed, limit })?,
                _ => return Err("needed is --force-n, or --hold-mass-kg with --gravity-deg".into()),
            }
            if let Some(seconds) = wait {
                let count = link.settings()?.count();
                let longest = Duration::try_from_secs_f64(*seconds).map_err(|_| "--wait: not a time")?;
                // What was told before says nothing about this grip.
                let since_us = link.counters()?.uptime_us;
                return alive(&link, || wait_for(&told, which.which(), count, since_us, longest, weight));
            }
        }
        Action::Identify(args) => return identify::run(&link, args),
        Action::Run(args) => return along::run(&link, args),
        Action::Commission(args) => return commission::run(&link, args),
        Action::Release(which) => return heeded(&link.open_fingers(which.which())?),
        Action::Hold(which) => return heeded(&link.hold(which.which())?),
        Action::Relax(which) => return heeded(&link.relax(which.which())?),
        Action::Scan => return scan(&link),
    }
    Ok(ExitCode::SUCCESS)
}

/// A case's object with its friction.
fn object(case: &Case) -> Object {
    Object { design: case.object, friction: case.friction }
}

/// What each finger has made of an order. Exit status 2: not every one obeys.
fn heeded(heeds: &Heeds) -> Result<ExitCode, Box<dyn std::error::Error>> {
    let mut all = true;
    for (number, heed) in heeds.iter().enumerate().filter_map(|(number, heed)| Some((number, (*heed)?))) {
        all &= heed == Heed::Done;
        let words = if heed == Heed::Done { "done" } else { "not done: its servo does not answer" };
        put_out(&format!("finger {number}  {words}\n"))?;
    }
    Ok(trusted(all))
}

/// How long a search may take: three quarters of a second a rate, and as long again for a slow link.
const SCAN: Duration = Duration::from_secs(15);

fn scan(link: &Link) -> Result<ExitCode, Box<dyn std::error::Error>> {
    let told = link.listen();
    link.scan()?;
    let end = Instant::now() + SCAN;
    loop {
        match told.recv_timeout(end.saturating_duration_since(Instant::now())) {
            Ok(Told::Event(Notice { event: event @ Event::DeviceFound { .. }, .. })) => {
                put_out(&format!("{event}\n"))?;
            }
            Ok(Told::Event(Notice { event: event @ Event::ScanDone { .. }, .. })) => {
                put_out(&format!("{event}\n"))?;
                return Ok(ExitCode::SUCCESS);
            }
            Ok(_) => {}
            Err(_) => return Err(format!("the search has not ended within {} s", SCAN.as_secs()).into()),
        }
    }
}

fn info(link: &Link) -> Result<String, LinkError> {
    let mut text = String::new();
    let version = link.version()?;
    let _ = writeln!(text, "board            {}", version.board);
    let _ = writeln!(text, "firmware         {}, protocol {}", version.firmware, version.protocol);
    let _ = writeln!(text, "room for         {} fingers of up to {} lamellae", version.fingers, version.lists.lamellae);
    let boot = link.boot()?;
    let _ = writeln!(text, "started because  {}", boot.cause.words());
    if let Some(words) = boot.last_words {
        let _ = writeln!(text, "last words       {words}");
    }
    let counters = link.counters()?;
    let _ = writeln!(text, "running for      {:.1} s", counters.uptime_us as f64 * 1e-6);
    let _ = writeln!(text, "ticks            {}, {} of them late", counters.ticks, counters.late_ticks);
    let _ = writeln!(text, "rate             {:.1} Hz, {:.1} meant", counters.rate_hz, counters.chosen_hz);
    let _ = writeln!(text, "estimates        {}", counters.estimates);
    let us = |ticks: u32| f64::from(ticks) * 1e6 / f64::from(version.cost_hz.max(1));
    let _ = writeln!(
        text,
        "latency          {:.0} µs from the servo's last byte to the report, {:.0} µs at most",
        us(counters.latency),
        us(counters.latency_most)
    );
    if counters.answer > 0 {
        let _ = writeln!(
            text,
            "answers          {:.0} µs from another master's question until one is ready, {:.0} µs at most, {} after the return delay",
            us(counters.answer),
            us(counters.answer_most),
            counters.late_answers
        );
    }
    let _ = writeln!(
        text,
        "dropped          {} reports, {} grasps, {} shapes, {} events",
        counters.dropped_reports, counters.dropped_grasps, counters.dropped_shapes, counters.dropped_events
    );
    let _ = writeln!(
        text,
        "bus              {} timeouts, {} damaged, {} refused, {} other faults, {} losses of a servo, {} of another master",
        counters.bus_timeouts,
        counters.bus_damaged,
        counters.bus_refused,
        counters.bus_other,
        counters.servo_losses,
        counters.bus_foreign
    );
    let _ = writeln!(text, "flash            {} records written so far", counters.flash_writes);
    let _ = writeln!(
        text,
        "link             {} frames, {} damaged, {} too large",
        counters.link_frames, counters.link_damaged, counters.link_oversize
    );
    Ok(text)
}

/// Standard deviations of the parameters behind the forces', and of so many terms of a material with memory.
fn deviations(given: &Uncertainty, terms: usize) -> String {
    let Uncertainty { zero_angle, backlash, youngs_modulus, centre: [x, y], radius, .. } = given;
    let (zero_deg, play_deg, percent) = (zero_angle.to_degrees(), backlash.to_degrees(), 100.0 * youngs_modulus);
    let together = if given.correlations.iter().any(|r| *r != 0.0) { ", correlated" } else { "" };
    let mut text = format!(
        "zero {zero_deg:.4}°, E {percent:.2} %, place ({x:.3}, {y:.3}) mm, radius {radius:.3} mm{together}; play {play_deg:.2}°"
    );
    let memory = given.memory.parts.iter().zip(&given.memory.times).take(terms);
    for (number, (part, time)) in (1..).zip(memory) {
        let _ = write!(text, "; g{number} {part:.4}, τ{number} {:.2} %", 100.0 * time);
    }
    text
}

fn get(link: &Link) -> Result<String, LinkError> {
    let mut text = String::new();
    let settings = link.settings()?;
    for (key, value) in pairs(&settings) {
        let _ = writeln!(text, "{key} = {value}");
    }
    for finger in 0..settings.count() as u8 {
        let known = link.finger(finger)?;
        let terms = known.as_ref().map_or(0, |finger| finger.prony.len());
        let design = known.map_or_else(
            || "no design".to_owned(),
            |finger| format!("{} lamellae", finger.design.lamellae.attachments.len()),
        );
        let object = link
            .object(finger)?
            .map_or_else(|| "no object".to_owned(), |Object { design, friction }| object_keys(&design, friction));
        let uncertainty = link.uncertainty(finger)?.map_or_else(
            || format!("not calibrated, taken as {}", deviations(&Uncertainty::DEFAULT, terms)),
            |uncertainty| format!("calibrated to {}", deviations(&uncertainty, terms)),
        );
        for words in [design, object, uncertainty] {
            let _ = writeln!(text, "# finger {finger}: {words}");
        }
    }
    Ok(text)
}

/// Standard gravity, m/s².
const G: f32 = 9.80665;

/// Where a weight pulls.
fn gravity(words: &str) -> Result<Gravity, String> {
    if words == "normal" {
        return Ok(Gravity::Across);
    }
    let degrees = words.parse::<f32>().ok().filter(|degrees| degrees.is_finite());
    degrees.map(|degrees| Gravity::Along(degrees.to_radians())).ok_or_else(|| {
        "allowed are a number of degrees, or `normal` where the weight pulls across the fingers' plane".to_owned()
    })
}

/// What a grip bears in a weight's direction.
fn bears(margin: &GripMargin, weight: f32) -> String {
    let bears = margin.carried.unwrap_or(0.0);
    format!("grip      bears {bears:.3} N where the weight pulls, {:.2} times the weight\n", bears / weight)
}

/// Waits until every finger meant has reached its force, or says what it does instead.
fn wait_for(
    told: &Receiver<Told>,
    which: Which,
    count: usize,
    since_us: u64,
    longest: Duration,
    weight: Option<f32>,
) -> Result<ExitCode, Box<dyn std::error::Error>> {
    let mut margin = None;
    let end = Instant::now() + longest;
    let mut last: Vec<Option<Report>> = vec![None; count];
    let reached = loop {
        match told.recv_timeout(end.saturating_duration_since(Instant::now())) {
            Ok(Told::Report(report)) if report.time_us > since_us => {
                if let Some(place) = last.get_mut(usize::from(report.finger)).filter(|_| which.is(report.finger.into()))
                {
                    *place = Some(report);
                }
            }
            Ok(Told::Grasp(grasp)) => {
                margin = grasp.margin.or(margin);
                continue;
            }
            Ok(_) => continue,
            Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => break false,
        }
        let meant = || (0..count).filter(|finger| which.is(*finger)).map(|finger| last[finger]);
        if meant().all(|report| report.is_some_and(|report| report.phase == Phase::Gripped)) {
            break true;
        }
        // Nothing more comes of a finger that has stopped.
        let stopped = |report: Report| {
            matches!(report.phase, Phase::Held(_) | Phase::Released(_) | Phase::Relaxed | Phase::Moving)
        };
        if meant().flatten().any(stopped) && meant().all(|report| report.is_some()) {
            let settled = meant().flatten().all(|report| report.phase == Phase::Gripped || stopped(report));
            if settled {
                break false;
            }
        }
    };
    for report in last.into_iter().flatten() {
        let (force, angle) = (report.estimate.force_magnitude(), report.estimate.motor_angle.to_degrees());
        let status = report.estimate.status;
        put_out(&format!("finger {}  {force:.3} N at {angle:.3}°  {status}  {}\n", report.finger, report.phase))?;
    }
    if let Some((margin, weight)) = margin.zip(weight) {
        put_out(&bears(&margin, weight))?;
    }
    Ok(trusted(reached))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_weight_pulls_in_a_direction_or_across_the_plane() {
        assert_eq!(gravity("normal"), Ok(Gravity::Across));
        assert_eq!(gravity("-90"), Ok(Gravity::Along(-std::f32::consts::FRAC_PI_2)));
        for words in ["down", "inf", ""] {
            assert!(gravity(words).is_err_and(|error| error.contains("`normal`")), "{words}");
        }
    }

    #[test]
    fn what_is_borne_is_compared_with_the_weight() {
        let margin = GripMargin {
            least: 1.0,
            direction: 0.0,
            across: 6.0,
            couple: 100.0,
            slips: Some(1),
            carried: Some(6.0),
            age: 0,
        };
        assert_eq!(bears(&margin, 2.5), "grip      bears 6.000 N where the weight pulls, 2.40 times the weight\n");
    }
}
