//! ROBOTIS' own Python SDK (`dynamixel-sdk` on PyPI) moves the simulated finger over a pseudo-terminal.

mod servo_case;

use std::path::Path;
use std::process::Command;

use fre_gripper::servo::{Config, Gains, Hub, Servo};
use servo_case::load;

#[test]
fn the_sdk_of_robotis_closes_and_opens_the_finger() {
    let mut hub = Hub::new();
    let config = Config {
        load: load([41.0, 45.0], 13.0),
        return_delay_us: 20,
        baud_rate: 1_000_000,
        gains: Gains { p: 16_383, i: 0, d: 0 },
        ..Config::default()
    };
    let handle = hub.servo(Servo::new(config).unwrap());
    let path = hub.pty().unwrap();
    let _bus = hub.spawn().unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/servo_sdk.py");
    let output = Command::new(test_bus::python()).arg(script).arg(&path).args(["1000000", "2173"]).output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
    let refused = "eeprom [RxPacketError] Writing or Reading is not available to target address!";
    let lines: Vec<&str> = text.lines().collect();
    // The start is 2° before the first contact; 3.0 N·m and friction are 671 units of current, and five counts of its error.
    let [model, start, eeprom, closed, open] = lines[..] else { panic!("{text}") };
    assert_eq!((model, start, eeprom), ("model 1020", "start 2026", refused));
    let at = |line: &str| -> Vec<i32> { line.split(' ').skip(1).map(|word| word.parse().unwrap()).collect() };
    let (closed, open) = (at(closed), at(open));
    assert!((2166..=2169).contains(&closed[0]) && (600..=660).contains(&closed[1]), "{text}");
    assert!(open[0] == 2026 && (-60..=-40).contains(&open[1]), "{text}");
    assert_eq!(handle.truth().count, 2026);
}
