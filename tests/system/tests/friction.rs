//! Friction on the target: the firmware in QEMU, on a simulated servo whose finger rubs on the object in full resolution.

use std::sync::Arc;
use std::time::Duration;

use fre_gripper::link::{LinkError, Told};
use fre_gripper::servo::{Config, Load};
use fre_gripper::source::{Margins, Source};
use messages::{
    CarryTo, Gravity, GripMargin, Mount, Object, Phase, Refusal, Report, Settings, SettingsField, Side, Which, Why,
};
use model_core::drive::Drive;
use system_tests::{Machine, OBJECT, Watch, finger};

const FRICTION: f64 = 0.6;
const DEGREE: f32 = std::f32::consts::PI / 180.0;
const SECONDS: fn(u64) -> Duration = Duration::from_secs;
/// Open is at −1°; so slow that every estimate has its time.
const SETTINGS: Settings = Settings {
    rate_hz: 50,
    ..Settings::of(Mount { open_angle: -DEGREE, force_limit: 100.0, current_limit: 2000.0, ..Mount::DEFAULT })
};

fn rough() -> Object {
    Object { design: OBJECT, friction: FRICTION }
}

/// What the servo feels of the finger that rubs, in full resolution.
fn load() -> Arc<Load> {
    let load = Load::rough(&finger().design, OBJECT, FRICTION, &Drive::Rotating, &Load::REFERENCE, 10.0);
    load.expect("a load").into()
}

/// Goes to an angle, degrees, and waits until the estimate knows all that it will know there.
fn go(link: &fre_gripper::link::Link, watch: &mut Watch, to_deg: f32) -> Report {
    let to = to_deg * DEGREE;
    link.close(Which::All, to, Some(0.06)).unwrap();
    let mut still = 0;
    watch.until_report("a finger that is there and rests", SECONDS(60), |report| {
        let is_there = report.goal == to && (report.estimate.motor_angle - to).abs() < 0.004;
        let is_known = report.estimate.age == 0 && report.estimate.standard_deviation.is_finite();
        still = if is_there && is_known { still + 1 } else { 0 };
        still > 50
    });
    *watch.reports.last().unwrap()
}

/// Closing, opening and with a past that is unknown: the force that the finger truly has, from the same physics in full resolution, is that
/// of the estimate, and lies in its interval.
#[test]
fn the_interval_holds_the_force_of_a_finger_that_rubs() {
    let machine = Machine::boot(Config { load: load(), ..Machine::servo() });
    let link = machine.link();
    let mut watch = Watch::new(&link);
    link.set_settings(&SETTINGS).unwrap();
    link.set_finger(0, &finger()).unwrap();
    link.set_object(0, rough()).unwrap();
    assert_eq!(link.object(0).unwrap(), Some(rough()));
    watch.until_report("trustworthy estimate", SECONDS(20), |report| report.estimate.status.is_trustworthy());

    // Magnitude of the estimate and of the truth, N, and the width of the interval as a part of it.
    let compare = |report: &Report, slack: f64| {
        let [x, y] = machine.servo.truth().force;
        let (truth, found) = (x.hypot(y), f64::from(report.estimate.force_magnitude()));
        let interval = report.estimate.interval.expect("both ends are known");
        let [low, high] = interval.magnitude.map(f64::from);
        eprintln!("{:.2}°: {found:.3} N of {truth:.3}; {interval:?}", report.estimate.motor_angle / DEGREE);
        assert!(low <= truth * (1.0 + slack) && truth <= high * (1.0 + slack), "{low} {truth} {high}");
        (found, truth, (high - low) / high)
    };
    let report = go(&link, &mut watch, 7.0);
    let (found, truth, width) = compare(&report, 0.03);
    assert!((found / truth - 1.0).abs() < 0.03 && width < 0.01, "{found} {truth} {width}");
    // Without friction it is 5.4 N.
    assert!(truth > 5.9, "{truth}");
    // The same object once more: nobody knows how it came between the fingers.
    link.place_object(0, rough()).unwrap();
    let report = go(&link, &mut watch, 7.0);
    let (_, truth, width) = compare(&report, 0.01);
    assert!(width > 0.05, "{width} around {truth}");
    // An opening that is long enough, and the past is known again.
    let report = go(&link, &mut watch, 4.0);
    let (found, truth, width) = compare(&report, 0.03);
    assert!((found / truth - 1.0).abs() < 0.03 && width < 0.01, "{found} {truth} {width}");
}

/// Two fingers that rub close until they bear a mass across their plane, and in it; not beyond their force, and not one finger alone. What
/// they bear is what the contact forces on this PC say, and what the fingers truly press with.
#[test]
fn fingers_that_rub_close_until_they_bear_a_weight() {
    let load = load();
    let servo = |id| Config { id, load: load.clone(), ..Machine::servo() };
    let machine = Machine::boot_all(vec![servo(1), servo(2)]);
    let link = machine.link();
    let mut watch = Watch::new(&link);
    link.set_settings(&SETTINGS).unwrap();
    let weight = 0.3 * 9.80665;
    let carry = |gravity| CarryTo { weight, gravity, safety: 2.0, force: None, speed: Some(0.1), limit: None };
    let alone = SettingsField::Fingers;
    match link.carry(&carry(Gravity::Across)) {
        Err(LinkError::Refused(Refusal::Setting { field, value, .. })) => assert_eq!((field, value), (alone, 1.0)),
        other => panic!("one finger holds nothing: {other:?}"),
    }
    let [left, ..] = SETTINGS.fingers;
    let right = left.map(|mount| Mount { servo_id: 2, side: Side::Right, ..mount });
    link.set_settings(&Settings { rate_hz: 100, shape_every: 10, fingers: [left, right, None, None], ..SETTINGS })
        .unwrap();
    for number in 0..2 {
        link.set_finger(number, &finger()).unwrap();
        link.set_object(number, rough()).unwrap();
    }
    watch.until("a grasp", SECONDS(60), |told| matches!(told, Told::Grasp(grasp) if grasp.is_trustworthy));

    // Carries, and rests until the margin is of the forces as they then are.
    let carried = |watch: &mut Watch, to: &CarryTo| -> GripMargin {
        link.carry(to).unwrap();
        watch.until_report("the order is obeyed", SECONDS(60), |report| report.phase == Phase::Gripping);
        let mut gripped = [false; 2];
        watch.until_report("both have gripped", SECONDS(60), |report| {
            gripped[usize::from(report.finger)] = report.phase == Phase::Gripped;
            gripped == [true; 2]
        });
        let mut still = 0;
        let rests = |margin: GripMargin| margin.age == 0 && margin.carried.is_some();
        watch.until("a margin of forces that rest", SECONDS(60), |told| {
            if let Told::Grasp(grasp) = told {
                still = if grasp.margin.is_some_and(rests) { still + 1 } else { 0 };
            }
            still > 30
        });
        watch.grasps.last().and_then(|grasp| grasp.margin).unwrap()
    };
    let needed = 2.0 * weight;
    let found = carried(&mut watch, &carry(Gravity::Across));
    let borne = found.carried.unwrap();
    assert!(borne >= 0.95 * needed && borne < 1.15 * needed, "{borne} N for {needed}: {found:?}");
    assert!((found.across / borne - 1.0).abs() < 2e-3 && found.slips.is_some(), "{found:?}");
    // Across the plane they bear μ ΣN; a finger that closes slips everywhere: its force is N √(1 + μ²).
    let truth = machine.servos.iter().map(|servo| servo.truth().force).map(|[x, y]| x.hypot(y)).sum::<f64>();
    let estimates = watch.reports.iter().rev().take(2).map(|report| f64::from(report.estimate.force_magnitude()));
    let estimated: f64 = estimates.sum();
    eprintln!("forces: {estimated:.3} N estimated, {truth:.3} N true");
    let truth = FRICTION * truth / 1.0_f64.hypot(FRICTION);
    eprintln!("across: {borne:.3} N of {needed:.3} needed, {truth:.3} by the truth: {found:?}");
    assert!((f64::from(borne) / truth - 1.0).abs() < 0.05, "{borne} N, truly {truth}");
    // The same from the contact forces of the last shapes, in double precision.
    let mut margins = Margins::new(&link.setup().unwrap());
    let exact = watch.shapes.iter().filter_map(|shape| {
        let report = watch.reports.iter().rfind(|report| report.sequence == shape.sequence)?;
        margins.take(&Told::Report(*report));
        margins.take(&Told::Shape(shape.clone().into()))
    });
    let exact = exact.last();
    let exact = exact.expect("shapes of both fingers").of_age(0);
    let pairs = [(found.least, exact.least), (found.across, exact.across), (found.couple, exact.couple)];
    assert!(pairs.iter().all(|(one, other)| (one / other - 1.0).abs() < 5e-3), "{found:?}, {exact:?}");

    // In the plane, towards the palm; what is held already is not let go on the way.
    let since = watch.reports.len();
    let found = carried(&mut watch, &carry(Gravity::Along(-std::f32::consts::FRAC_PI_2)));
    let borne = found.carried.unwrap();
    eprintln!("towards the palm: {borne:.3} N: {found:?}");
    assert!(borne >= 0.95 * needed && borne >= found.least * 0.999, "{borne} N for {needed}: {found:?}");
    let least = watch.reports[since..].iter().map(|report| report.estimate.force_magnitude()).fold(f32::MAX, f32::min);
    assert!(least > 0.9 * watch.reports[since].estimate.force_magnitude(), "{least} N");

    // 5 kg are too much for 5.5 N.
    link.carry(&CarryTo { weight: 50.0, force: Some(5.5), ..carry(Gravity::Across) }).unwrap();
    let mut held = [false; 2];
    watch.until_report("both at their force", SECONDS(60), |report| {
        held[usize::from(report.finger)] = report.phase == Phase::Held(Why::Force);
        held == [true; 2]
    });
    let ages = watch.grasps.iter().filter_map(|grasp| grasp.margin).map(|margin| margin.age);
    let oldest = ages.max().expect("margins");
    eprintln!("oldest margin: {oldest} ticks");
    assert!(oldest < 300, "the search goes on while fingers move: {oldest} ticks");
}
