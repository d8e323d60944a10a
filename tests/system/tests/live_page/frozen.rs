//! A gripper that has stopped answering.

use messages::Settings;
use serde_json::json;
use system_tests::{Machine, OBJECT};

use crate::page::{DESK, MOUNT, on_page_of};

/// A gripper that is frozen: within half a second nothing that it told looks as if it were of now, and a stop that it does not take
/// is said not to have been made within a second, for as long as that is so. Thawed, it takes the stop without another press.
#[test]
fn a_frozen_gripper_is_struck_out_and_not_stopped() {
    let machine = Machine::boot(Machine::servo());
    on_page_of(&machine, &Settings { rate_hz: 100, ..Settings::of(MOUNT) }, &[OBJECT], |page, url, _, _| {
        page.open(url, DESK, false);
        page.until("document.getElementById('link').textContent === 'live' && cards[0].points.length > 10");
        // The page is looked at in its own time, and just after it has been brought up to date: a busy PC draws seldom.
        page.eval(
            "globalThis.aged = []; globalThis.said = []; globalThis.pressed = Infinity; setInterval(() => { \
             const [age, since] = [performance.now() - heard + frame.silent_ms, performance.now() - pressed]; linkState(); \
             aged.push([age, cards[0].node.classList.contains('dead'), cards[0].is.status.textContent]); \
             said.push([since, document.getElementById('answer').textContent]); }, 20); 0",
        );
        machine.freeze();
        page.until("aged.some(entry => entry[0] > 1000)");
        let young = page.eval("aged.filter(entry => entry[0] > 500 && !(entry[1] && entry[2].startsWith('silent')))");
        assert_eq!(young, json!([]), "numbers of a silent gripper look as if they were of now");
        page.eval("pressed = performance.now(); 0");
        page.press("Escape");
        page.until("said.some(entry => entry[0] > 7000)");
        // The press itself may take a while.
        let first = page.eval("stopping.since - pressed").as_f64().unwrap();
        let taken_back =
            format!("said.filter(entry => entry[0] > {first} + 1000 && !entry[1].startsWith('NOT STOPPED'))");
        assert_eq!(page.eval(&taken_back), json!([]), "a stop that was not made");
        // Ten times a second, in every tenth in which a busy PC let the page do anything.
        let tries = page.eval(
            "[stopping.count, new Set(said.map(entry => Math.floor((entry[0] - stopping.since + pressed) / 100)) \
             .filter(tenth => tenth >= 0)).size]",
        );
        let [count, tenths] = [0, 1].map(|place| tries[place].as_f64().unwrap());
        println!("{count} tries in {tenths} tenths of a second");
        assert!(tenths > 50.0 && (0.9 * tenths..1.1 * tenths).contains(&count), "{count} tries in {tenths} tenths");
        // Another answer does not take its place.
        page.eval("{ ask({ release: {} }, document.getElementById('answer')); 0 }");
        assert_eq!(page.eval("document.getElementById('answer').textContent.startsWith('NOT STOPPED')"), json!(true));
        machine.thaw();
        page.until("document.getElementById('answer').textContent === 'stopped: the target holds its fingers'");
        page.until(
            "!cards[0].node.classList.contains('dead') && document.getElementById('link').textContent === 'live'",
        );
    });
}
