//! The live page in a real browser, on the firmware in QEMU.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use fre_gripper::servo::{Clock, Config, Gains};
use fre_gripper::source::{Source, Told, WAITING};
use fre_gripper::web;
use messages::{Direction, FreeObject, Grasp, GripTo, Mount, Phase, Report, Settings, Side, Support, Which};
use model_core::drive::Drive;
use model_core::object::ObjectDesign;
use serde_json::json;
use system_tests::{Browser, Machine, OBJECT, Watch, finger, load_on};

/// The object touches the finger at 0 just so: open is at −1°.
const MOUNT: Mount =
    Mount { open_angle: -std::f32::consts::PI / 180.0, force_limit: 100.0, current_limit: 2000.0, ..Mount::DEFAULT };
/// Between the bases of two fingers, mm, and where a free object between them is set: off the middle.
const APART: f64 = 56.0;
const FREE_X: f64 = 28.3;
const DESK: [u32; 2] = [1280, 1000];
const WIDE: [u32; 2] = [1600, 1000];
const PHONE: [u32; 2] = [390, 844];
/// How long a busy PC may take.
const PATIENCE: Duration = Duration::from_secs(60);

/// Where pictures go: for people.
fn pictures() -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("live-page");
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// What the gripper told while the page was open.
#[derive(Default)]
struct Stream {
    reports: Vec<Report>,
    grasps: Vec<Grasp>,
}

/// What is found in the stream. On a busy PC the page may have shown it before it is kept here.
fn found<T>(stream: &Mutex<Stream>, find: impl Fn(&Stream) -> Option<T>) -> Option<T> {
    let end = Instant::now() + PATIENCE;
    loop {
        let found = find(&stream.lock().unwrap());
        if found.is_some() || Instant::now() > end {
            return found;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// A gripper whose fingers are ready, its page in a browser, and what it tells.
fn on_page(
    servos: Vec<Config>,
    settings: &Settings,
    objects: &[ObjectDesign],
    visit: impl FnOnce(&mut Browser, &str, &Mutex<Stream>, &fre_gripper::link::Link),
) {
    on_page_of(&Machine::boot_all(servos), settings, objects, visit);
}

/// The same of a machine that the visit may meddle with.
fn on_page_of(
    machine: &Machine,
    settings: &Settings,
    objects: &[ObjectDesign],
    visit: impl FnOnce(&mut Browser, &str, &Mutex<Stream>, &fre_gripper::link::Link),
) {
    let count = machine.servos.len();
    let link = Arc::new(machine.link());
    let mut watch = Watch::new(&link);
    link.set_settings(settings).unwrap();
    for (number, object) in (0..).zip(objects) {
        link.set_finger(number, &finger()).unwrap();
        link.set_object(number, *object).unwrap();
    }
    let mut sound = vec![false; count];
    watch.until_report("trustworthy estimates", PATIENCE, |report| {
        sound[usize::from(report.finger)] |= report.estimate.status.is_trustworthy();
        sound.iter().all(|sound| *sound)
    });
    drop(watch);

    let stop = AtomicBool::new(false);
    let stream = Mutex::new(Stream::default());
    let (address, ready) = channel();
    let told = link.hear(WAITING);
    std::thread::scope(|scope| {
        let (stop, stream, gripper) = (&stop, &stream, link.clone());
        let server = scope.spawn(move || {
            let ready = |url: &str| address.send(url.to_owned()).unwrap();
            web::serve(gripper, "127.0.0.1:0".parse().unwrap(), None, None, stop, ready)
        });
        // Whatever fails below, the server ends.
        let _end = OnDrop(stop);
        scope.spawn(move || {
            while !stop.load(Ordering::Relaxed) {
                match told.recv_timeout(Duration::from_millis(100)) {
                    Ok(Told::Report(report)) => stream.lock().unwrap().reports.push(report),
                    Ok(Told::Grasp(grasp)) => stream.lock().unwrap().grasps.push(grasp),
                    _ => {}
                }
            }
        });
        let url = ready.recv_timeout(PATIENCE).expect("the page's address");
        assert!(url.starts_with("http://127.0.0.1:") && !url.contains("token"), "{url}");
        let mut page = Browser::start();
        visit(&mut page, &url, stream, &link);
        drop(page);
        stop.store(true, Ordering::Relaxed);
        server.join().unwrap().unwrap();
    });
}

#[test]
fn the_page_shows_the_stream_and_leads_the_gripper() {
    on_page(vec![Machine::servo()], &Settings::of(MOUNT), &[OBJECT], visit);
}

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
        assert!(page.eval("stopping.count").as_u64().unwrap() > 7, "tried again");
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

struct OnDrop<'a>(&'a AtomicBool);

impl Drop for OnDrop<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// What a finger's card shows is what the gripper told of that finger, number by number, in the report that it names.
fn equal(page: &mut Browser, finger: u8, stream: &Mutex<Stream>) -> Report {
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
fn drawn(page: &mut Browser, finger: u8) -> Result<(), String> {
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
        let shown = |page: &mut Browser| page.eval("document.forms['limits-form'].drive.value");
        assert_eq!(shown(page), json!("linear 1,0 10"));
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
    let mut asked = Instant::now();
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
    assert_eq!(object, Some(wanted));
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
