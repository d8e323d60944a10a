//! Two fingers on one page.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use fre_gripper::servo::Config;
use messages::{Direction, Grasp, GripTo, Mount, Settings, Side, Which};
use serde_json::json;
use system_tests::{Browser, Machine, OBJECT, Tries};

use crate::card::equal;
use crate::page::{DESK, MOUNT, PATIENCE, PHONE, Stream, WIDE, found, on_page, picture_of_the_book, pictures};

/// Two fingers, one mirrored: each card shows its own, the grasp both, and the settings go to the one that is named.
#[test]
fn several_fingers_each_show_their_own() {
    let second = Config { id: 7, closing_up: false, zero_count: 1000, ..Machine::servo() };
    let right = Mount { servo_id: 7, zero: 1000.0, direction: Direction::Reversed, side: Side::Right, ..MOUNT };
    // Slowly, for a busy PC.
    let mut settings = Settings { rate_hz: 100, ..Settings::of(MOUNT) };
    settings.fingers[1] = Some(right);
    on_page(vec![Machine::servo(), second], &settings, &[OBJECT; 2], visit_both);
}

fn visit_both(page: &mut Browser, url: &str, stream: &Mutex<Stream>, link: &fre_gripper::link::Link) {
    page.open(url, WIDE, false);
    let of = |finger: u8, name: &str| {
        format!("document.querySelector('.finger[data-finger=\"{finger}\"] [data-is={name}]').textContent")
    };
    page.until(
        "document.getElementById('link').textContent === 'live' && document.querySelectorAll('.finger').length === 2",
    );
    let names = page.eval("[...document.querySelectorAll('.finger h2')].map(h => h.textContent)");
    assert_eq!(names, json!(["Finger 0, left", "Finger 1, right"]));

    // Another force for each: a card that showed its neighbour's would be found out.
    let (mut asked, mut tries) = (Instant::now(), Tries::of("a grip of two"));
    let again = |link: &fre_gripper::link::Link| {
        for (finger, force) in [(0, 3.0), (1, 5.0)] {
            // Refused while a busy PC has lost the servo.
            let _ = link.grip(&GripTo { fingers: Which::One(finger), force, speed: Some(0.1), limit: None });
        }
    };
    again(link);
    let both = format!("{} === 'gripped' && {} === 'gripped'", of(0, "phase"), of(1, "phase"));
    let end = Instant::now() + Duration::from_secs(120);
    while page.eval(&both) != json!(true) {
        assert!(Instant::now() < end, "never both gripped");
        if asked.elapsed() > Duration::from_secs(15) {
            asked = Instant::now();
            tries.spoilt();
            again(link);
        }
        std::thread::sleep(Duration::from_millis(100));
    }
    let end = Instant::now() + PATIENCE;
    for round in 1.. {
        let [left, right] = [0, 1].map(|finger| equal(page, finger, stream).estimate.force_magnitude());
        if round >= 20 && right - left > 1.0 {
            break;
        }
        assert!(Instant::now() < end, "{left} N, {right} N");
        std::thread::sleep(Duration::from_millis(40));
    }
    // Of the grasp there is no number to find it by: it is one of those told.
    page.until(
        "(globalThis.seen = ['squeeze', 'sum', 'balance'].map(id => document.getElementById(id).textContent))[0] !== '–'",
    );
    let shown = page.eval("seen");
    assert_eq!(page.eval("document.getElementById('grasp').hidden"), json!(false));
    let fixed = |value: f32, digits: usize| {
        let words = format!("{value:.digits$}");
        if words.trim_start_matches('-').chars().all(|c| c == '0' || c == '.') { words.replace('-', "") } else { words }
    };
    let is_shown = |grasp: &&Grasp| {
        let sum = grasp.sum.map(|part| fixed(part, 2)).join(", ");
        grasp.is_trustworthy && shown == json!([fixed(grasp.squeeze, 2), sum, fixed(100.0 * grasp.balance, 0)])
    };
    let told = found(stream, |it| it.grasps.iter().rev().take(500).find(is_shown).copied());
    assert!(told.is_some(), "no grasp was {shown}");
    // What the grip bears, drawn: without friction nothing in the weakest direction.
    page.until("!document.querySelector('.bears').hidden && document.getElementById('bears').textContent === '0.00'");
    let corners = page.eval("document.querySelector('#margin polygon').getAttribute('points').split(' ').length");
    assert_eq!(corners, json!(24));
    for (name, size, dark) in [("two-light", WIDE, false), ("two-dark", DESK, true), ("two-phone", PHONE, false)] {
        page.look(size, dark);
        std::thread::sleep(Duration::from_millis(400));
        page.picture(&pictures().join(format!("{name}.png")));
        let wide = page.eval("document.documentElement.scrollWidth <= document.documentElement.clientWidth");
        assert_eq!(wide, json!(true), "{name}: wider than the window");
    }
    page.look(PHONE, true);
    page.eval("document.getElementById('grasp').scrollIntoView()");
    std::thread::sleep(Duration::from_millis(400));
    page.picture(&pictures().join("two-phone-below.png"));
    page.look(WIDE, false);
    page.eval("scrollTo(0, 0)");
    std::thread::sleep(Duration::from_millis(400));
    picture_of_the_book(page);

    // The second finger's limits, and nobody else's.
    page.eval(
        "{ const f = document.getElementById('finger'); f.value = '1'; f.dispatchEvent(new Event('change')); \
         const l = document.forms['limits-form']; l.speed_deg_s.value = '7.5'; l.requestSubmit() }",
    );
    page.until("document.querySelector('#limits-form output').textContent === 'the target has the limits'");
    let mounts = link.settings().unwrap().fingers;
    let speed = |number: usize| mounts[number].unwrap().speed.to_degrees();
    assert!((speed(1) - 7.5).abs() < 1e-4 && (speed(0) - 20.0).abs() < 1e-4, "{mounts:?}");

    // The stop is for all.
    page.click("#stop");
    page.until("document.getElementById('answer').textContent.startsWith('stopped')");
    page.until(&format!("{}.startsWith('held') && {}.startsWith('held')", of(0, "phase"), of(1, "phase")));
    page.complaints.retain(|words| !words.contains("/command"));
    assert!(page.complaints.is_empty(), "{:?}", page.complaints);
}
