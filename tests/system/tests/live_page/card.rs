//! What a finger's card shows, compared with what the gripper sent.

use std::sync::Mutex;

use messages::Report;
use serde_json::json;
use system_tests::Browser;

use crate::page::{Stream, found};

/// What a finger's card shows is what the gripper told of that finger, number by number, in the report that it names.
pub fn equal(page: &mut Browser, finger: u8, stream: &Mutex<Stream>) -> Report {
    let shown = page.eval(&format!(
        "(() => {{ const card = document.querySelector('.finger[data-finger=\"{finger}\"]'), \
         is = name => card.querySelector('[data-is=' + name + ']').textContent; \
         return [Number(card.dataset.sequence)].concat(['force', 'angle', 'status', 'torque', 'current', 'deviation', \
         'components', 'centre', 'goal', 'phase'].map(is)); }})()"
    ));
    let named = |it: &Stream| it.reports.iter().rev().find(|report| json!(report.sequence) == shown[0]).copied();
    let report = found(stream, named).unwrap_or_else(|| panic!("no report {}", shown[0]));
    assert_eq!(report.finger, finger, "another finger's report: {shown}");
    let near = |text: &serde_json::Value, value: f32, digits: i32| {
        let shown: f64 = text.as_str().unwrap().parse().unwrap();
        assert!((shown - f64::from(value)).abs() <= 0.501 * 10_f64.powi(-digits), "{shown} is not {value}: {report:?}");
    };
    near(&shown[1], report.estimate.force_magnitude(), 2);
    near(&shown[2], report.estimate.motor_angle.to_degrees(), 2);
    assert!(shown[3].as_str().unwrap().starts_with(report.estimate.status.word()), "{shown} {report:?}");
    near(&shown[4], report.estimate.torque, 0);
    near(&shown[5], report.current, 0);
    // While a busy PC has lost the servo, not everything is known.
    if report.estimate.standard_deviation.is_finite() {
        near(&shown[6], report.estimate.standard_deviation, 2);
    } else {
        assert_eq!(shown[6], json!("?"));
    }
    let touches = report.estimate.force != [0.0; 2];
    if !touches {
        assert_eq!(shown[8], json!("–"));
    }
    let centre = touches.then_some((8, report.estimate.contact_centre, 1));
    for (place, values, digits) in [(7, report.estimate.force, 2)].into_iter().chain(centre) {
        let parts: Vec<_> = shown[place].as_str().unwrap().split(", ").map(|part| json!(part)).collect();
        assert_eq!(parts.len(), 2, "{shown}");
        parts.iter().zip(values).for_each(|(part, value)| near(part, value, digits));
    }
    near(&shown[9], report.goal.to_degrees(), 2);
    assert_eq!(shown[10], json!(report.phase.to_string()));
    report
}

/// A finger's picture has its beams, lamellae, object and force in their inks, and each chart a line wherever it has points:
/// pixels of each ink; columns with a line, and those that are due.
pub fn drawn(page: &mut Browser, finger: u8) -> Result<(), String> {
    // What is drawn on a canvas is clear beside it: a pixel that is hardly covered has its ink's colour all the same.
    let seen = page.eval(&format!(
        "(() => {{ const c = cards[{finger}]; drawCard(c, frame.fingers[{finger}]); \
         const pixels = canvas => canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data; \
         const has = (d, i, [r, g, b]) => d[i + 3] > 200 && Math.abs(d[i] - r) + Math.abs(d[i + 1] - g) + Math.abs(d[i + 2] - b) < 12; \
         const rgb = words => [1, 3, 5].map(at => parseInt(words.length > 4 ? words.substr(at, 2) : words[(at + 1) / 2].repeat(2), 16)); \
         const d = pixels(c.picture), parts = ['front', 'back', 'lamella', 'object', 'objectedge', 'force'].map(name => {{ \
           let n = 0; for (let i = 0; i < d.length; i += 4) n += has(d, i, rgb(ink[name])); return [name, n]; }}); \
         const column = (d, wide, high, x) => {{ for (let y = 20; y < high - 20; y++) {{ const i = 4 * (y * wide + x), \
             of = [d[i], d[i + 1], d[i + 2]]; if (d[i + 3] > 60 && Math.max(...of) - Math.min(...of) > 60) return true; }} return false; }}; \
         const charts = [[c.force, true], [c.angle, false]].map(([canvas, guarded]) => {{ \
           const d = pixels(canvas), wide = canvas.width, high = canvas.height, last = c.points[c.points.length - 1][0]; \
           let lined = 0, due = 0; \
           for (let x = 60; x < wide - 12; x++) {{ const time = last - WINDOW * (wide - 8 - x) / (wide - 50); \
             const next = c.points.findIndex(p => p[0] >= time), [before, after] = [c.points[next - 1], c.points[next]]; \
             if (!before || !after || after[0] - before[0] > GAP || guarded && !(before[6] && after[6])) continue; \
             due++; lined += column(d, wide, high, x); }} \
           return [lined, due]; }}); \
         return {{ parts, charts }}; }})()"
    ));
    let inked = seen["parts"].as_array().unwrap().iter().all(|part| part[1].as_u64().unwrap() >= 40);
    let lined = seen["charts"].as_array().unwrap().iter().all(|chart| {
        let [lined, due] = [0, 1].map(|place| chart[place].as_f64().unwrap());
        due > 20.0 && lined > 0.9 * due - 4.0
    });
    if inked && lined { Ok(()) } else { Err(seen.to_string()) }
}
