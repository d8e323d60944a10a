//! A free object between two fingers.

use std::sync::Mutex;
use std::time::Duration;

use fre_gripper::servo::{Clock, Config, Gains};
use messages::{FreeObject, Mount, Settings, Side, Support, Which};
use model_core::object::ObjectDesign;
use serde_json::json;
use system_tests::Browser;

use crate::page::{MOUNT, PHONE, Stream, WIDE, found, on_page, pictures};

/// Between the bases of two fingers, mm, and where a free object between them is set: off the middle.
const APART: f64 = 56.0;
const FREE_X: f64 = 28.3;

/// An object that is let go is drawn where the fingers have moved it, and its way is told.
#[test]
fn a_free_object_is_shown_where_it_has_gone() {
    let clock = Clock::Requests { period_us: 5_000 };
    let servo = |id| Config {
        id,
        baud_rate: 1_000_000,
        clock,
        start_deg: Some(-1.0),
        gains: Gains::GREATEST,
        ..Config::default()
    };
    let mut settings = Settings { rate_hz: 50, ..Settings::of(MOUNT) };
    settings.fingers[1] = Some(Mount { servo_id: 7, side: Side::Right, ..MOUNT });
    let objects = [FREE_X, APART - FREE_X].map(|x| ObjectDesign::Circle { centre: [x, 44.0], radius: 25.0 });
    on_page(vec![servo(1), servo(7)], &settings, &objects, visit_free);
}

fn visit_free(page: &mut Browser, url: &str, stream: &Mutex<Stream>, link: &fre_gripper::link::Link) {
    page.open(url, WIDE, false);
    page.until("document.getElementById('link').textContent === 'live'");
    for (finger, degrees) in [(0, 10.0_f32), (1, 7.0)] {
        link.close(Which::One(finger), degrees.to_radians(), Some(0.35)).unwrap();
    }
    let there = |number: usize, degrees: f64| format!("Math.abs(frame.fingers[{number}].angle_deg - {degrees}) < 0.3");
    page.until(&format!("{} && {}", there(0, 10.0), there(1, 7.0)));
    assert_eq!(page.eval("document.getElementById('free').hidden"), json!(true), "nothing is free yet");
    page.picture(&pictures().join("free-before.png"));
    let place = "cards.map(c => freed(c)(c.setup.object_centre_mm))";
    let across = |drawn: &serde_json::Value| [0, 1].map(|finger| drawn[finger][0].as_f64().unwrap());
    assert_eq!(across(&page.eval(place)), [FREE_X, APART - FREE_X]);

    let support = Support::Free { load: [0.0, -0.2], moment: 0.0 };
    let settings = link.settings().unwrap();
    link.set_settings(&Settings { support, ..settings }).unwrap();
    page.until("document.getElementById('place').textContent.startsWith('converged, ')");
    // It stays where it has come to rest: all numbers of one frame.
    page.until(&format!(
        "(globalThis.seen = [document.getElementById('place').textContent, {place}])[0].startsWith('converged')"
    ));
    let seen = page.eval("seen");
    let shift: Vec<f64> = seen[0].as_str().unwrap().split(", ").skip(1).map(|part| part.parse().unwrap()).collect();
    let is_shown =
        |free: &FreeObject| free.shift.iter().zip(&shift).all(|(told, shown)| (f64::from(*told) - shown).abs() < 0.006);
    let gone = |it: &Stream| it.grasps.iter().rev().filter_map(|grasp| grasp.free).find(is_shown);
    assert!(found(stream, gone).is_some(), "nothing told of a free object is {seen}");
    // Nothing rubs: it has slipped towards the bases. Both fingers draw it there, each in its own frame.
    assert!(shift[1] < -1.0, "{seen}");
    let [left, right] = across(&seen[1]);
    assert!((left - FREE_X - shift[0]).abs() < 0.006 && (APART - right - left).abs() < 1e-6, "{seen}");
    // One that is no circle turns as well, in a mirrored finger's frame the other way: a point 1 mm beside its centre.
    let turned = page.eval(
        "(() => { const kept = frame; frame = { grasp: { free: { shift_mm: [1, 2], turn_deg: 90 } } }; \
         const places = cards.map(c => { const [x, y] = c.setup.object_centre_mm, [px, py] = freed(c)([x + 1, y]); return [px - x, py - y]; }); \
         frame = kept; return places; })()",
    );
    for (finger, expected) in [[1.0, 3.0], [-1.0, 1.0]].into_iter().enumerate() {
        let off = |i: usize| (turned[finger][i].as_f64().unwrap() - expected[i]).abs();
        assert!(off(0) < 1e-9 && off(1) < 1e-9, "{turned}");
    }
    // A shape comes less often than the numbers.
    page.until("cards.every(c => c.shape.trustworthy)");
    for (name, size, dark) in [("free-light", WIDE, false), ("free-phone", PHONE, true)] {
        page.look(size, dark);
        std::thread::sleep(Duration::from_millis(400));
        page.picture(&pictures().join(format!("{name}.png")));
    }
    page.eval("document.getElementById('grasp').scrollIntoView()");
    std::thread::sleep(Duration::from_millis(400));
    page.picture(&pictures().join("free-phone-below.png"));
}
