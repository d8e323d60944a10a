//! A bus of this PC switches the torque of its servos off when it is asked to, and writes nothing else.

use std::collections::BTreeSet;
use std::io::{ErrorKind, Read};
use std::os::unix::net::UnixStream;
use std::time::Duration;

use dynamixel::{Decoder, Id, Instruction, encode, xm430};
use fre::study::model::Precision;
use fre_gripper::bus::{Bus, BusOptions};
use fre_gripper::servo::{Config, Handle, Hub, Servo};
use fre_gripper::source::{Order, Source, Told};
use messages::{Settings, Which};
use model_core::newton::Hessian;

/// A packet for a servo, and the parameters of its answer.
fn ask(servo: &Handle, instruction: Instruction, parameters: &[u8]) -> Vec<u8> {
    let mut buffer = [0; 64];
    servo.with(|servo| {
        let id = Id::new(servo.config().id).unwrap();
        let packet = encode(&mut buffer, id, instruction, parameters).unwrap();
        let answers = servo.hear(servo.truth().time_us, packet);
        let mut decoder = Decoder::<64>::new();
        let packet = decoder.feed(&mut answers[0].bytes.as_slice()).unwrap().unwrap();
        packet.status().unwrap().parameters.to_vec()
    })
}

fn torque(servo: &Handle) -> bool {
    let [low, high] = xm430::TORQUE_ENABLE.address().to_le_bytes();
    ask(servo, Instruction::Read, &[low, high, 1, 0]) == [1]
}

fn switch_on(servo: &Handle) {
    let [low, high] = xm430::TORQUE_ENABLE.address().to_le_bytes();
    ask(servo, Instruction::Write, &[low, high, 1]);
    assert!(torque(servo));
}

/// Instructions and their parameters that were heard since the last time, but for reads.
fn written(ear: &mut UnixStream) -> BTreeSet<(u8, Vec<u8>)> {
    let mut bytes = Vec::new();
    assert_eq!(ear.read_to_end(&mut bytes).unwrap_err().kind(), ErrorKind::WouldBlock);
    let (mut decoder, mut rest, mut found) = (Decoder::<512>::new(), bytes.as_slice(), BTreeSet::new());
    let reads =
        [Instruction::Ping, Instruction::Read, Instruction::SyncRead, Instruction::FastSyncRead, Instruction::Status];
    while let Some(packet) = decoder.feed(&mut rest) {
        let Ok(packet) = packet else { continue };
        if !packet.instruction().is_some_and(|instruction| reads.contains(&instruction)) {
            found.insert((packet.id.get(), packet.parameters.to_vec()));
        }
    }
    found
}

#[test]
fn fingers_are_relaxed_each_by_itself_and_whatever_becomes_of_others() {
    let mut hub = Hub::new();
    let config = |id| Config { id, baud_rate: 1_000_000, ..Config::default() };
    let [left, right] = [3, 5].map(|id| hub.servo(Servo::new(config(id)).unwrap()));
    let mut ear = hub.stream().unwrap();
    ear.set_nonblocking(true).unwrap();
    let port = hub.pty().unwrap();
    let _running = hub.spawn().unwrap();
    [&left, &right].into_iter().for_each(switch_on);

    let options = BusOptions {
        settings: Settings::DEFAULT,
        names_servos: false,
        models: Vec::new(),
        precision: Precision::F64,
        hessian: Hessian::default(),
    };
    let bus = Bus::open(&format!("{}@1000000", port.display()).parse().unwrap(), &options).unwrap();
    let reports = bus.hear(64);
    while !matches!(reports.recv().unwrap(), Told::Report(report) if report.finger == 1) {}
    assert_eq!([torque(&left), torque(&right)], [true; 2], "to be read is no reason to let go");
    assert_eq!(written(&mut ear), BTreeSet::new());

    bus.order(&Order::Relax(Which::One(1))).unwrap();
    assert_eq!([torque(&left), torque(&right)], [true, false]);
    let off = |id| (id, vec![64, 0, 0]);
    assert_eq!(written(&mut ear), BTreeSet::from([off(5)]), "nothing but Torque Enable was written");

    let unknown = bus.order(&Order::Relax(Which::One(2))).unwrap_err().to_string();
    assert_eq!(unknown, "finger's number is 2; allowed is 0 to 1");

    // One that is gone does not keep the other from letting go.
    switch_on(&right);
    left.silence(Duration::MAX);
    let silent = bus.order(&Order::Relax(Which::All)).unwrap_err().to_string();
    assert_eq!(silent, "no answer from the servo of finger 0; every other finger has done it");
    assert!(!torque(&right));
    left.speak();
    bus.order(&Order::Relax(Which::All)).unwrap();
    assert_eq!([torque(&left), torque(&right)], [false; 2]);
    assert!(bus.order(&Order::Open(Which::All)).unwrap_err().to_string().contains("only read"));
}
