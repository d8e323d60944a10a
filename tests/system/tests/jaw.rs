//! The whole gripper with a finger that its motor moves along a line: what it says and what it grips, judged by what the simulated
//! servo's finger really does.

use std::time::Duration;

use fre_gripper::link::set;
use fre_gripper::servo::Config;
use messages::{GripTo, Mount, Phase, Settings, Which};
use model_core::drive::Drive;
use model_core::object::ObjectDesign;
use model_core::status::Status;
use system_tests::{Agreement, Machine, Watch, finger, load_on};

/// Longest wait for anything, on a busy PC.
const PATIENCE: Duration = Duration::from_secs(120);
/// 2.3 mm in front of the jaw at motor angle 0.
const OBJECT: ObjectDesign = ObjectDesign::Circle { centre: [43.3, 45.0], radius: 40.0 };

/// A rack that moves the jaw 12 mm per radian; the reference is the scheme `paper` at 170/20, which the servo's finger is made of.
#[test]
fn a_jaw_grips_with_the_force_asked_for() {
    let drive = Drive::linear([1.0, 0.0], 12.0);
    let load = load_on(&drive, OBJECT, 60.0);
    let machine = Machine::boot(Config { load: load.clone(), ..Machine::servo() });
    let link = machine.link();
    let mut watch = Watch::new(&link);
    // As a person sets it.
    let mount =
        Mount { open_angle: 0.0, range: [-0.2, 1.0], force_limit: 100.0, current_limit: 2000.0, ..Mount::DEFAULT };
    let mut settings = Settings { rate_hz: 100, ..Settings::of(mount) };
    set(&mut settings, "finger.0.drive=linear 1,0 12").unwrap();
    link.set_settings(&settings).unwrap();
    assert_eq!(link.settings().unwrap().fingers[0].unwrap().drive, drive);
    link.set_finger(0, &finger()).unwrap();
    link.set_object(0, OBJECT).unwrap();
    watch.until_report("a jaw clear of the object", PATIENCE, |report| report.estimate.status == Status::NoContact);

    // Closing slowly: at every place the force that is told is the one there is.
    watch.reports.clear();
    link.close(Which::All, 0.75, Some(0.2)).unwrap();
    watch.until_report("a closed jaw", PATIENCE, |report| {
        report.goal == 0.75 && (report.estimate.motor_angle - 0.75).abs() < 0.004 && report.estimate.age == 0
    });
    let agreement = Agreement::of(&watch.reports, &load);
    // The order of the reference's own error at Mid (2.5 %) and the reduced model's (0.5 %).
    assert!(agreement.is_within(0.04), "{agreement:?}");

    for force in [2.0_f64, 4.0] {
        link.open_fingers(Which::All).unwrap();
        watch.until_report("an open jaw", PATIENCE, |report| {
            report.estimate.status == Status::NoContact && report.goal == 0.0
        });
        link.grip(&GripTo { fingers: Which::All, force: force as f32, speed: Some(0.2), limit: None }).unwrap();
        let mut kept = 0;
        watch.until_report("a grip", PATIENCE, |report| {
            kept = if report.phase == Phase::Gripped { kept + 1 } else { 0 };
            kept > 50
        });
        let [x, y] = machine.servo.truth().force;
        let reached = x.hypot(y);
        eprintln!("{force} N asked, {reached:.3} N reached");
        assert!((reached / force - 1.0).abs() < 0.05, "{reached} N instead of {force} N");
    }
}
