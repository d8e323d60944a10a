//! What the current tells while the finger closes, in a time of its own: that something is met, known to the model or not,
//! and that the object is not as described.

use fre_gripper::servo::{Config, Truth};
use messages::{Close, CloseTo, Event, Mount, Report, SetFinger, SetObject, SetSettings, Settings, Which};
use model_core::object::ObjectDesign;
use system_tests::{Bench, Flash, OBJECT, finger, load_of};

const DEGREE: f32 = std::f32::consts::PI / 180.0;
const SECOND: u64 = 1_000_000;
/// A period at 500 Hz, µs.
const TICK: u64 = 2_000;
const MOUNT: Mount = Mount {
    open_angle: -DEGREE,
    backlash: 0.25 * DEGREE,
    range: [-0.05, 0.3],
    force_limit: 100.0,
    current_limit: 2000.0,
    ..Mount::DEFAULT
};
/// The rise of the torque that is a contact, N·mm, with four standard deviations of the noise on top.
const RISE: f64 = 45.0 + 4.0 * 5.0 * 1.79;
/// Ticks for which it has to last, and two on the way: the servo's answer and the link.
const DELAY: u32 = 3 + 2;

/// A finger that closes on one object while the model is told of another; what was true and told at every tick.
fn close(truth: ObjectDesign, told: ObjectDesign, speed: f32, seed: u64) -> (Bench, Vec<(Report, Truth)>, Option<u32>) {
    let servo = Config {
        baud_rate: 1_000_000,
        backlash_deg: 0.25,
        start_deg: Some(-1.0),
        noise_ma: 5.0,
        seed,
        load: load_of(truth, 12.0),
        ..Config::default()
    };
    let mut bench = Bench::new(servo, &Flash::new());
    bench.ask::<SetSettings>(&Settings::of(MOUNT)).unwrap();
    bench.ask::<SetFinger>(&messages::For { finger: 0, what: finger() }).unwrap();
    bench.ask::<SetObject>(&messages::For { finger: 0, what: told.into() }).unwrap();
    bench.until("sound estimate", 5 * SECOND, |report| report.estimate.status.is_trustworthy());
    // From well before any contact: what a free motion takes has to be learnt.
    bench.ask::<Close>(&CloseTo { fingers: Which::All, angle: -0.04, speed: Some(0.2) }).unwrap();
    bench.run(SECOND);
    let from = bench.reports.len();
    bench.events.clear();
    bench.ask::<Close>(&CloseTo { fingers: Which::All, angle: 9.0 * DEGREE, speed: Some(speed) }).unwrap();
    let mut at = None;
    for tick in 0..1500 {
        bench.run(TICK);
        if at.is_none() && bench.events.iter().any(|event| matches!(event, Event::Touched { .. })) {
            at = Some(tick);
        }
    }
    let seen = bench.reports.split_off(from);
    (bench, seen, at)
}

/// First contact is told within the stated delay behind the rise of the torque, never before it, and with its angle.
#[test]
fn first_contact_is_told_in_time() {
    for (speed, seed) in [(0.1, 1), (0.2, 2), (0.35, 3), (0.6, 4)] {
        let (bench, seen, at) = close(OBJECT, OBJECT, speed, seed);
        let at = at.expect("a contact");
        let first = |least: f64| seen.iter().position(|(_, truth)| truth.torque > least).unwrap() as u32;
        let (touched, risen) = (first(0.0), first(RISE));
        let angles: Vec<f32> = bench
            .events
            .iter()
            .filter_map(|event| match event {
                Event::Touched { angle, .. } => Some(*angle),
                _ => None,
            })
            .collect();
        let true_angle = seen[touched as usize].1.motor_angle;
        eprintln!(
            "{speed} rad/s: touched in tick {touched}, torque risen in {risen}, told in {at}: {:?} rad, truly {true_angle:.4}",
            angles
        );
        assert!(at >= touched && at <= risen + DELAY, "touched {touched}, risen {risen}, told {at}");
        let [angle] = angles.as_slice() else { panic!("told {} times", angles.len()) };
        assert!(f64::from(*angle) >= true_angle - 0.005, "{angle} before {true_angle}");
        assert!(f64::from(*angle) <= seen[risen as usize].1.motor_angle + 0.005, "{angle}");
        // As described: the torques agree.
        assert!(!bench.events.iter().any(|event| matches!(event, Event::TorquesDisagree { .. })), "{:?}", bench.events);
    }
}

/// Something that the model does not know of is met all the same, and soon the torques are told to disagree.
#[test]
fn an_object_that_is_not_as_described_is_told() {
    let far = ObjectDesign::Circle { centre: [75.0, 45.0], radius: 40.0 };
    let (bench, seen, at) = close(ObjectDesign::Circle { centre: [41.0, 56.0], radius: 40.0 }, far, 0.2, 5);
    assert!(seen.iter().all(|(report, _)| report.estimate.force == [0.0; 2]), "the model knows of no contact");
    assert!(at.is_some(), "a contact");
    let told = bench.events.iter().find_map(|event| match event {
        Event::TorquesDisagree { disagree, demanded, .. } => Some((*disagree, *demanded)),
        _ => None,
    });
    assert_eq!(told, Some((true, 0.0)), "{:?}", bench.events);
}

/// A free motion, to and fro, meets nothing.
#[test]
fn a_free_motion_meets_nothing() {
    let far = ObjectDesign::Circle { centre: [95.0, 45.0], radius: 40.0 };
    for speed in [0.05, 0.35] {
        let (bench, _, at) = close(far, far, speed, 6);
        assert_eq!(at, None, "{:?}", bench.events);
    }
}
