//! The gripper as a device on a bus where the servo answers too: ROBOTIS' own SDK leads the servo and reads the force.

use std::collections::BTreeMap;
use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::process::Command;
use std::thread::{JoinHandle, spawn};
use std::time::{Duration, Instant};

use dynamixel::{Device, Id, StatusReturn, Tap, Timing};
use gripper::device_table::{BusSettings, Change, DeviceTable, FingerState};
use host::servo::{Hub, Servo};
use model_core::estimator::{Estimate, Estimator};
use model_core::object::ObjectDesign;
use model_core::size::Reduced;
use model_core::status::Status;
use system_tests::{Machine, OBJECT, finger};

const SERVO: u8 = 1;
const GRIPPER: u8 = 100;
/// The servo at 11°, where the finger holds the object firmly.
const GOAL: i32 = 2048 + 125;
/// A PC may be busy.
const PATIENT: Timing = Timing { baud_rate: 1_000_000, latency_us: 1_000_000, status_return: StatusReturn::All };

fn angle(position: i32) -> f64 {
    f64::from(position - 2048) * std::f64::consts::TAU / 4096.0
}

/// A gripper in the role of a device, on this PC: it listens, estimates from what it hears, and answers.
fn device(mut port: UnixStream) -> JoinHandle<Option<ObjectDesign>> {
    spawn(move || {
        let id = |id| Id::new(id).unwrap();
        let mut tap = Tap::<256, 1>::new(PATIENT);
        assert!(tap.watch(id(SERVO)));
        let mut device = Device::<256>::new(PATIENT);
        let bus = BusSettings { id: id(GRIPPER), baud_rate: 1_000_000, return_delay: 0 };
        let mut table = DeviceTable::new(&bus, 1, 1);
        let mut model: Box<Estimator<f32, Reduced>> = Box::new(Estimator::EMPTY);
        let finger = finger();
        model.configure(&finger.design, &finger.how).unwrap();
        let mut object = None;
        let mut estimate = Estimate::blank(Status::OutOfRange);
        let began = Instant::now();
        let mut chunk = [0; 256];
        let mut heard_at = 0;
        port.set_read_timeout(Some(Duration::from_millis(5))).unwrap();
        loop {
            let count = match port.read(&mut chunk) {
                Ok(0) => return object,
                Ok(count) => count,
                Err(_) => 0,
            };
            let now_us = began.elapsed().as_micros() as u64;
            let mut rest = &chunk[..count];
            while tap.hear(now_us, &mut rest).is_some() {}
            if let Some(seen) = tap.servo(id(SERVO)).and_then(|servo| servo.position) {
                // Every position is a tick, and so is a while without one as long as the estimate is on its way.
                if seen.at_us != heard_at || estimate.age > 0 {
                    estimate = model.update(angle(seen.value));
                    heard_at = seen.at_us;
                }
                let age_us = Some(seen.age_us(now_us) as u32);
                table.show(0, &FingerState { estimate, position: seen.value, current: 0.0, age_us, alert: false });
            }
            let mut rest = &chunk[..count];
            while let Some(reply) = device.hear(now_us, &mut rest, &mut table) {
                port.write_all(reply.bytes).unwrap();
            }
            if let Some(reply) = device.poll(began.elapsed().as_micros() as u64, &mut table) {
                port.write_all(reply.bytes).unwrap();
            }
            while let Some(change) = table.take() {
                if let Change::Object(0, circle) = change {
                    model.set_object(circle).unwrap();
                    object = Some(circle);
                }
            }
        }
    })
}

/// Runs the SDK's script on a port; gives its facts, those of one name behind one another.
fn ask(port: &Path) -> BTreeMap<String, Vec<String>> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/device_sdk.py");
    let numbers = [1_000_000, i32::from(SERVO), i32::from(GRIPPER), GOAL].map(|number| number.to_string());
    let output = Command::new(test_bus::python()).arg(script).arg(port).args(numbers).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
    println!("{text}");
    let mut facts: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (name, fact) in text.lines().filter_map(|line| line.split_once(' ')) {
        facts.entry(name.to_owned()).or_default().push(fact.to_owned());
    }
    facts
}

/// What the SDK was told is what this PC makes of the same position, and what the protocol asks for.
fn check(facts: &BTreeMap<String, Vec<String>>) {
    let fact = |name: &str| facts.get(name).unwrap_or_else(|| panic!("no {name}")).as_slice();
    let numbers = |name: &str| -> Vec<i32> { fact(name)[0].split(' ').map(|word| word.parse().unwrap()).collect() };
    assert_eq!(fact("ping"), ["21062 0"]);
    assert_eq!(fact("servo"), ["1020 0"]);
    assert_eq!(fact("baud"), ["3 0"]);
    assert_eq!(fact("object"), ["None 0"; 3]);
    let no_contact = Status::NoContact as i32;
    for open in ["open", "opened"] {
        let [x, y, size, _, _, torque, status, ..] = numbers(open)[..] else { panic!() };
        assert_eq!([x, y, size, torque, status], [0, 0, 0, 0, no_contact], "{open}");
    }
    let [x, y, size, cx, cy, torque, status, motor_angle, position] = numbers("closed")[..] else { panic!() };
    assert_eq!((position, status), (GOAL, 0));
    // The estimate in double precision, along the same positions.
    let mut exact: Box<Estimator<f64, Reduced>> = Box::new(Estimator::EMPTY);
    let finger = finger();
    exact.configure(&finger.design, &finger.how).unwrap();
    exact.set_object(OBJECT).unwrap();
    let exact = (2048 - 12..=GOAL).map(|position| exact.update(angle(position))).last().unwrap();
    let told = [x, y, size, torque, cx, cy].map(f64::from);
    let [[fx, fy], [px, py]] = [exact.force, exact.contact_centre].map(|pair| pair.map(f64::from));
    let expected = [fx, fy, f64::from(exact.force_magnitude()), f64::from(exact.torque), px, py].map(|it| it * 1e3);
    for ((told, expected), tolerance) in told.into_iter().zip(expected).zip([5.0, 5.0, 5.0, 150.0, 10.0, 10.0]) {
        assert!((told - expected).abs() < tolerance, "{told} instead of {expected}");
    }
    assert!(f64::from(motor_angle) - angle(GOAL) * 1e6 < 1.0);
    // The one's position and the other's force in one answer, in both orders.
    for (name, force) in [("sync", y), ("fast-sync", y), ("bulk", size), ("fast-bulk", size)] {
        assert_eq!(fact(name).len(), 2);
        for both in fact(name) {
            let (position, told) = both.split_once(' ').unwrap();
            assert_eq!(position.parse(), Ok(GOAL), "{name}");
            // As a number without sign; the last digit may be rounded the other way.
            assert!((told.parse::<u32>().unwrap() as i32).abs_diff(force) <= 1, "{name}: {both}");
        }
    }
    assert_eq!(fact("nobody"), ["0 -3001 0"]);
    let errors = ["access", "range", "limit", "length"].map(|name| fact(name)[0].as_str());
    assert_eq!(errors, ["None 7", "None 4", "None 6", "None 5"]);
    let status = |body: &[u8]| -> String {
        let mut buffer = [0; 32];
        let id = Id::new(GRIPPER).unwrap();
        let packet = dynamixel::encode(&mut buffer, id, dynamixel::Instruction::Status, body).unwrap();
        packet.iter().map(|byte| format!("{byte:02x}")).collect()
    };
    assert_eq!(fact("crc"), [status(&[3])]);
    assert_eq!(fact("back-to-back"), [status(&[0, 1])]);
    assert_eq!(facts.get("quiet").map(|said| said.concat()).unwrap_or_default(), "");
    assert_eq!(fact("twice"), [status(&[0, b'F', b'R', 1]).repeat(2)]);
    assert_eq!(fact("reg-write"), ["None 0"]);
    assert_eq!(fact("action"), [status(&[0])]);
    assert_eq!(fact("delay"), ["5 0"]);
}

/// The role's state machines with the SDK of ROBOTIS on a pseudo-terminal, without QEMU between them.
#[test]
fn the_sdk_of_robotis_reads_the_force() {
    let mut hub = Hub::new();
    hub.servo(Servo::new(Machine::servo()).unwrap());
    let device = device(hub.stream().unwrap());
    let port = hub.pty().unwrap();
    let bus = hub.spawn().unwrap();
    let facts = ask(&port);
    assert_eq!(bus.lost(), 0);
    bus.stop();
    assert_eq!(device.join().unwrap(), Some(OBJECT));
    check(&facts);
}
