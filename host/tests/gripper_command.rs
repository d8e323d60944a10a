//! `fre gripper` and `fre monitor` on the real firmware in QEMU, as a script uses them.
//!
//! `cargo xtask test system` builds the firmware, names it in `FRE_FIRMWARE_ELF`, and runs these ignored tests.

use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};

use host::case::preset;
use host::servo::{Clock, Config, Hub, Load, Running, Servo};
use model_core::object::ObjectDesign;

/// Of the case below.
const OBJECT: ObjectDesign = ObjectDesign::Circle { centre: [41.0, 45.0], radius: 40.0 };
const CASE: &str = "finger = \"preset:ladder-80\"\n[object]\nshape = \"circle\"\nradius_mm = 40.0\ncentre_mm = [41.0, 45.0]\n\
    [motion]\nmotor_angles_deg = [6.0]\n";
/// How long anything may take, a busy PC included.
const PATIENCE: Duration = Duration::from_secs(60);

/// A gripper in QEMU; its servo's time passes by its position's reads.
struct Gripper {
    qemu: Child,
    folder: PathBuf,
    _bus: Running,
}

impl Gripper {
    fn boot(name: &str) -> Self {
        let elf =
            std::env::var_os("FRE_FIRMWARE_ELF").expect("FRE_FIRMWARE_ELF; run this by `cargo xtask test system`");
        let folder = std::env::temp_dir().join(format!("fre-command-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let mut command = Command::new("qemu-system-arm");
        command.args(["-machine", "mps2-an500", "-display", "none", "-monitor", "none"]);
        command.args(["-semihosting-config", "enable=on,target=native"]);
        for name in ["bus", "link"] {
            let socket = format!("socket,id={name},path={},server=on,wait=off", folder.join(name).display());
            command.args(["-chardev", &socket, "-serial", &format!("chardev:{name}")]);
        }
        let qemu = command.arg("-kernel").arg(elf).stdin(Stdio::null()).stdout(Stdio::null()).spawn();
        let qemu = qemu.expect("qemu-system-arm; `cargo xtask setup` installs it");
        let design = preset("ladder-80").unwrap().unwrap().design;
        let load = Arc::new(Load::of(&design, OBJECT, &Load::REFERENCE, 14.0).unwrap());
        let clock = Clock::Requests { period_us: 2_000 };
        let servo =
            Config { baud_rate: 1_000_000, clock, start_deg: Some(-1.0), noise_ma: 5.0, load, ..Config::default() };
        let mut hub = Hub::new();
        let end = Instant::now() + PATIENCE;
        while let Err(error) = hub.connect_unix(&folder.join("bus")) {
            assert!(Instant::now() < end, "QEMU does not open its bus: {error}");
            std::thread::sleep(Duration::from_millis(10));
        }
        hub.servo(Servo::new(servo).unwrap());
        let bus = hub.spawn().unwrap();
        Self { qemu, folder, _bus: bus }
    }

    /// `fre …` on its link: exit status, output, errors.
    fn fre(&self, words: &[&str]) -> (Option<i32>, String, String) {
        let link = format!("unix:{}", self.folder.join("link").display());
        let output = Command::new(env!("CARGO_BIN_EXE_fre")).args(words).args(["--link", &link]).output().unwrap();
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        (output.status.code(), text(&output.stdout), text(&output.stderr))
    }

    /// The same, which must go well.
    fn done(&self, words: &[&str]) -> String {
        let (code, out, errors) = self.fre(words);
        assert_eq!(code, Some(0), "{words:?}: {out}{errors}");
        out
    }

    /// A motion, which must go well at last: a busy PC loses the servo for a moment now and then, which is said.
    fn moved(&self, words: &[&str]) -> String {
        let end = Instant::now() + 2 * PATIENCE;
        loop {
            let (code, out, errors) = self.fre(words);
            match code {
                Some(0) => return out,
                Some(1) => assert!(errors.contains("no servo answers"), "{words:?}: {out}{errors}"),
                _ => assert!(out.contains("held"), "{words:?}: {out}{errors}"),
            }
            assert!(Instant::now() < end, "{words:?}: {out}{errors}");
            std::thread::sleep(Duration::from_millis(200));
        }
    }
}

impl Drop for Gripper {
    fn drop(&mut self) {
        let _ = self.qemu.kill();
        let _ = self.qemu.wait();
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

#[test]
#[ignore = "needs the firmware: cargo xtask test system"]
fn a_script_sets_grips_holds_and_releases() {
    let gripper = Gripper::boot("script");
    let info = gripper.done(&["gripper", "info"]);
    for words in ["mps2", "protocol", "room for", "started because", "estimates", "bus", "link"] {
        assert!(info.contains(words), "no {words}: {info}");
    }
    let before = gripper.done(&["gripper", "get"]);
    assert!(before.contains("rate_hz = 500") && before.contains("finger 0: no design"), "{before}");

    let case = gripper.folder.join("case.toml");
    std::fs::write(&case, CASE).unwrap();
    let case = case.to_str().unwrap();
    gripper.done(&["gripper", "set", "rate_hz=400", "finger.0.force_limit_n=8.5", "--case", case]);
    let after = gripper.done(&["gripper", "get"]);
    for words in ["rate_hz = 400", "finger.0.force_limit_n = 8.5", "7 lamellae", "circle, radius_mm = 40"] {
        assert!(after.contains(words), "no {words}: {after}");
    }
    // What is wrong is named, by this program or by the gripper, and changes nothing.
    for (pair, words) in [
        ("finger.0.colour=red", "is no key"),
        ("finger.0.side=up", "left or right"),
        ("rate_hz=4000", "4000"),
        ("finger.0.force_limit_n=-1", "-1"),
    ] {
        let (code, _, errors) = gripper.fre(&["gripper", "set", pair]);
        assert!(code == Some(1) && errors.contains(words), "{pair}: {code:?} {errors}");
    }
    assert_eq!(gripper.done(&["gripper", "get"]), after);
    let (code, _, errors) = gripper.fre(&["gripper", "grip", "--force-n", "9"]);
    assert!(code == Some(1) && errors.contains('9'), "beyond its limit: {code:?} {errors}");

    let gripped = gripper.moved(&["gripper", "grip", "--force-n", "4", "--wait", "60"]);
    assert!(gripped.starts_with("finger 0") && gripped.contains("gripped"), "{gripped}");
    let force: f64 = gripped.split_whitespace().nth(2).and_then(|word| word.parse().ok()).unwrap();
    assert!((force - 4.0).abs() < 0.4, "{gripped}");
    gripper.moved(&["gripper", "hold"]);
    assert!(lines_until(&gripper, "held").contains("held"));
    gripper.moved(&["gripper", "release", "--finger", "0"]);
    lines_until(&gripper, ",released,");
    assert_eq!(gripper.fre(&["gripper", "release", "--finger", "3"]).0, Some(1));

    let found = gripper.moved(&["gripper", "scan"]);
    assert!(found.contains("id 1: model 1020, firmware 45, answers at 1000000 baud"), "{found}");
    assert!(found.trim_end().ends_with("devices"), "{found}");
    let (code, _, errors) = gripper.fre(&["gripper", "set", "object=free"]);
    assert!(code == Some(1) && errors.contains("number of fingers"), "one finger holds nothing: {errors}");
}

/// A finger told of an object 7 mm too high finds by closing on it where it is; and one told of a smaller one, how large.
#[test]
#[ignore = "needs the firmware: cargo xtask test system"]
fn closing_tells_where_a_round_object_is() {
    let gripper = Gripper::boot("identify");
    let case = gripper.folder.join("case.toml");
    let set = |centre: [f64; 2], radius: f64| {
        let text = CASE.replace("radius_mm = 40.0", &format!("radius_mm = {radius:.1}"));
        std::fs::write(&case, text.replace("[41.0, 45.0]", &format!("{centre:?}"))).unwrap();
        gripper.done(&["gripper", "set", "--case", case.to_str().unwrap()]);
    };
    gripper.done(&["gripper", "set", "finger.0.open_deg=-6", "finger.0.least_deg=-7"]);
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
    // What is wrong is named.
    for (words, said) in [
        (["--range-mm", "60:30", "--to-deg", "9"], "LEAST < MOST"),
        (["--range-mm", "30:60", "--to-deg", "900"], "900"),
        (["--finger", "3", "--range-mm", "30:60"], "to-deg"),
    ] {
        let (code, _, errors) = gripper.fre(&[["gripper", "identify", "height"].as_slice(), &words].concat());
        assert!(code == Some(1) && errors.contains(said), "{words:?}: {code:?} {errors}");
    }
    // The object is nowhere in the range: said, by status 2.
    let (code, out, errors) =
        gripper.fre(&["gripper", "identify", "height", "--range-mm", "60:70", "--to-deg", "9", "--wait", "120"]);
    assert!(code == Some(2) && out.contains("positions seen"), "{code:?} {out}{errors}");
}

/// What the CSV of `fre monitor` says as soon as some row has a word.
fn lines_until(gripper: &Gripper, word: &str) -> String {
    let end = Instant::now() + PATIENCE;
    let log = gripper.folder.join("log.csv");
    loop {
        let lines = gripper.done(&["monitor", "--seconds", "0.5", "--every", "1", "--log", log.to_str().unwrap()]);
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
#[ignore = "needs the firmware: cargo xtask test system"]
fn the_terminal_shows_it_live_and_space_stops() {
    use std::io::{Read, Write};

    let gripper = Gripper::boot("terminal");
    let case = gripper.folder.join("case.toml");
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
    let link = format!("unix:{}", gripper.folder.join("link").display());
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
    let end = Instant::now() + PATIENCE;
    while !plain(&seen.lock().unwrap()).contains("all fingers hold") {
        assert!(Instant::now() < end, "{}", plain(&seen.lock().unwrap()));
        writer.write_all(b" ").unwrap();
        std::thread::sleep(Duration::from_secs(1));
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
