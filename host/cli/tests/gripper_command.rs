//! `fre gripper`, `fre monitor`, `fre calibrate --send` and `fre log --qemu` on the real firmware in QEMU, as a script uses them.
//!
//! `cargo xtask test system` builds the firmware, names it in `FRE_FIRMWARE_ELF`, and turns the feature `qemu` on.

#[path = "gripper_command/run.rs"]
mod run;
mod said;
mod transcript;

use std::cell::RefCell;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use fre::case::preset;
use fre::fit::calibrate::synthetic::{Errors, Protocol, draw};
use fre::fit::calibrate::{Parameter, Predictor, Trial};
use fre_gripper::servo::{Clock, Config, Gains, Hub, Load, Running, Servo};
use fre_qemu::{Machine, Running as Board, Sockets};
use model_core::discretise::{Discretisation, Physics};
use model_core::drive::Drive;
use model_core::object::ObjectDesign;
use test_bus::Tries;

use transcript::Transcript;

/// Of the case below.
const OBJECT: ObjectDesign = ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 };
const CASE: &str = "finger = \"preset:ladder-80\"\n[object]\nshape = \"circle\"\nradius_mm = 40.0\ncentre_mm = [41.0, 45.0]\n\
    [motion]\nmotor_angles_deg = [6.0]\n";
/// How long anything may take, a busy PC included.
const PATIENCE: Duration = Duration::from_secs(60);

fn firmware() -> String {
    std::env::var("FRE_FIRMWARE_ELF").expect("FRE_FIRMWARE_ELF; run this by `cargo xtask test system`")
}

/// `fre …`: exit status, output, errors.
fn fre(words: &[&str]) -> (Option<i32>, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_fre")).args(words).env("COLUMNS", "100").output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

/// A gripper in QEMU; its servo's time passes by its position's reads.
struct Gripper {
    _board: Board,
    sockets: Sockets,
    _bus: Running,
    said: RefCell<Transcript>,
    _turn: MutexGuard<'static, ()>,
}

/// Grippers share the processors with their tests: one at a time.
static TURN: Mutex<()> = Mutex::new(());

impl Gripper {
    fn boot() -> Self {
        let turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
        let sockets = Sockets::new().unwrap();
        let mut board = Machine::new(firmware()).listening(&sockets).boot(Stdio::null()).unwrap();
        let design = preset("ladder-80").unwrap().unwrap().design;
        let load = Arc::new(Load::of(&design, OBJECT, &Drive::Rotating, &Load::REFERENCE, 14.0).unwrap());
        let clock = Clock::Requests { period_us: 2_000 };
        let servo = Config {
            baud_rate: 1_000_000,
            clock,
            start_deg: Some(-1.0),
            noise_ma: 5.0,
            load,
            gains: Gains::GREATEST,
            ..Config::default()
        };
        let mut hub = Hub::new();
        board.until("connection to the bus", PATIENCE, || hub.connect_unix(&sockets.bus())).unwrap();
        hub.servo(Servo::new(servo).unwrap());
        let bus = hub.spawn().unwrap();
        let gripper = Self { _board: board, sockets, _bus: bus, said: RefCell::default(), _turn: turn };
        // Idle at first; nobody is asked where no person is.
        for (words, code) in [
            (&["gripper", "hold"][..], 1),
            (&["gripper", "commission"], 1),
            (&["gripper", "commission", "--yes", "--servo", "9"], 1),
            (&["gripper", "commission", "--yes"], 0),
        ] {
            gripper.keep(words, code);
        }
        gripper.compare(snapbox::file!["words/commission.txt"]);
        gripper.done(&["gripper", "set", "finger.0.current_limit_ma=2000"]);
        gripper
    }

    /// `fre …` on its link: exit status, output, errors.
    fn fre(&self, words: &[&str]) -> (Option<i32>, String, String) {
        fre(&[words, &["--link", &self.link()]].concat())
    }

    /// The same with the status that is expected, and what it says kept for the transcript.
    fn keep(&self, words: &[&str], expected: i32) -> String {
        let (code, out, errors) = self.fre(words);
        assert_eq!(code, Some(expected), "{words:?}: {out}{errors}");
        let text = format!("{out}{errors}");
        self.add(&words.join(" "), code, &text);
        out
    }

    fn add(&self, words: &str, code: Option<i32>, text: &str) {
        let folder = self.sockets.folder();
        self.said.borrow_mut().add(&format!("fre {words}"), folder, (code, text));
    }

    /// Compares what was kept so far.
    fn compare(&self, expected: snapbox::Data) {
        snapbox::assert_data_eq!(self.said.take().text(), expected.raw());
    }

    fn link(&self) -> String {
        format!("unix:{}", self.sockets.link().display())
    }

    /// The same, which must go well.
    fn done(&self, words: &[&str]) -> String {
        let (code, out, errors) = self.fre(words);
        assert_eq!(code, Some(0), "{words:?}: {out}{errors}");
        out
    }

    /// A motion, which must go well at last: a busy PC loses the servo for a moment now and then, which is reported.
    fn moved(&self, words: &[&str]) -> String {
        let mut tries = Tries::of("a motion");
        loop {
            let (code, out, errors) = self.fre(words);
            match code {
                Some(0) => return out,
                Some(1) => assert!(
                    ["no servo answers", "the servo was lost", "no sound answer"]
                        .iter()
                        .any(|why| errors.contains(why)),
                    "{words:?}: {out}{errors}"
                ),
                _ => assert!(out.contains("held"), "{words:?}: {out}{errors}"),
            }
            eprintln!("{words:?}: {out}{errors}");
            tries.spoilt();
            std::thread::sleep(Duration::from_millis(500));
        }
    }
}

#[test]
fn a_script_sets_grips_holds_and_releases() {
    let gripper = Gripper::boot();
    let info = gripper.done(&["gripper", "info"]);
    gripper.add("gripper info", Some(0), &said::words(&info));
    gripper.keep(&["gripper", "get"], 0);
    let case = gripper.sockets.folder().join("case.toml");
    std::fs::write(&case, CASE).unwrap();
    let case = case.to_str().unwrap();
    gripper.keep(&["gripper", "set", "rate_hz=400", "finger.0.force_limit_n=8.5", "--case", case], 0);
    let after = gripper.keep(&["gripper", "get"], 0);
    // What is wrong is named, by this program or by the gripper, and changes nothing.
    for wrong in ["finger.0.colour=red", "finger.0.side=up", "rate_hz=4000", "finger.0.force_limit_n=-1", "object=free"]
    {
        gripper.keep(&["gripper", "set", wrong], 1);
    }
    assert_eq!(gripper.done(&["gripper", "get"]), after);
    gripper.keep(&["gripper", "grip", "--force-n", "9"], 1);
    // One finger holds nothing.
    gripper.keep(&["gripper", "grip", "--hold-mass-kg", "0.3", "--gravity-deg", "normal"], 1);
    gripper.keep(&["gripper", "release", "--finger", "3"], 1);

    let gripped = gripper.moved(&["gripper", "grip", "--force-n", "4", "--wait", "60"]);
    // Which of the two trustworthy statuses the last tick had depends on the PC.
    let said = said::words(&gripped.replace(" tracking ", " converged "));
    gripper.add("gripper grip --force-n 4 --wait 60", Some(0), &said);
    let force: f64 = gripped.split_whitespace().nth(2).and_then(|word| word.parse().ok()).unwrap();
    assert!((force - 4.0).abs() < 0.4, "{gripped}");
    gripper.moved(&["gripper", "hold"]);
    assert!(lines_until(&gripper, "held").contains("held"));
    gripper.moved(&["gripper", "release", "--finger", "0"]);
    lines_until(&gripper, ",released,");

    let found = gripper.moved(&["gripper", "scan"]);
    gripper.add("gripper scan", Some(0), &said::words(&found));
    gripper.compare(snapbox::file!["words/gripper.txt"]);
}

/// A finger told of an object 7 mm too high finds by closing on it where it is; and one told of a smaller one, how large.
#[test]
fn closing_tells_where_a_round_object_is() {
    let gripper = Gripper::boot();
    let case = gripper.sockets.folder().join("case.toml");
    let set = |centre: [f64; 2], radius: f64| {
        let text = CASE.replace("radius_mm = 40.0", &format!("radius_mm = {radius:.1}"));
        std::fs::write(&case, text.replace("[41.0, 45.0]", &format!("{centre:?}"))).unwrap();
        gripper.done(&["gripper", "set", "--case", case.to_str().unwrap()]);
    };
    // A motion of some seconds, of a gripper that soon stops those of hosts that are gone.
    let silence = ["on_silence=hold", "silence_ms=500"];
    gripper.done(&[&["gripper", "set", "finger.0.open_deg=-6", "finger.0.least_deg=-7"], &silence[..]].concat());
    for (centre, radius, unknown, range, truth, allowed) in [
        ([41.0, 52.0], 40.0, "height", "30:60", 45.0, 1.0),
        ([31.0, 45.0], 30.0, "radius-behind-side", "20:60", 40.0, 2.0),
    ] {
        set(centre, radius);
        let words = ["gripper", "identify", unknown, "--range-mm", range, "--to-deg", "9", "--wait", "120"];
        let found = gripper.moved(&words);
        let numbers: Vec<f64> = found.lines().next().unwrap().split(' ').filter_map(|word| word.parse().ok()).collect();
        let [value, deviation] = numbers.as_slice() else { panic!("{found}") };
        eprintln!("{found}");
        assert!((value - truth).abs() < allowed && *deviation > 0.01 && *deviation < allowed, "{found}");
    }
    // Set, it is the gripper's object.
    set([41.0, 52.0], 40.0);
    let words = ["gripper", "identify", "height", "--range-mm", "30:60", "--to-deg", "9", "--wait", "120", "--set"];
    let found = gripper.moved(&words);
    let height = found.split_whitespace().nth(1).unwrap().to_owned();
    let objects = gripper.done(&["gripper", "get"]);
    let whole = height.split('.').next().unwrap();
    assert!(objects.contains(&format!("centre_mm = [41.0, {whole}")), "{height}: {objects}");
    // What is wrong is named; so is, by status 2, that the object is nowhere in the range.
    for (wrong, code) in [
        ("--range-mm 60:30 --to-deg 9", 1),
        ("--range-mm 30:60 --to-deg 900", 1),
        ("--finger 3 --range-mm 30:60", 1),
        ("--range-mm 60:70 --to-deg 9 --wait 120", 2),
    ] {
        let command = format!("gripper identify height {wrong}");
        let (found, out, errors) = gripper.fre(&command.split(' ').collect::<Vec<_>>());
        assert_eq!(found, Some(code), "{command}: {out}{errors}");
        gripper.add(&command, found, &if code == 1 { errors } else { said::words(&format!("{out}{errors}")) });
    }
    gripper.compare(snapbox::file!["words/identify.txt"]);
}

/// What the CSV of `fre monitor` says as soon as some row has a word.
fn lines_until(gripper: &Gripper, word: &str) -> String {
    let end = Instant::now() + PATIENCE;
    let log = gripper.sockets.folder().join("log.csv");
    loop {
        let lines =
            gripper.done(&["monitor", "--seconds", "0.5", "--every", "1", "--force", "--log", log.to_str().unwrap()]);
        // No terminal: a heading, then a line per report.
        assert!(lines.contains("force_n") && lines.contains("reports,"), "{lines}");
        let rows = std::fs::read_to_string(&log).unwrap();
        if rows.contains(word) {
            return rows;
        }
        assert!(Instant::now() < end, "no {word}: {rows}");
    }
}

#[test]
fn the_terminal_shows_it_live_and_space_stops() {
    use std::io::{Read, Write};

    let gripper = Gripper::boot();
    let case = gripper.sockets.folder().join("case.toml");
    std::fs::write(&case, CASE).unwrap();
    gripper.done(&["gripper", "set", "--case", case.to_str().unwrap()]);
    gripper.moved(&["gripper", "grip", "--force-n", "4", "--wait", "60"]);

    // A pseudo-terminal of 100 × 30.
    let master = rustix::pty::openpt(rustix::pty::OpenptFlags::RDWR | rustix::pty::OpenptFlags::NOCTTY).unwrap();
    rustix::pty::grantpt(&master).unwrap();
    rustix::pty::unlockpt(&master).unwrap();
    let size = rustix::termios::Winsize { ws_row: 30, ws_col: 100, ws_xpixel: 0, ws_ypixel: 0 };
    rustix::termios::tcsetwinsize(&master, size).unwrap();
    let name = rustix::pty::ptsname(&master, Vec::new()).unwrap();
    let side = || std::fs::File::options().read(true).write(true).open(name.to_str().unwrap()).unwrap();
    let link = format!("unix:{}", gripper.sockets.link().display());
    let mut command = Command::new(env!("CARGO_BIN_EXE_fre"));
    command.args(["monitor", "--link", &link]).env("TERM", "xterm-256color");
    let mut monitor = command.stdin(side()).stdout(side()).stderr(side()).spawn().unwrap();
    drop(command);
    let mut master = std::fs::File::from(master);
    let mut writer = master.try_clone().unwrap();
    let seen = Arc::new(std::sync::Mutex::new(String::new()));
    let reading = std::thread::spawn({
        let seen = seen.clone();
        move || {
            let mut chunk = [0; 4096];
            // The end of a pseudo-terminal is an error of reading.
            while let Ok(count @ 1..) = master.read(&mut chunk) {
                seen.lock().unwrap().push_str(&String::from_utf8_lossy(&chunk[..count]));
            }
        }
    });
    let until = |words: &str| {
        let end = Instant::now() + PATIENCE;
        while !plain(&seen.lock().unwrap()).contains(words) {
            assert!(Instant::now() < end, "no `{words}` in {}", plain(&seen.lock().unwrap()));
            std::thread::sleep(Duration::from_millis(50));
        }
    };
    for words in ["live", "converged", "components", "iterations", "STOP all fingers"] {
        until(words);
    }
    let holds = || plain(&seen.lock().unwrap()).contains("all fingers hold");
    let mut tries = Tries::of("a stop from the terminal");
    loop {
        writer.write_all(b" ").unwrap();
        let end = Instant::now() + Duration::from_secs(10);
        while !holds() && Instant::now() < end {
            std::thread::sleep(Duration::from_millis(50));
        }
        if holds() {
            break;
        }
        eprintln!("{}", plain(&seen.lock().unwrap()));
        tries.spoilt();
    }
    writer.write_all(b"q").unwrap();
    let end = Instant::now() + PATIENCE;
    let status = loop {
        if let Some(status) = monitor.try_wait().unwrap() {
            break status;
        }
        assert!(Instant::now() < end, "q does not end it");
        std::thread::sleep(Duration::from_millis(50));
    };
    assert!(status.success());
    until("reports,");
    drop(writer);
    reading.join().unwrap();
    assert!(lines_until(&gripper, "held").contains("held"));
}

/// The words, without what moves the cursor (also over a blank that is there already) and colours the letters.
fn plain(text: &str) -> String {
    let mut plain = String::new();
    let mut letters = text.chars();
    while let Some(letter) = letters.next() {
        if letter == '\u{1b}' {
            // A control sequence ends with a letter.
            letters.by_ref().skip(1).find(char::is_ascii_alphabetic);
            plain.push(' ');
        } else {
            plain.push(letter);
        }
    }
    plain.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Measurements of three cylinders as files: CSVs and their cases. The truth: 46 MPa, 0.6°, (0.8, −0.5) mm.
fn measured(folder: &Path) -> Vec<(String, String)> {
    let design = preset("ladder-80").unwrap().unwrap().design;
    let model = Predictor {
        design: &design,
        discretisation: Discretisation::reduced(Physics::Extended),
        drive: Drive::Rotating,
        prony: &[],
    };
    let parameters = vec![Parameter::YoungsModulus, Parameter::Zero, Parameter::ObjectX, Parameter::ObjectY];
    let truth = Trial { parameters, values: vec![46.0, 0.6, 0.8, -0.5] };
    let protocol = Protocol::cylinders(&[[20.0, 10.0], [65.0, 10.0], [45.0, 40.0]], 16);
    let runs = draw(&model, &truth, &protocol, Errors::USUAL, 11).unwrap();
    let files = runs.iter().enumerate().map(|(index, run)| {
        let rows = run.readings.iter().map(|reading| format!("{},{}\n", reading.angle_deg, reading.force_n.unwrap()));
        let table = folder.join(format!("{index}.csv"));
        std::fs::write(&table, format!("motor_angle_deg,force_n\n{}", rows.collect::<String>())).unwrap();
        let ObjectDesign::Circle { centre: [x, y], radius } = run.object else { panic!("a circle") };
        let case = folder.join(format!("{index}.toml"));
        let object = format!("shape = \"circle\"\nradius_mm = {radius:?}\ncentre_mm = [{x:?}, {y:?}]");
        let words = format!("finger = \"preset:ladder-80\"\n[object]\n{object}\n[motion]\nmotor_angles_deg = [6.0]\n");
        std::fs::write(&case, words).unwrap();
        (table.display().to_string(), case.display().to_string())
    });
    files.collect()
}

#[test]
fn a_calibration_reaches_the_gripper() {
    let gripper = Gripper::boot();
    let files = measured(gripper.sockets.folder());
    let value = |text: &str, key: &str| -> f64 {
        let words = text.lines().find_map(|line| line.strip_prefix(&format!("{key} = "))).map(str::to_owned);
        words.and_then(|words| words.parse().ok()).unwrap_or_else(|| panic!("no {key}: {text}"))
    };
    let before = gripper.keep(&["gripper", "get"], 0);
    let zero = value(&before, "finger.0.zero_counts");
    let link = gripper.link();
    let send = |options: &[&str], which: &[(String, String)]| {
        let tables = which.iter().map(|(table, _)| table.as_str());
        let cases = which.iter().flat_map(|(_, case)| ["--case", case.as_str()]);
        let words: Vec<&str> = ["calibrate"].into_iter().chain(tables).chain(cases).collect();
        let result = fre(&[&words, ["--elements", "reduced", "--send", &link].as_slice(), options].concat());
        let (code, out, errors) = &result;
        let command = [&words, options].concat().join(" ");
        gripper.add(&command, *code, &said::words(&errors.replace(&link, "LINK")));
        assert!(*code != Some(0) || !out.is_empty(), "{errors}");
        result
    };
    // What it has after a calibration, but for the figures that were fitted.
    let kept = || {
        let after = gripper.done(&["gripper", "get"]);
        let is_fitted = |line: &&str| line.contains("zero_counts") || line.contains("calibrated to");
        let (fitted, set): (Vec<&str>, Vec<&str>) = after.lines().partition(is_fitted);
        gripper.add("gripper get", Some(0), &format!("{}\n{}", set.join("\n"), said::words(&fitted.join("\n"))));
        after
    };

    // A few low forces in one place tell too little: nothing is sent, and it says so.
    let few = std::fs::read_to_string(&files[2].0).unwrap().lines().take(4).collect::<Vec<_>>().join("\n");
    let table = gripper.sockets.folder().join("few.csv").display().to_string();
    std::fs::write(&table, few).unwrap();
    assert_eq!(send(&[], &[(table, files[2].1.clone())]).0, Some(2));
    assert_eq!(gripper.done(&["gripper", "get"]), before);
    assert_eq!(send(&["--finger", "3"], &files).0, Some(1));
    assert_eq!(gripper.done(&["gripper", "get"]), before);

    let (code, out, errors) = send(&[], &files);
    assert_eq!(code, Some(0), "{out}{errors}");
    // Which of the three objects it has nobody knows: it gets none.
    let after = kept();
    let moved = value(&after, "finger.0.zero_counts") - zero;
    assert!((moved + 0.6 * 4096.0 / 360.0).abs() < 1.2, "0.6° are −6.8 counts: {moved}");
    // What the fit's own table says.
    let stated =
        out.lines().find_map(|line| line.trim().strip_prefix("uncertainty")).expect("the fit's uncertainty").trim();
    let deviation = stated.strip_prefix("zero ").and_then(|rest| rest.split('°').next()).expect("a zero");
    assert!(after.contains(&format!("finger 0: calibrated to zero {deviation}°")), "{stated}: {after}");
    assert!(deviation.parse::<f64>().unwrap() < 0.05, "{after}");

    // Again: the zero is a difference, which is not added twice.
    assert_eq!(send(&[], &files).0, Some(0));
    assert_eq!(gripper.done(&["gripper", "get"]), after);

    // One object: it goes along.
    let (code, out, errors) = send(&["--fit", "youngs-modulus"], &files[2..]);
    assert_eq!(code, Some(0), "{out}{errors}");
    kept();

    // So does its friction.
    let (table, case) = &files[2];
    let rough = gripper.sockets.folder().join("rough.toml").display().to_string();
    let words = std::fs::read_to_string(case).unwrap().replace("radius_mm", "friction = 0.1\nradius_mm");
    std::fs::write(&rough, words).unwrap();
    let (code, out, errors) = send(&["--fit", "youngs-modulus", "--on-top"], &[(table.clone(), rough)]);
    assert_eq!(code, Some(0), "{out}{errors}");
    kept();
    gripper.compare(snapbox::file!["words/calibrate_send.txt"]);
}

#[test]
fn the_log_out_of_qemu_is_shown() {
    let image = firmware();
    // How long the first line takes depends on the PC.
    let shown = [2, 10, 60].iter().find_map(|seconds| {
        let (code, out, errors) = fre(&["log", "--qemu", "--image", &image, "--seconds", &seconds.to_string()]);
        assert_eq!(code, Some(0), "{out}{errors}");
        (!out.is_empty()).then_some(out)
    });
    let shown = shown.expect("a line within a minute");
    let line = shown.lines().next().unwrap();
    assert!(line.trim_start().starts_with("0.") && line.contains(" INFO "), "time and level: {line}");
    assert!(line.contains("gripper on mps2-an500, version") && line.contains("gripper.rs:"), "words and place: {line}");

    let mut said = Transcript::default();
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let manifest = here.join("Cargo.toml").display().to_string();
    // An image that is not there, a file that is none, a board and QEMU, neither.
    for words in [
        &["log", "--qemu", "--image", "/nowhere/gripper"][..],
        &["log", "--qemu", "--image", &manifest],
        &["log", "opencr", "--qemu"],
        &["log"],
    ] {
        let (code, _, errors) = fre(words);
        assert_eq!(code, Some(1), "{words:?}: {errors}");
        said.add(&format!("fre {}", words.join(" ")), here, (code, &errors));
    }
    snapbox::assert_data_eq!(said.text(), snapbox::file!["words/log.txt"].raw());
}

/// A program that is asked to stop when this is dropped.
struct Program(std::process::Child);

impl Program {
    fn start(words: &[&str]) -> (Self, impl Iterator<Item = String> + use<>) {
        let mut child =
            Command::new(env!("CARGO_BIN_EXE_fre")).args(words).stdout(Stdio::piped()).spawn().expect("a program");
        let lines = std::io::BufRead::lines(std::io::BufReader::new(child.stdout.take().expect("its output")));
        (Self(child), lines.map_while(Result::ok))
    }

    fn stop(&mut self) -> Option<i32> {
        let asked = Command::new("kill").args(["-INT", &self.0.id().to_string()]).status();
        assert!(asked.is_ok_and(|status| status.success()));
        self.0.wait().ok().and_then(|status| status.code())
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// `fre sim` is a gripper; while one program shows it, others use it through that, as its link has one user.
#[test]
fn a_simulated_gripper_serves_several_programs() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let folder = tempfile::tempdir().unwrap();
    let case = folder.path().join("case.toml");
    std::fs::write(&case, CASE).unwrap();
    let case = case.to_str().unwrap();
    let (code, _, errors) = fre(&["sim", case, "--firmware", "/nowhere"]);
    assert_eq!(code, Some(1));
    snapbox::assert_data_eq!(
        errors,
        snapbox::str![[r#"
fre: /nowhere is not a file; `cargo xtask firmware mps2` builds it

"#]]
    );
    let firmware = firmware();
    let coarse = ["--elements", "reduced", "--scheme", "simpson"];
    let (mut sim, mut lines) = Program::start(&[&["sim", case, "--firmware", &firmware], &coarse[..]].concat());
    let link = lines.next().expect("its link");
    let link = link.strip_prefix("link ").expect("a line with the link").to_owned();
    assert!(lines.any(|line| line == "ready"));
    let (mut view, mut shown) = Program::start(&["monitor", "--link", &link, "--lines"]);
    assert!(shown.any(|line| line.contains("no-contact") || line.contains("converged")), "the view shows something");
    for words in [&["gripper", "info"][..], &["gripper", "get"], &["gripper", "hold"]] {
        let (code, out, errors) = fre(&[words, &["--link", &link]].concat());
        assert_eq!(code, Some(0), "{words:?} while a view is open: {out}{errors}");
    }
    assert_eq!(view.stop(), Some(0));
    let (code, out, errors) = fre(&["gripper", "get", "--link", &link]);
    assert!(code == Some(0) && out.contains("role = master"), "{code:?} {out}{errors}");
    assert_eq!(sim.stop(), Some(0));
}
