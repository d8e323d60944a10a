//! The protocol's codec and device against ROBOTIS' own Python SDK (`dynamixel-sdk` on PyPI), over a raw pseudo-terminal.

#[path = "../../../firmware/dynamixel/tests/line/mod.rs"]
mod line;
#[path = "../../../firmware/dynamixel/tests/servo/mod.rs"]
mod servo;

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use dynamixel::{Id, Instruction, ResetScope, encode, xm430};
use line::Line;
use servo::Servo;

/// Runs the script at this baud rate; gives its facts by name, and the servos.
fn run(baud_rate: u32) -> (BTreeMap<String, String>, Vec<Servo>) {
    let mut servos = vec![Servo::new(1), Servo::new(2)];
    servos[0].put(xm430::PRESENT_POSITION, 166);
    servos[1].put(xm430::PRESENT_POSITION, -2_079);
    servos[0].put(xm430::PRESENT_INPUT_VOLTAGE, 119);
    servos[0].put(xm430::PRESENT_TEMPERATURE, 36);
    servos[1].put(xm430::PRESENT_TEMPERATURE, 41);
    servos[0].put(xm430::PRESENT_VELOCITY, i32::from_le_bytes([0xFF, 0xFF, 0xFD, 0x01]));
    // The second servo reports a hardware error.
    servos[1].put(xm430::HARDWARE_ERROR_STATUS, 0x04);
    let line = Line::new(servos);
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/protocol_sdk.py");
    let output =
        Command::new(test_bus::python()).arg(script).arg(&line.path).arg(baud_rate.to_string()).output().unwrap();
    let (servos, _) = line.end();
    let text = String::from_utf8(output.stdout).unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "the script failed:\n{text}{errors}");
    let facts = text.lines().filter_map(|line| line.split_once(' '));
    (facts.map(|(name, fact)| (name.to_owned(), fact.to_owned())).collect(), servos)
}

/// Facts are value, communication result (0 success, -3001 no answer), status error byte.
fn check(baud_rate: u32) {
    let (facts, servos) = run(baud_rate);
    let stuffed = [76, 0, 255, 255, 253, 0, 255, 255, 255, 253];
    let mut buffer = [0; 64];
    let stuffed = encode(&mut buffer, Id::new(2).unwrap(), Instruction::Write, &stuffed).unwrap();
    let stuffed: String = stuffed[..stuffed.len() - 2].iter().map(|byte| format!("{byte:02x}")).collect();
    let expected = [
        ("ping", "1020 0 128"),
        ("read1", "36 0 0"),
        ("read2", "119 0 0"),
        ("read4", "4294965217 0 128"),
        ("stuffed", "33423359 0 0"),
        ("write1", "0 0"),
        ("write2", "0 0"),
        ("write4", "0 0"),
        ("stuffing", &stuffed),
        ("sync-read", "0 4294965217 166"),
        ("fast-sync-read", "0 4294965217 166"),
        ("sync-write", "0"),
        ("sync-written", "150 0 0 170 0 128"),
        ("bulk-read", "0 119 41"),
        ("fast-bulk-read", "0 119 41"),
        ("bulk-write", "0"),
        ("bulk-written", "7 0 0 1 0 128"),
        ("reg-write", "0 0"),
        ("before-action", "0 0 0"),
        ("action", "0 fffffd000104005500a10c"),
        ("after-action", "300 0 0"),
        ("reboot", "0 128"),
        ("clear", "0 128"),
        ("factory-reset", "0 128"),
        ("nobody", "0 -3001 0"),
        ("access", "0 7"),
        ("length", "0 5"),
        ("range", "0 4"),
        ("limit", "0 6"),
        ("broadcast-ping", "0 [(1, [1020, 45]), (2, [1020, 45])]"),
    ];
    let expected: BTreeMap<_, _> = expected.map(|(name, fact)| (name.to_owned(), fact.to_owned())).into();
    assert_eq!(facts, expected);
    assert_eq!(servos[0].value(xm430::GOAL_POSITION), 512);
    assert_eq!(servos[0].value(xm430::CURRENT_LIMIT), 500);
    assert_eq!(servos[0].value(xm430::LED), 1);
    assert_eq!((servos[1].reboots, servos[1].clears), (1, 1));
    assert_eq!(servos[1].resets, [ResetScope::ExceptIdAndBaudRate]);
}

#[test]
fn the_sdk_understands_our_servos() {
    check(1_000_000);
}

#[test]
fn at_the_factory_baud_rate_too() {
    check(57_600);
}
