//! How much stack the gripper takes: less than the boards have, whatever is asked of it and whatever comes between.

use std::time::Duration;

use fre_gripper::servo::{Config, Fault};
use messages::{Event, GripTo, Mount, Settings, Which};
use model_core::object::ObjectDesign;
use system_tests::{Machine, OBJECT, Watch, finger};

const DEGREE: f32 = std::f32::consts::PI / 180.0;
const MOUNT: Mount =
    Mount { open_angle: -DEGREE, range: [-0.05, 0.3], force_limit: 100.0, current_limit: 2000.0, ..Mount::DEFAULT };
/// The other object, which is set and taken away while the finger is on it.
const OTHER: ObjectDesign = ObjectDesign::Circle { centre: [41.0, 56.0], radius: 40.0 };
const PATIENCE: Duration = Duration::from_secs(120);
/// Part of a stack that stays unused at least: a board's image has other frames than QEMU's.
const SPARE: f64 = 0.15;

#[test]
fn every_board_has_stack_enough() {
    let machine = Machine::boot(Config { noise_ma: 5.0, ..Machine::servo() });
    let link = machine.link();
    let mut watch = Watch::new(&link);
    let booted = machine.stack_depth();
    link.set_settings(&Settings { shape_every: 5, ..Settings::of(MOUNT) }).expect("settings");
    let finger = finger();
    for _ in 0..3 {
        link.set_finger(0, &finger).expect("a finger");
        link.set_object(0, OBJECT).expect("an object");
        watch.until_report("trustworthy estimate", PATIENCE, |report| report.estimate.age == 0);
        let all = Which::All;
        let _ = link.close(all, 11.0 * DEGREE, Some(1.0));
        watch.until_report("contact", PATIENCE, |report| report.estimate.age == 0 && report.estimate.force != [0.0; 2]);
        // Requests of every size while the loop is at its longest.
        for object in [OTHER, OBJECT, OTHER, OBJECT] {
            link.set_object(0, object).expect("an object");
            let _ = link.place_object(0, object);
            assert!(link.finger(0).expect("an answer").is_some());
            link.counters().expect("counters");
            link.settings().expect("settings");
            machine.servo.inject([Fault::Drop]);
        }
        let _ = link.grip(&GripTo { fingers: all, force: 5.0, speed: Some(1.0), limit: None });
        watch.pass(Duration::from_millis(500));
        let _ = link.open_fingers(all);
        watch.pass(Duration::from_millis(500));
    }
    link.scan().expect("a search");
    watch.until_event("the search's end", PATIENCE, |event| matches!(event, Event::ScanDone { .. }));
    let depth = machine.stack_depth();
    eprintln!("{booted} bytes of stack when it has begun, {depth} at most");
    assert!(depth > 4096, "{depth} bytes");
    // An image that is built for size has other frames: this says nothing of it.
    for board in fre_boards::ALL.iter().filter(|board| !board.is_small) {
        let usable = (1.0 - SPARE) * f64::from(board.stack);
        assert!(
            f64::from(depth) <= usable,
            "{} has {} bytes of stack, {depth} were used in QEMU",
            board.name,
            board.stack
        );
    }
}
