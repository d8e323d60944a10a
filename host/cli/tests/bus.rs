//! `fre monitor --bus`: the estimator of this PC on simulated servos behind a pseudo-terminal.

#[path = "../../gripper/tests/servo_case/mod.rs"]
mod servo_case;

use std::collections::BTreeSet;
use std::io::{BufRead, BufReader, Read};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use dynamixel::{Decoder, Instruction};
use fre_gripper::servo::{Config, Gains, Handle, Hub, Running, Servo};
use messages::Event;
use model_core::uncertainty::Uncertainty;
use servo_case::load;

/// A bus with servos: its port, the servos from outside, and one who hears everything.
struct Bus {
    port: PathBuf,
    servos: Vec<Handle>,
    ear: UnixStream,
    _running: Running,
}

impl Bus {
    fn new(configs: impl IntoIterator<Item = Config>) -> Self {
        let mut hub = Hub::new();
        let servos = configs.into_iter().map(|config| hub.servo(Servo::new(config).unwrap())).collect();
        let (port, ear) = (hub.pty().unwrap(), hub.stream().unwrap());
        ear.set_nonblocking(true).unwrap();
        Self { port, servos, ear, _running: hub.spawn().unwrap() }
    }

    fn port(&self) -> &str {
        self.port.to_str().unwrap()
    }

    /// Which instructions were heard so far.
    fn instructions(&mut self) -> BTreeSet<u8> {
        let mut bytes = Vec::new();
        let end = self.ear.read_to_end(&mut bytes).unwrap_err();
        assert_eq!(end.kind(), std::io::ErrorKind::WouldBlock);
        let (mut decoder, mut rest, mut codes) = (Decoder::<512>::new(), bytes.as_slice(), BTreeSet::new());
        while let Some(packet) = decoder.feed(&mut rest) {
            codes.extend(packet.ok().map(|packet| packet.code));
        }
        codes
    }
}

fn fre(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_fre")).args(args).output().unwrap()
}

fn words(output: &Output) -> (String, String) {
    (String::from_utf8_lossy(&output.stdout).into_owned(), String::from_utf8_lossy(&output.stderr).into_owned())
}

/// A file of this test's own.
fn file(name: &str, text: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("bus-{name}"));
    std::fs::write(&path, text).unwrap();
    path
}

const CASE: &str =
    "finger = \"preset:ladder-80\"\n[object]\nshape = \"circle\"\nradius_mm = 40.0\ncentre_mm = [41.0, 45.0]\n";

fn case(name: &str, angles: &str) -> PathBuf {
    file(name, &format!("{CASE}[motion]\nmotor_angles_deg = [{angles}]\n"))
}

/// Column of a row of the CSV.
fn column(text: &str, name: &str, row: &str) -> String {
    let index = text.lines().next().unwrap().split(',').position(|column| column == name).unwrap();
    row.split(',').nth(index).unwrap().to_owned()
}

/// Servos at rest in contact: one as the other, but for how they are mounted.
fn gripping(id: u8, firmware: u8, zero_count: u16, closing_up: bool) -> Config {
    let load = load([41.0, 45.0], 13.0);
    let start_deg = Some(9.0 + f64::from(id));
    Config {
        id,
        firmware,
        zero_count,
        closing_up,
        start_deg,
        load,
        baud_rate: 1_000_000,
        gains: Gains::GREATEST,
        ..Config::default()
    }
}

#[test]
fn the_force_is_what_solve_says_at_the_angle_that_was_read() {
    // Both know fast reads; one does not; a single one.
    let fast = vec![gripping(1, 45, 2048, true), gripping(2, 45, 1000, false)];
    let slow = vec![gripping(1, 45, 2048, true), gripping(2, 44, 1000, false)];
    let alone = vec![gripping(2, 45, 1000, false)];
    let read = [Instruction::FastSyncRead, Instruction::SyncRead, Instruction::FastSyncRead];
    for ((name, configs), read) in [("fast", fast), ("slow", slow), ("alone", alone)].into_iter().zip(read) {
        let count = configs.len();
        let mut bus = Bus::new(configs);
        let (csv, settings) = (file(&format!("{name}.csv"), ""), file(&format!("{name}.settings"), ""));
        let mut lines = String::from("# as of a gripper\nrate_hz = 100\n");
        for (finger, id) in [1, 2].into_iter().rev().take(count).rev().enumerate() {
            let (zero, reversed) = if id == 1 { (2048, false) } else { (1000, true) };
            lines += &format!("finger.{finger}.servo_id = {id}\nfinger.{finger}.zero_counts = {zero}\n");
            lines += &format!("finger.{finger}.reversed = {reversed}\n");
        }
        std::fs::write(&settings, lines).unwrap();
        let case = case(&format!("{name}.toml"), "6.0");
        let [case, settings, csv] = [&case, &settings, &csv].map(|path| path.to_str().unwrap());
        let arguments = ["monitor", "--bus", bus.port(), "--case", case, "--settings", settings, "--seconds", "8"];
        // As uncertain as its modulus, and hardly by anything else.
        let left = Uncertainty { youngs_modulus: 1.0, ..Uncertainty::NONE };
        let fit = serde_json::json!({ "gripper": { "uncertainty": left } }).to_string();
        let fit = file(&format!("{name}.json"), &fit);
        let output =
            fre(&[&arguments[..], &["--force", "--log", csv, "--uncertainty", fit.to_str().unwrap()]].concat());
        let (out, err) = words(&output);
        assert!(output.status.success(), "{name}: {out}{err}");
        let first = out.lines().find(|line| line.contains(" * ")).unwrap_or_default();
        snapbox::assert_data_eq!(
            first,
            snapbox::str![
                "    0.000  * finger 0: the servo (XM430-W350, model 1020, firmware 45) answers at 1000000 baud"
            ]
        );

        let text = std::fs::read_to_string(csv).unwrap();
        for finger in 0..count {
            let of = |row: &&str| column(&text, "finger", row) == finger.to_string();
            let rows: Vec<&str> = text.lines().skip(1).filter(of).collect();
            let last = rows.iter().rev().find(|row| column(&text, "status", row) != "stale").unwrap();
            let number = |name: &str| column(&text, name, last).parse::<f64>().unwrap();
            assert_eq!(column(&text, "status", last), "converged", "{name}");
            assert_eq!(number("position_counts"), f64::from(bus.servos[finger].truth().count), "{name}");
            let angle = number("motor_angle_deg");
            let one =
                file(&format!("{name}-{finger}.toml"), &format!("{CASE}[motion]\nmotor_angles_deg = [{angle:.6}]\n"));
            let solved = fre(&["solve", one.to_str().unwrap(), "--format", "json"]);
            let solved: serde_json::Value = serde_json::from_slice(&solved.stdout).unwrap();
            let force: Vec<f64> = serde_json::from_value(solved[0]["force_n"].clone()).unwrap();
            let heard = [number("force_x_n"), number("force_y_n")];
            let apart = (force[0] - heard[0]).hypot(force[1] - heard[1]);
            assert!(force[0] > 1.0 && apart < 1e-3, "{name}: {heard:?} N at {angle}°, solve says {force:?}");
            let part = number("standard_deviation_n") / heard[0].hypot(heard[1]);
            assert!((0.97..1.01).contains(&part), "{name}: the standard deviation is {part} of the force");
        }
        // Nothing was written to any servo.
        let heard = bus.instructions();
        let reading = [Instruction::Ping, Instruction::Read, Instruction::Status, read].map(Instruction::code);
        assert!(heard.contains(&read.code()) && heard.iter().all(|code| reading.contains(code)), "{name}: {heard:?}");
    }
}

#[test]
fn servos_are_found_and_one_that_falls_silent_is_told() {
    let bus = Bus::new([gripping(7, 45, 2048, true), gripping(3, 45, 2048, true)]);
    let case = case("found.toml", "6.0");
    let options = ["--case", case.to_str().unwrap(), "--set", "rate_hz=50", "--every", "1", "--seconds", "120"];
    let mut child = Command::new(env!("CARGO_BIN_EXE_fre"))
        .args(["monitor", "--bus", bus.port()])
        .args(options)
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let lost = Event::ServoLost { finger: 1, other_master: false }.to_string();
    let answers = "finger 1: the servo (XM430-W350, model 1020, firmware 45) answers";
    let came_back = |out: &str| out.split_once(&lost).is_some_and(|(_, after)| after.contains(answers));
    let mut out = String::new();
    let mut silenced = false;
    let mut lines = BufReader::new(child.stdout.take().unwrap());
    while !came_back(&out) && lines.read_line(&mut out).unwrap() > 0 {
        if !silenced && out.matches(" converged\n").count() > 20 {
            bus.servos[0].silence(Duration::from_secs(2));
            silenced = true;
        }
    }
    child.kill().unwrap();
    child.wait().unwrap();
    // The lowest address is the first finger.
    let answers = out.lines().filter(|line| line.contains(" answers ")).take(2).collect::<Vec<_>>();
    snapbox::assert_data_eq!(
        answers.join("\n"),
        snapbox::str![[r#"
    0.000  * finger 0: the servo (XM430-W350, model 1020, firmware 45) answers at 1000000 baud
    0.000  * finger 1: the servo (XM430-W350, model 1020, firmware 45) answers at 1000000 baud
"#]]
    );
    let (_, after) = out.split_once(&lost).unwrap_or_else(|| panic!("{lost}: {out}"));
    assert!(after.contains("stale") && after.contains(" converged\n"), "the other one goes on: {after}");
    assert!(came_back(&out), "it comes back: {after}");
}

#[test]
fn whatever_keeps_a_bus_from_working_is_told() {
    let (silent, bus) = (Bus::new([]), Bus::new([gripping(1, 45, 2048, true), gripping(2, 45, 2048, true)]));
    // The longer one first: it may begin with the other.
    let mut ports = [silent.port(), bus.port()];
    ports.sort_by_key(|port| std::cmp::Reverse(port.len()));
    let mut said = String::new();
    let mut refused = |what: &str, arguments: &[&str]| {
        let output = fre(&[&["monitor", "--seconds", "1"], arguments].concat());
        assert_eq!(output.status.code(), Some(1), "{output:?}");
        let words = words(&output).1.replace(env!("CARGO_TARGET_TMPDIR"), "FOLDER");
        said += &format!("{what}\n{}\n", words.replace(ports[0], "PORT").replace(ports[1], "PORT"));
    };
    refused("a file", &["--bus", file("no-port", "words").to_str().unwrap()]);
    refused("a silent bus", &["--bus", &format!("{}@57600", silent.port())]);
    refused("another rate", &["--bus", &format!("{}@57600", bus.port())]);
    let fingers = ["--set", "finger.0.servo_id=2", "--set", "finger.1.servo_id=9"];
    refused("a servo that is not there", &[&["--bus", bus.port()], &fingers[..]].concat());
    refused("no gear ratio", &["--bus", bus.port(), "--set", "finger.0.gear_ratio=0"]);
    refused("a line with a fault", &["--bus", bus.port(), "--settings", file_with_a_fault().to_str().unwrap()]);
    let (case, empty) = (case("no-fit.toml", "6.0"), file("no-fit.json", "{}"));
    let fit = ["--case", case.to_str().unwrap(), "--uncertainty", empty.to_str().unwrap()];
    refused("a file without a fit", &[&["--bus", bus.port()], &fit[..]].concat());
    snapbox::assert_data_eq!(said, snapbox::file!["words/bus.txt"].raw());
    // What it says of other ports depends on this machine.
    let none = fre(&["monitor", "--bus", "/dev/ttyUSB77"]);
    let words = words(&none).1;
    assert_eq!(none.status.code(), Some(1), "{words}");
    let (before, _) = words.split_once("; ").unwrap_or((&words, ""));
    snapbox::assert_data_eq!(
        before,
        snapbox::str!["fre: the bus /dev/ttyUSB77 cannot be opened: No such file or directory"]
    );
    let both = fre(&["monitor", "--bus", bus.port(), "--link", "unix:link"]);
    assert_eq!(both.status.code(), Some(1), "a link or a bus");
    let neither = fre(&["monitor"]);
    assert_eq!(neither.status.code(), Some(1), "a link or a bus");
}

fn file_with_a_fault() -> PathBuf {
    file("fault.settings", "rate_hz = 100\nfinger.0.zero_counts = many\n")
}

#[test]
fn a_monitor_of_nothing_says_what_is_needed_and_which_ports_there_are() {
    let output = Command::new(env!("CARGO_BIN_EXE_fre")).arg("monitor").output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), output.stdout.len()), (Some(1), 0), "{said}");
    let (before, _) = said.split_once("; ").unwrap_or((&said, ""));
    snapbox::assert_data_eq!(
        before,
        snapbox::str!["fre: needed is --link LINK (a gripper) or --bus PORT (servos on a USB adapter)"]
    );
}

/// Before anything is asked of the bus.
#[test]
fn a_jaws_case_needs_a_jaws_drive() {
    let jaw = file("jaw.toml", &format!("{CASE}[motion]\ndirection = [1, 0]\ndistances_mm = [2]\n"));
    let jaw = jaw.to_str().unwrap();
    let turned = case("turned.toml", "6.0");
    for (cases, settings, finger) in
        [(&[jaw][..], &[][..], 0), (&[turned.to_str().unwrap(), jaw], &["--set", "finger.1.drive=rotating"], 1)]
    {
        let mut arguments = vec!["monitor", "--bus", "unix:/nowhere", "--seconds", "1"];
        arguments.extend(cases.iter().flat_map(|case| ["--case", case]));
        arguments.extend(settings);
        let output = fre(&arguments);
        let (_, said) = words(&output);
        let refused = format!(
            "fre: {jaw}: [motion] moves the base along a line, and finger.{finger}.drive is rotating; needed is "
        );
        assert!(output.status.code() == Some(1) && said.starts_with(&refused), "{said}");
    }
    // With the drive it is the bus that is missing.
    let drive = "finger.0.drive=linear 1,0 20";
    let output = fre(&["monitor", "--bus", "unix:/nowhere", "--seconds", "1", "--case", jaw, "--set", drive]);
    let (_, said) = words(&output);
    assert!(output.status.code() == Some(1) && said.contains("/nowhere") && !said.contains("[motion]"), "{said}");
}
