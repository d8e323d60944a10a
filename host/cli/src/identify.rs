//! `fre gripper identify`: closes a finger on a round object and says how high it is, or how large.

use std::process::ExitCode;
use std::time::{Duration, Instant};

use clap::ValueEnum;
use messages::{Event, Mount, Object, Phase, Which, Why};
use model_core::identify::{IdentifyError, Unknown};
use model_core::object::ObjectDesign;

use crate::exit::UNTRUSTWORTHY;
use crate::output::put_out;
use fre_gripper::identify::{Error, Found, Motion, open_angle};
use fre_gripper::link::{Link, Told, alive};

/// Close on a round object, and find its height or radius from the motor
///
/// The object is the one that `set --case` gave. What is unknown of it follows from the motor's angle and current during the
/// motion.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The unknown of the circle
    #[arg(value_enum)]
    unknown: Word,
    /// Range in which it is searched
    #[arg(long, value_name = "LEAST:MOST", value_parser = range, allow_hyphen_values = true)]
    range_mm: [f64; 2],
    /// The finger that closes, from 0
    #[arg(long, value_name = "N", default_value_t = 0)]
    finger: u8,
    /// Largest motor angle to which it closes
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    to_deg: f32,
    /// Speed of the motion
    #[arg(long, value_name = "DEG/S", default_value_t = 5.0)]
    speed_deg_per_s: f32,
    /// Longest time of a motion
    #[arg(long, value_name = "S", default_value_t = 30.0)]
    wait: f64,
    /// Sets the object that was found
    #[arg(long)]
    set: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Word {
    /// The y coordinate of its centre
    Height,
    /// Its radius, about the centre that is set
    Radius,
    /// Its radius; its side towards the finger stays where it is
    RadiusBehindSide,
}

impl From<Word> for Unknown {
    fn from(word: Word) -> Self {
        match word {
            Word::Height => Self::Height,
            Word::Radius => Self::Radius,
            Word::RadiusBehindSide => Self::RadiusBehindSide,
        }
    }
}

fn range(text: &str) -> Result<[f64; 2], String> {
    let number = |text: &str| text.parse::<f64>().ok().filter(|value| value.is_finite());
    let ends = text.split_once(':').and_then(|(least, most)| Some([number(least)?, number(most)?]));
    ends.filter(|[least, most]| least < most).ok_or_else(|| "allowed is LEAST:MOST in mm, LEAST < MOST".to_owned())
}

/// Runs the command.
pub fn run(link: &Link, args: &Args) -> Result<ExitCode, Box<dyn std::error::Error>> {
    let finger = args.finger;
    let settings = link.settings()?;
    let mount = settings.fingers.get(usize::from(finger)).copied().flatten();
    let mount = mount.ok_or_else(|| format!("--finger {finger}: the gripper has no such finger"))?;
    let design =
        link.finger(finger)?.ok_or_else(|| format!("finger {finger} has no design: `set --case` gives one"))?;
    let object =
        link.object(finger)?.ok_or_else(|| format!("finger {finger} has no object: `set --case` gives one"))?;
    let Object { design: object, friction } = object;
    if !matches!(object, ObjectDesign::Circle { .. }) {
        return Err(IdentifyError::NotACircle.into());
    }
    if friction != 0.0 {
        return Err(
            format!("finger {finger}: friction is {friction}; `identify` is without friction: allowed is 0").into()
        );
    }
    if !design.prony.is_empty() {
        return Err(format!(
            "finger {finger}: its material has memory; `identify` is without: allowed is an elastic finger"
        )
        .into());
    }
    let [least, most] = mount.range.map(f32::to_degrees);
    if !(least..=most).contains(&args.to_deg) {
        let [least, most] = mount.range.map(fre::drive::degrees);
        return Err(format!("--to-deg {}: the finger's range is {least} to {most}", args.to_deg).into());
    }
    let patience = Duration::try_from_secs_f64(args.wait).map_err(|_| "--wait: not a time")?;
    let open = open_angle(&design, &mount, object, args.unknown.into(), args.range_mm)?;
    if let Some(open) = open.filter(|open| f64::from(mount.open_angle) > *open) {
        return Err(room(finger, &mount, open.to_degrees()).into());
    }

    let motion = alive(link, || {
        link.open_fingers(Which::One(finger))?;
        go(link, &mount, finger, mount.open_angle, &OPENING, patience)?;
        link.close(Which::One(finger), args.to_deg.to_radians(), Some(args.speed_deg_per_s.to_radians()))?;
        go(link, &mount, finger, args.to_deg.to_radians(), &CLOSING, patience)
    })?;
    match motion.identify(&design, &mount, object, args.unknown.into(), args.range_mm) {
        Ok(found) => {
            put_out(&words(args.unknown, &found))?;
            if args.set {
                link.set_object(finger, found.object)?;
            }
            Ok(ExitCode::SUCCESS)
        }
        Err(error @ Error::Unidentified(IdentifyError::Range(_))) => Err(error.into()),
        Err(error) => {
            let advice = match error {
                Error::NoFreeWay { open_deg, .. } => format!("; {}", room(finger, &mount, open_deg)),
                _ => String::new(),
            };
            put_out(&format!("{} positions seen; {error}{advice}\n", motion.positions()))?;
            Ok(ExitCode::from(UNTRUSTWORTHY))
        }
    }
}

/// That a finger does not open far enough, and what to set.
fn room(finger: u8, mount: &Mount, open_deg: f64) -> String {
    let [is, least] = [mount.open_angle, mount.range[0]].map(f32::to_degrees);
    // Downwards, to what the sentence says.
    let open_deg = (open_deg * 10.0).floor() / 10.0;
    let range = if open_deg < f64::from(least) {
        format!(" (and finger.{finger}.least_deg, which is {least:.1})")
    } else {
        String::new()
    };
    format!(
        "finger.{finger}.open_deg is {is:.1}: before the contact the motor's friction has to be seen on a free way; \
         set finger.{finger}.open_deg={open_deg:.1} or less{range}"
    )
}

/// What was found.
fn words(unknown: Word, found: &Found) -> String {
    let Found { identified, free, .. } = found;
    let name = match unknown {
        Word::Height => "height",
        Word::Radius | Word::RadiusBehindSide => "radius",
    };
    format!(
        "{name:<16} {:.2} mm, standard deviation {:.2} mm\n\
         measurements     {} in contact, misfit {:.2}\n\
         friction         {free:.0} N·mm on the free way, {:+.0} N·mm under load\n",
        identified.value, identified.standard_deviation, identified.touching, identified.misfit, identified.offset
    )
}

/// Phases of a finger that opens.
const OPENING: [Phase; 1] = [Phase::Released(Why::Asked)];
/// Phases of one that closes: it moves, or the object has stopped it. An object that is not where the gripper has it may spoil the estimate.
const CLOSING: [Phase; 5] = [
    Phase::Moving,
    Phase::Held(Why::Stall),
    Phase::Held(Why::Current),
    Phase::Held(Why::Force),
    Phase::Held(Why::Estimate),
];

/// Follows a motion until the finger is there, or no longer moves. In any other phase than these it does something else, and that is an error.
fn go(
    link: &Link,
    mount: &Mount,
    finger: u8,
    target: f32,
    phases: &[Phase],
    patience: Duration,
) -> Result<Motion, Box<dyn std::error::Error>> {
    // Nearer than this it is there: a loaded motor stays behind.
    const THERE: f64 = 0.01;
    /// Reports without a new position after which it counts as standing.
    const STANDS: u32 = 200;
    let (told, end) = (link.listen(), Instant::now() + patience);
    let calibration = messages::Calibration::new(&mount.gear());
    let mut motion = Motion::default();
    let (mut stand, mut still) = (None, 0);
    loop {
        let left = end.saturating_duration_since(Instant::now());
        match told.recv_timeout(left) {
            Ok(Told::Report(report)) if report.finger == finger => {
                motion.see(&report, mount);
                // A motor that stands may waver by a count.
                if stand.is_some_and(|stand: i32| stand.abs_diff(report.position) <= 1) {
                    still += 1;
                } else {
                    (stand, still) = (Some(report.position), 0);
                }
                let is_led = (report.goal - target).abs() < 1e-4;
                let is_there = (calibration.angle(report.position) - f64::from(target)).abs() < THERE;
                let is_held = matches!(report.phase, Phase::Held(_));
                let is_meant = phases.contains(&report.phase);
                // Not at once: a report may be older than the order.
                if still > STANDS / 4 && !is_meant {
                    return Err(format!("finger {finger} did not finish its motion; it is {}", report.phase).into());
                }
                if still > STANDS / 4 && (is_held || (is_led && (is_there || still > STANDS))) {
                    return Ok(motion);
                }
            }
            Ok(Told::Event(notice)) => match notice.event {
                Event::Touched { finger: which, angle } if which == finger => motion.touch(f64::from(angle)),
                Event::ServoLost { finger: which, .. } if which == finger => return Err("the servo was lost".into()),
                _ => {}
            },
            Ok(_) => {}
            Err(_) => {
                return Err(format!("--wait {}: the motion did not end in this time", patience.as_secs_f64()).into());
            }
        }
    }
}
