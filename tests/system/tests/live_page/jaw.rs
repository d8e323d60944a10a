//! A jaw that moves along a line.

use std::time::{Duration, Instant};

use fre_gripper::servo::Config;
use messages::{Mount, Settings, Which};
use model_core::drive::Drive;
use model_core::object::ObjectDesign;
use system_tests::{Machine, load_on};

use crate::card::drawn;
use crate::page::{DESK, PATIENCE, on_page, pictures};

/// A jaw that moves along a line is drawn where it is, and its drive is a setting.
#[test]
fn a_jaw_is_drawn_where_it_has_moved() {
    let drive = Drive::linear([1.0, 0.0], 12.0);
    let object = ObjectDesign::Circle { centre: [43.3, 45.0], radius: 40.0 };
    let servo = Config { load: load_on(&drive, object, 60.0), ..Machine::servo() };
    let mount = Mount {
        open_angle: 0.0,
        range: [-0.2, 1.0],
        drive: Drive::linear([1.0, 0.0], 10.0),
        force_limit: 100.0,
        current_limit: 2000.0,
        ..Mount::DEFAULT
    };
    let settings = Settings { rate_hz: 100, ..Settings::of(mount) };
    on_page(vec![servo], &settings, &[object], |page, url, _, link| {
        page.open(url, DESK, false);
        page.until("document.getElementById('link').textContent === 'live'");
        page.until("document.forms['limits-form'].drive.value === 'linear 1,0 10'");
        page.eval("{ const l = document.forms['limits-form']; l.drive.value = 'linear 1,0 12'; l.requestSubmit() }");
        page.until("document.querySelector('#limits-form output').textContent === 'the target has the limits'");
        assert_eq!(link.settings().unwrap().fingers[0].unwrap().drive, drive);
        page.eval("{ const l = document.forms['limits-form']; l.drive.value = 'sideways'; l.requestSubmit() }");
        page.until("document.querySelector('#limits-form output').className === 'bad'");
        link.close(Which::All, 0.6, Some(0.3)).unwrap();
        page.until("Math.abs(frame.fingers[0].angle_deg - 0.6 * 180 / Math.PI) < 0.3");
        page.until("frame.fingers[0].force_n > 1");
        // The base has gone 12 mm/rad.
        page.until("Math.abs(cards[0].shape.shift_mm[0] - 7.2) < 0.1 && cards[0].shape.shift_mm[1] === 0");
        page.picture(&pictures().join("jaw.png"));
        let end = Instant::now() + PATIENCE;
        while let Err(seen) = drawn(page, 0) {
            assert!(Instant::now() < end, "something is not drawn: {seen}");
            std::thread::sleep(Duration::from_millis(200));
        }
        page.complaints.retain(|words| !words.contains("/command"));
        assert!(page.complaints.is_empty(), "{:?}", page.complaints);
    });
}
