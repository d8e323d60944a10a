//! One finger: gripped, stopped, set up.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use messages::{Mount, Phase, Settings};
use serde_json::json;
use system_tests::{Browser, Machine, OBJECT};

use crate::card::{drawn, equal};
use crate::page::{DESK, MOUNT, PATIENCE, PHONE, Stream, found, on_page, pictures};

#[test]
fn the_page_shows_the_stream_and_leads_the_gripper() {
    on_page(vec![Machine::servo()], &Settings::of(MOUNT), &[OBJECT], visit);
}

fn visit(page: &mut Browser, url: &str, stream: &Mutex<Stream>, link: &fre_gripper::link::Link) {
    let is = |name: &str| format!("document.querySelector('[data-is={name}]').textContent");
    page.open(url, DESK, false);
    page.until(&format!("document.getElementById('link').textContent === 'live' && {} === 'no-contact'", is("status")));
    assert!(page.eval("document.getElementById('target').textContent").as_str().unwrap().contains("mps2"));

    // Grip from the keyboard: the force asked for is reached, and kept.
    page.eval("document.getElementById('force').value = '5'");
    page.press_until("g", &format!("{} === 'gripped'", is("phase")));
    page.until("document.getElementById('answer').className === 'good'");
    page.until(&format!("Math.abs({} - 5) < 0.5", is("force")));
    page.picture(&pictures().join("light.png"));
    page.look(DESK, true);
    page.until("document.documentElement.classList.contains('dark')");
    std::thread::sleep(Duration::from_millis(300));
    page.picture(&pictures().join("dark.png"));
    page.look(PHONE, false);
    std::thread::sleep(Duration::from_millis(300));
    page.picture(&pictures().join("phone.png"));
    // Nothing is wider than the phone, and the stop is on the screen wherever one scrolls.
    let wide = page.eval("document.documentElement.scrollWidth <= document.documentElement.clientWidth");
    assert_eq!(wide, json!(true), "wider than the phone");
    page.eval("scrollTo(0, document.body.scrollHeight)");
    let there = page.eval(
        "(() => { const r = document.getElementById('stop').getBoundingClientRect(); \
         return r.top >= 0 && r.bottom <= innerHeight && r.height >= 56 && r.width >= 120; })()",
    );
    assert_eq!(there, json!(true), "the stop is not on the screen");
    page.picture(&pictures().join("phone-below.png"));
    page.eval("scrollTo(0, 0)");
    page.look(DESK, false);

    for _ in 0..20 {
        equal(page, 0, stream);
        std::thread::sleep(Duration::from_millis(40));
    }
    // A busy PC loses the servo now and then: a gripped finger's picture comes again.
    let end = Instant::now() + PATIENCE;
    while let Err(seen) = drawn(page, 0) {
        assert!(Instant::now() < end, "something is not drawn: {seen}");
        std::thread::sleep(Duration::from_millis(200));
    }

    // The stop, while it closes: it stays where it is, and says that the target has taken it. Slowly: a busy PC clicks late.
    let slow = Mount { speed: 0.3_f32.to_radians(), ..MOUNT };
    link.set_settings(&Settings::of(slow)).unwrap();
    page.eval("document.getElementById('angle').value = '11'");
    page.eval("document.querySelector('#close-form button').click()");
    page.until(&format!("{} === 'moving'", is("phase")));
    page.click("#stop");
    page.until("document.getElementById('answer').textContent.startsWith('stopped')");
    page.until(&format!("{}.startsWith('held')", is("phase")));
    let held = |it: &Stream| it.reports.last().filter(|report| matches!(report.phase, Phase::Held(_))).copied();
    let stopped = found(stream, held).expect("a report of a held finger").goal;
    assert!(stopped < 10.9_f32.to_radians(), "it had arrived before the stop");
    std::thread::sleep(Duration::from_secs(1));
    assert_eq!(stream.lock().unwrap().reports.last().unwrap().goal, stopped, "it moved after the stop");

    // Escape stops as well, also out of a field, where a space is a space.
    page.eval("document.getElementById('answer').textContent = ''; document.getElementById('force').focus()");
    page.press("Escape");
    page.until("document.getElementById('answer').textContent.startsWith('stopped')");
    link.set_settings(&Settings::of(MOUNT)).unwrap();
    page.eval("document.activeElement.blur()");
    page.press_until("r", &format!("{} === 'no-contact'", is("status")));

    // Settings: sent, acknowledged, and read back from the target.
    page.eval(
        "document.forms['limits-form'].speed_deg_s.value = '12.5'; document.forms['limits-form'].requestSubmit()",
    );
    page.until("document.querySelector('#limits-form output').textContent === 'the target has the limits'");
    let speed = link.settings().unwrap().fingers[0].unwrap().speed.to_degrees();
    assert!((speed - 12.5).abs() < 1e-4, "{speed}");
    page.eval("document.forms['limits-form'].speed_deg_s.value = '-1'; document.forms['limits-form'].requestSubmit()");
    page.until("document.querySelector('#limits-form output').className === 'bad'");
    let words = page.eval("document.querySelector('#limits-form output').textContent");
    assert!(words.as_str().unwrap().contains("speed in degrees per second is -1.000"), "{words}");
    let fill = "const f = document.forms['object-form']; f.elements.radius_mm.value = '30'; f.elements.centre_mm.value = '34, 45'; f.requestSubmit()";
    page.eval(&format!("{{ {fill} }}"));
    page.until("document.querySelector('#object-form output').textContent === 'the target has the object'");
    let object = link.object(0).unwrap();
    let wanted = model_core::object::ObjectDesign::Circle { centre: [34.0, 45.0], radius: 30.0 };
    assert_eq!(object, Some(wanted.into()));
    page.until("setup.fingers[0].object.radius_mm === 30");
    page.eval("{ const f = document.forms['object-form']; f.elements.radius_mm.value = 'ten'; f.requestSubmit() }");
    page.until("document.querySelector('#object-form output').className === 'bad'");

    // Thirty frames a second at most, not the gripper's hundreds. (A second's worth may have waited.)
    let frames = page.eval(
        "new Promise(done => { let n = 0; const start = performance.now(), count = () => n++; events.addEventListener('frame', count); \
         setTimeout(() => { events.removeEventListener('frame', count); done([n, (performance.now() - start) / 1000]); }, 3000); })",
    );
    let [count, seconds] = [0, 1].map(|place| frames[place].as_f64().unwrap());
    println!("{:.1} frames a second", count / seconds);
    assert!(count >= 1.0 && count <= 30.0 * seconds + 31.0, "{count} frames in {seconds} s");

    let loaded = page.eval(
        "performance.getEntriesByType('resource').map(r => new URL(r.name).origin).every(o => o === location.origin)",
    );
    assert_eq!(loaded, json!(true), "something came from outside");
    page.complaints.retain(|words| !words.contains("/command"));
    assert!(page.complaints.is_empty(), "{:?}", page.complaints);
}
