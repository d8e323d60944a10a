//! A gripper whose page is open in a browser, and what it said meanwhile.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use fre_gripper::servo::Config;
use fre_gripper::source::{Source, Told, WAITING};
use fre_gripper::web;
use messages::{Grasp, Mount, Report, Settings};
use model_core::object::ObjectDesign;
use system_tests::{Browser, Machine, Watch, finger};

/// The object touches the finger at 0 just so: open is at −1°.
pub const MOUNT: Mount =
    Mount { open_angle: -std::f32::consts::PI / 180.0, force_limit: 100.0, current_limit: 2000.0, ..Mount::DEFAULT };
pub const DESK: [u32; 2] = [1280, 1000];
pub const WIDE: [u32; 2] = [1600, 1000];
pub const PHONE: [u32; 2] = [390, 844];
/// How long a busy PC may take.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// Where pictures go: for people.
pub fn pictures() -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("live-page");
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// Writes the book's picture of the page where `cargo xtask docs --page` asks for it. The versions are left out: a picture does not follow them.
pub fn picture_of_the_book(page: &mut Browser) {
    if std::env::var_os("FRE_DOCS").is_none_or(|value| value != "write") {
        return;
    }
    page.eval("{ const t = document.getElementById('target'); t.textContent = t.textContent.split(',')[0]; }");
    let board = page.eval("document.getElementById('target').textContent");
    assert_eq!(board, "mps2", "the page does not say first which board it shows");
    page.picture(&PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../docs/live-page.png"));
}

/// What the gripper told while the page was open.
#[derive(Default)]
pub struct Stream {
    pub reports: Vec<Report>,
    pub grasps: Vec<Grasp>,
}

/// What is found in the stream. On a busy PC the page may have shown it before it is kept here.
pub fn found<T>(stream: &Mutex<Stream>, find: impl Fn(&Stream) -> Option<T>) -> Option<T> {
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
pub fn on_page(
    servos: Vec<Config>,
    settings: &Settings,
    objects: &[ObjectDesign],
    visit: impl FnOnce(&mut Browser, &str, &Mutex<Stream>, &fre_gripper::link::Link),
) {
    on_page_of(&Machine::boot_all(servos), settings, objects, visit);
}

/// The same of a machine that the visit may meddle with.
pub fn on_page_of(
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

struct OnDrop<'a>(&'a AtomicBool);

impl Drop for OnDrop<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}
