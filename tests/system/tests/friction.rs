//! Friction on the target: the firmware in QEMU, on a simulated servo whose finger rubs on the object in full resolution.

use std::time::Duration;

use fre_gripper::servo::{Config, Load};
use messages::{Mount, Object, Report, Settings, Which};
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
    let design = finger().design;
    let load = Load::rough(&design, OBJECT, FRICTION, &Drive::Rotating, &Load::REFERENCE, 10.0).expect("a load");
    let machine = Machine::boot(Config { load: load.into(), ..Machine::servo() });
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
