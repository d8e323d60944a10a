//! ROBOTIS' own SDK as the bus's master beside a gripper that answers as a device: what it is told, and whether that is right.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Child, Command};

use dynamixel::Id;
use model_core::estimator::Estimator;
use model_core::size::Reduced;
use model_core::status::Status;
use system_tests::{OBJECT, finger};

/// The servo's address.
pub const SERVO: u8 = 1;
/// The gripper's.
pub const GRIPPER: u8 = 100;
/// The servo at 11°, where the finger holds the object firmly.
pub const GOAL: i32 = 2048 + 125;

/// What the SDK has printed: the facts of one name behind one another.
pub type Facts = BTreeMap<String, Vec<String>>;

/// The version of this repository's firmware as the control table has it: ten times the major number, and the minor one.
pub fn version() -> u8 {
    let [major, minor] = [env!("CARGO_PKG_VERSION_MAJOR"), env!("CARGO_PKG_VERSION_MINOR")];
    10 * major.parse::<u8>().unwrap() + minor.parse::<u8>().unwrap()
}

/// Motor angle at a position, rad.
pub fn angle(position: i32) -> f64 {
    f64::from(position - 2048) * std::f64::consts::TAU / 4096.0
}

/// Runs a script of the SDK's on a port; what it prints.
pub fn run(script: &str, port: &Path) -> String {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests").join(script);
    let numbers = [1_000_000, i32::from(SERVO), i32::from(GRIPPER), GOAL].map(|number| number.to_string());
    let output = Command::new(test_bus::python()).arg(script).arg(port).args(numbers).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
    println!("{text}");
    text
}

/// What a gripper answers the SDK on a port.
pub fn ask(port: &Path) -> Facts {
    let text = run("device_sdk.py", port);
    let mut facts = Facts::new();
    for (name, fact) in text.lines().filter_map(|line| line.split_once(' ')) {
        facts.entry(name.to_owned()).or_default().push(fact.to_owned());
    }
    facts
}

/// What the SDK was told is what this PC makes of the same position, and what the protocol asks for.
pub fn check(facts: &Facts) {
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
    let errors = ["access", "range", "delay-range", "limit", "length"].map(|name| fact(name)[0].as_str());
    assert_eq!(errors, ["None 7", "None 4", "None 4", "None 6", "None 5"]);
    let status = |body: &[u8]| -> String {
        let mut buffer = [0; 32];
        let id = Id::new(GRIPPER).unwrap();
        let packet = dynamixel::encode(&mut buffer, id, dynamixel::Instruction::Status, body).unwrap();
        packet.iter().map(|byte| format!("{byte:02x}")).collect()
    };
    assert_eq!(fact("crc"), [status(&[3])]);
    assert_eq!(fact("back-to-back"), [status(&[0, 1])]);
    assert_eq!(facts.get("quiet").map(|said| said.concat()).unwrap_or_default(), "");
    assert_eq!(fact("twice"), [status(&[0, b'F', b'R', version()]).repeat(2)]);
    assert_eq!(fact("reg-write"), ["None 0"]);
    assert_eq!(fact("action"), [status(&[0])]);
    assert_eq!(fact("delay"), ["200 0"]);
    // Under its new address, with the new zero and rate, after a restart too.
    assert_eq!((fact("moved"), fact("renamed")), (&["0 -3001 0".to_owned()][..], &["21062 0".to_owned()][..]));
    assert_eq!(
        (fact("restarted"), fact("rate"), fact("zero")),
        (&["21062 0".to_owned()][..], &["1 0".to_owned()][..], &["204850 0".to_owned()][..],)
    );
}

/// Starts another script of the SDK's on a port, with these numbers.
#[allow(dead_code)] // Not every test that shares this module leads a servo by a script of its own.
pub fn spawn(script: &Path, port: &Path, numbers: &[i32]) -> Child {
    let numbers = numbers.iter().map(|number| number.to_string());
    Command::new(test_bus::python()).arg(script).arg(port).args(numbers).spawn().unwrap()
}
