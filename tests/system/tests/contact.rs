//! What the current tells while the finger closes, in a time of its own: that something is met, known to the model or not,
//! and that the object is not as described.

use fre_gripper::servo::{Config, Truth};
use messages::{
    Close, CloseTo, Event, For, GetServo, Grip, GripTo, Mount, Open, Phase, Refusal, Report, SetFinger, SetObject,
    SetSettings, Settings, Which,
};
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

/// Force of the finger on its object, N.
fn force(bench: &Bench) -> f64 {
    let [x, y] = bench.servo.truth().force;
    x.hypot(y)
}

/// A gripper with a force limit of 3 N, on an object that is where `told` says or not.
fn limited(current_fence: bool, told: ObjectDesign, flash: &Flash) -> Bench {
    let servo = Config {
        baud_rate: 1_000_000,
        backlash_deg: 0.25,
        start_deg: Some(-1.0),
        load: load_of(OBJECT, 17.0),
        ..Config::default()
    };
    let mut bench = Bench::new(servo, flash);
    bench.ask::<SetSettings>(&Settings::of(Mount { force_limit: 3.0, current_fence, ..MOUNT })).unwrap();
    bench.ask::<SetFinger>(&For { finger: 0, what: finger() }).unwrap();
    bench.ask::<SetObject>(&For { finger: 0, what: told.into() }).unwrap();
    bench.until("sound estimate", 5 * SECOND, |report| report.estimate.status.is_trustworthy());
    let setup = bench.ask::<GetServo>(&0).unwrap();
    assert_eq!(setup.operating_mode, if current_fence { 5 } else { 3 });
    bench
}

/// The object is 20 mm nearer than the gripper believes, so that its estimate has no force to limit. The servo's own current control does:
/// to the force limit at the finger's far end, which is more of it at the contact.
#[test]
fn a_fence_limits_what_the_estimate_does_not_see() {
    let ObjectDesign::Circle { centre: [x, y], radius } = OBJECT else { panic!("a circle") };
    let far = ObjectDesign::Circle { centre: [x + 20.0, y], radius };
    let [unfenced, fenced] = [false, true].map(|current_fence| {
        let mut bench = limited(current_fence, far, &Flash::new());
        bench.ask::<Close>(&CloseTo { fingers: Which::All, angle: 15.0 * DEGREE, speed: Some(0.1) }).unwrap();
        bench.run(5 * SECOND);
        let last = bench.reports.last().unwrap().0;
        assert!(last.estimate.status.is_trustworthy() && last.estimate.force == [0.0; 2], "{last:?}");
        let found = (force(&bench), bench.servo.truth().torque);
        assert!(!bench.events.iter().any(|event| matches!(event, Event::ServoAlert { .. })), "{:?}", bench.events);
        bench.ask::<Open>(&Which::All).unwrap();
        bench.run(3 * SECOND);
        assert_eq!(force(&bench), 0.0, "it opens");
        found
    });
    let design = finger().design;
    let reach = |point: [f64; 2]| (point[0] - design.motor_axis[0]).hypot(point[1] - design.motor_axis[1]);
    let lever = fenced.1 / fenced.0;
    let most = 3.0 * reach(design.front.tip) / lever;
    eprintln!("{unfenced:?}, with the fence {fenced:?}: {lever:.1} mm of {:.1} mm", reach(design.front.tip));
    // One unit of current is 0.07 N there.
    assert!(fenced.0 <= most + 0.1, "{} N, at most {most} N", fenced.0);
    assert!(fenced.0 > 0.95 * most - 0.1, "{} N, nearly {most} N", fenced.0);
    assert!(unfenced.0 > 1.5 * most, "{} N without", unfenced.0);
}

/// It does not keep a finger from its force limit, and a restart of the microcontroller keeps the force. It is chosen with the servo.
#[test]
fn a_fenced_finger_grips_with_all_of_its_force() {
    let flash = Flash::new();
    let mut bench = limited(true, OBJECT, &flash);
    bench.ask::<Grip>(&GripTo { fingers: Which::All, force: 3.0, speed: Some(0.1), limit: None }).unwrap();
    bench.until("grip", 10 * SECOND, |report| report.phase == Phase::Gripped);
    bench.run(SECOND);
    let gripped = force(&bench);
    assert!((gripped - 3.0).abs() < 0.2, "{gripped} N");
    bench.restart(&flash);
    bench.run(SECOND);
    let last = bench.reports.last().unwrap().0;
    assert!(matches!(last.phase, Phase::Held(_)), "{last:?}");
    assert!(force(&bench) > 0.95 * gripped, "{} N of {gripped} N", force(&bench));
    let servo = bench.ask::<GetServo>(&0);
    let mount = Mount { force_limit: 3.0, servo, ..MOUNT };
    assert_eq!(bench.ask::<SetSettings>(&Settings::of(mount)), Err(Refusal::Fence));
    assert_eq!(bench.ask::<SetSettings>(&Settings::of(Mount { current_fence: true, ..mount })), Ok(()));
}
