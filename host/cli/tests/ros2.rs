//! `fre ros2`, heard by Eclipse Cyclone DDS on this machine.

#[path = "../../gripper/tests/servo_case/mod.rs"]
mod servo_case;

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use fre::case::preset;
use fre_gripper::record::Recorder;
use fre_gripper::servo::{Config, Gains, Hub, Servo};
use fre_gripper::source::{Modelled, Origin, Setup, Told};
use messages::{Finger, Mount, PROTOCOL_VERSION, Phase, Report, Settings};
use model_core::discretise::{Discretisation, Physics};
use model_core::estimator::Estimate;
use model_core::status::Status;
use serde_json::{Value, json};
use servo_case::load;
use test_bus::Cyclone;

/// As `ROS_DOMAIN_ID` has it; a process is known by its number.
fn domain() -> u16 {
    1 + (std::process::id() % 100) as u16
}

/// A namespace of this test's own.
fn namespace(test: &str) -> String {
    format!("/command{}/{test}", std::process::id())
}

fn fre(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fre"));
    command.arg("ros2").args(args).env("ROS_DOMAIN_ID", domain().to_string()).env("ROS_LOCALHOST_ONLY", "1");
    command
}

fn subscriber(namespace: &str, qos: &str, reports: usize) -> Cyclone {
    Cyclone::subscribe(&format!("{namespace}/fre"), domain(), qos, reports)
}

/// The forces that were heard: seconds, and x in N, as Cyclone has them.
fn forces(subscriber: Cyclone) -> Vec<(f64, Value)> {
    let wrench = subscriber.lines().into_iter().filter(|line| line["topic"] == "wrench 0");
    let force = |line: Value| {
        let stamp = &line["fields"]["header"]["stamp"];
        let seconds = stamp["sec"].as_f64().unwrap() + 1e-9 * stamp["nanosec"].as_f64().unwrap();
        (seconds, line["fields"]["wrench"]["force"]["x"].clone())
    };
    wrench.map(force).collect()
}

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("ros2-command-{name}"))
}

/// A recording of so many forces 2 ms apart: 0 N, 1 N and so on.
fn recording(name: &str, count: u32) -> PathBuf {
    let design = preset("ladder-80").unwrap().unwrap().design;
    let how = Discretisation::estimator(Physics::Extended);
    let setup = Setup {
        origin: Origin::Gripper,
        place: "a test".to_owned(),
        board: "bench".to_owned(),
        firmware: "1.2.3".to_owned(),
        protocol: PROTOCOL_VERSION,
        cost_hz: 1_000_000,
        settings: Settings::of(Mount::DEFAULT),
        models: vec![Modelled {
            finger: Some(Finger::elastic(design, how)),
            object: None,
            friction: 0.0,
            uncertainty: None,
        }],
    };
    let path = file(name);
    let mut recorder = Recorder::create(&path, Some(setup)).unwrap();
    for sequence in 0..count {
        let estimate = Estimate { force: [sequence as f32, 0.0], ..Estimate::blank(Status::Converged) };
        let report = Report {
            phase: Phase::Moving,
            sequence,
            time_us: 2000 * u64::from(sequence),
            estimate,
            ..Report::blank(0)
        };
        recorder.take(&Told::Report(report)).unwrap();
    }
    recorder.finish().unwrap();
    path
}

#[test]
fn a_recording_is_told_with_its_own_times() {
    let path = recording("times.mcap", 500);
    let namespace = namespace("recording");
    let mut node = fre(&[path.to_str().unwrap(), "--namespace", &namespace, "--qos", "reliable"]);
    node.args(["--wait-for-subscribers", "--linger", "60", "--speed", "4"]).stdout(Stdio::piped());
    let node = node.spawn().unwrap();
    let heard = forces(subscriber(&namespace, "reliable", 500));
    let said = node.wait_with_output().unwrap();
    let text = String::from_utf8(said.stdout).unwrap();
    assert!(said.status.success() && text.contains(&format!("node {namespace}/fre in domain")), "{text}");
    assert!(text.contains("this machine only: ") && text.trim_end().ends_with("messages"), "{text}");
    assert_eq!(heard.len(), 500);
    for (at, (seconds, force)) in heard.iter().enumerate() {
        assert_eq!(force.as_f64(), Some(at as f64));
        // Of when it was recorded, not of the faster play: this recorder's clock follows the PC's by 1 %. (A double of this many seconds has
        // 0.2 µs.)
        let since = 0.002 * at as f64;
        assert!((seconds - heard[0].0 - since).abs() < 0.01 * since + 1e-6, "{at}");
    }
}

#[test]
fn servos_on_a_bus_tell_their_forces() {
    let servo = Config {
        start_deg: Some(10.0),
        load: load([41.0, 45.0], 13.0),
        baud_rate: 1_000_000,
        gains: Gains::GREATEST,
        ..Config::default()
    };
    let mut hub = Hub::new();
    hub.servo(Servo::new(servo).unwrap());
    let port = hub.pty().unwrap();
    let _bus = hub.spawn().unwrap();
    let case = file("bus.toml");
    let object = "[object]\nshape = \"circle\"\nradius_mm = 40.0\ncentre_mm = [41.0, 45.0]\n";
    let motion = "[motion]\nmotor_angles_deg = [10.0]\n";
    std::fs::write(&case, format!("finger = \"preset:ladder-80\"\n{object}{motion}")).unwrap();
    let namespace = namespace("bus");
    let port = format!("{}@1000000", port.display());
    let mut node = fre(&["--bus", &port, "--case", case.to_str().unwrap(), "--set", "rate_hz=100"]);
    let mut node = node.args(["--namespace", &namespace]).stdout(Stdio::null()).spawn().unwrap();
    let heard = forces(subscriber(&namespace, "best-effort", 50));
    // What moves such servos is another program; to let go is the one thing that the node does to them.
    let calls = ["grip", "relax"].map(|service| json!({ "service": service }));
    let said = Cyclone::call(&format!("{namespace}/fre"), domain(), "enhanced", &calls).lines();
    node.kill().unwrap();
    node.wait().unwrap();
    assert_eq!(said[0]["success"], false, "{said:?}");
    snapbox::assert_data_eq!(
        said[0]["message"].as_str().unwrap(),
        snapbox::str!["the servos on this bus are only read: whatever leads them moves the fingers"]
    );
    assert_eq!((&said[1]["success"], &said[1]["message"]), (&Value::from(true), &Value::from("without torque")));
    let known: Vec<f64> = heard.iter().filter_map(|(_, force)| force.as_f64()).collect();
    assert!(heard.len() >= 50 && known.iter().any(|force| *force > 1.0), "{heard:?}");
}

#[test]
fn what_makes_no_node_is_named() {
    let mut said = String::new();
    let mut refused = |what: &str, args: &[&str]| {
        let output = fre(args).output().unwrap();
        let words = String::from_utf8_lossy(&output.stderr).replace(env!("CARGO_TARGET_TMPDIR"), "FOLDER");
        assert_eq!(output.status.code(), Some(1), "{args:?}: {words}");
        said += &format!("{what}\n{words}\n");
    };
    refused("no file", &["nowhere.mcap"]);
    let path = recording("one.mcap", 1);
    let path = path.to_str().unwrap();
    refused("a domain out of range", &[path, "--domain", "233"]);
    refused("a name with a hyphen", &[path, "--name", "left-arm"]);
    refused("no speed", &[path, "--speed", "0"]);
    refused("a time to stay that is negative", &[path, "--linger=-1"]);
    refused("a recording and a gripper", &[path, "--link", "unix:nowhere"]);
    snapbox::assert_data_eq!(said, snapbox::file!["words/ros2.txt"].raw());
    // What it lists depends on the serial ports of this machine.
    let output = fre(&[]).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("needed is --link LINK (a gripper) or --bus PORT"));
}
