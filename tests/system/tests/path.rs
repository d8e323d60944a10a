//! What the gripper knows of the way that a finger with friction has come: after a restart, and after ticks that were lost.

use std::sync::{Arc, OnceLock};

use fre::study::model::{Options, Precision};
use fre_gripper::servo::{Config, Load};
use messages::{
    Close, CloseTo, For, GetObject, Mount, Object, Refusal, Report, SetFinger, SetObject, SetSettings, Settings,
    Support, Which,
};
use model_core::discretise::{Discretisation, Physics};
use model_core::drive::Drive;
use model_core::newton::Hessian;
use system_tests::{Bench, Flash, OBJECT, finger, geared_servo, is_sound};

const SECOND: u64 = 1_000_000;
const DEGREE: f32 = std::f32::consts::PI / 180.0;
const ROUGH: Object = Object { design: OBJECT, friction: 0.6 };
const MOUNT: Mount =
    Mount { open_angle: -DEGREE, range: [-0.05, 0.3], force_limit: 100.0, current_limit: 2000.0, ..Mount::DEFAULT };

/// A servo without play, whose finger rubs on [`OBJECT`].
fn servo() -> Config {
    static LOAD: OnceLock<Arc<Load>> = OnceLock::new();
    let options = Options {
        discretisation: Discretisation::fine(Physics::Extended),
        hessian: Hessian::Newton,
        precision: Precision::F64,
    };
    let load = || Load::rough(&finger().design, OBJECT, ROUGH.friction, &Drive::Rotating, &options, 10.0);
    let load = LOAD.get_or_init(|| load().expect("a load").into()).clone();
    Config { load, backlash_deg: 0.0, ..geared_servo() }
}

fn set_up(bench: &mut Bench) {
    bench.ask::<SetSettings>(&Settings { rate_hz: 100, shape_every: 0, ..Settings::of(MOUNT) }).expect("settings");
    bench.ask::<SetFinger>(&For { finger: 0, what: finger() }).expect("a finger");
    bench.ask::<SetObject>(&For { finger: 0, what: ROUGH }).expect("an object");
    bench.until("sound estimate", 5 * SECOND, is_sound);
}

/// Goes to an angle, degrees, rests there, and gives the last report.
fn go(bench: &mut Bench, to_deg: f32) -> Report {
    let to = CloseTo { fingers: Which::All, angle: to_deg * DEGREE, speed: Some(0.1) };
    bench.ask::<Close>(&to).expect("a motion");
    bench.run(3 * SECOND);
    bench.reports.last().expect("a report").0
}

/// Width of the interval as a part of the force, and that the true force lies in it, but for 3 %.
fn width(bench: &Bench, report: &Report) -> f32 {
    let [low, high] = report.estimate.interval.expect("both ends are known").magnitude;
    let [x, y] = bench.servo.truth().force;
    let truth = x.hypot(y) as f32;
    assert!(low < 1.03 * truth && truth < 1.03 * high, "{low} {truth} {high}");
    (high - low) / high
}

#[test]
fn a_restart_while_holding_leaves_an_interval_that_a_motion_narrows() {
    let flash = Flash::new();
    let mut bench = Bench::new(servo(), &flash);
    set_up(&mut bench);
    let held = go(&mut bench, 7.0);
    assert!(width(&bench, &held) < 0.01, "{held:?}");
    bench.restart(&flash);
    assert_eq!(bench.ask::<GetObject>(&0), Some(ROUGH));
    bench.run(3 * SECOND);
    let report = bench.reports.last().expect("a report").0;
    assert!(is_sound(&report) && width(&bench, &report) > 0.05, "{report:?}");
    let report = go(&mut bench, 4.0);
    assert!(width(&bench, &report) < 0.01, "{report:?}");
}

#[test]
fn lost_ticks_leave_an_interval_and_single_ones_do_not() {
    let mut bench = Bench::new(servo(), &Flash::new());
    set_up(&mut bench);
    let mut answers = 0;
    bench.meddling = Box::new(move |to_servo, bytes| {
        answers += u32::from(!to_servo);
        if !to_servo && answers.is_multiple_of(9) { Vec::new() } else { bytes }
    });
    let held = go(&mut bench, 7.0);
    assert!(width(&bench, &held) < 0.01, "{held:?}");
    bench.meddling = Box::new(|_, _| Vec::new());
    bench.run(SECOND);
    bench.meddling = Box::new(|_, bytes| bytes);
    bench.run(8 * SECOND);
    let report = bench.reports.last().expect("a report").0;
    assert!(is_sound(&report) && width(&bench, &report) > 0.05, "{report:?}");
}

/// A free object may have friction, but not any.
#[test]
fn friction_is_within_its_range_for_a_free_object_as_well() {
    let mut bench = Bench::new(servo(), &Flash::new());
    set_up(&mut bench);
    let mut settings = Settings::of(MOUNT);
    settings.fingers[1] = Some(Mount { servo_id: 9, ..MOUNT });
    let free = Settings { support: Support::Free { load: [0.0; 2], moment: 0.0 }, ..settings };
    bench.ask::<SetSettings>(&free).expect("a free object with friction");
    bench.ask::<SetObject>(&For { finger: 0, what: ROUGH }).expect("the same again");
    let wild = Object { friction: 3.5, ..ROUGH };
    let Err(Refusal::Object(why)) = bench.ask::<SetObject>(&For { finger: 0, what: wild }) else { panic!("friction") };
    assert_eq!(why, "friction is 3.5; allowed is 0 to 3");
}
