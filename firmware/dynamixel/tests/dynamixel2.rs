//! Against an independent implementation, the crate `dynamixel2` 0.9.1, over a pseudo-terminal.
//!
//! Each of its instructions is understood by our device and equal to ours byte by byte; each of our answers is
//! understood by it. Two of its own defects are kept out of the way: it does not stuff FF FF FD after a further FF, and
//! its bulk read of several devices overlaps their entries.

mod line;
mod servo;

use std::fmt::Debug;
use std::io::ErrorKind;

use dynamixel::{Id, Instruction, ResetScope, encode, xm430};
use dynamixel2::instructions::{BulkReadData, BulkWriteData, FactoryResetKind, SyncWriteData};
use dynamixel2::{Bus, MotorError, ReadError, TransferError};
use line::Line;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use servo::Servo;

type Theirs = Bus<Vec<u8>, Vec<u8>>;

/// Their master waits 34 ms for an answer, and the time its bytes take. A pseudo-terminal carries as fast at any rate: at
/// this one they have seconds, however busy the PC is.
const PATIENT_BAUD: u32 = 50;
/// The same, where nobody's answer is waited for 253 times.
const SCAN_BAUD: u32 = 9_600;

/// Opens a line with their master.
fn open(line: &Line) -> Theirs {
    Bus::open_with_buffers(&line.path, PATIENT_BAUD, vec![0; 512], vec![0; 512]).unwrap()
}

/// The error number that a servo answered with.
#[track_caller]
fn refused<T: Debug>(result: Result<T, TransferError>) -> u8 {
    match result {
        Err(TransferError::ReadError(ReadError::MotorError(MotorError { raw }))) => raw,
        other => panic!("{other:?}"),
    }
}

/// Runs `talk` with their master on our servos 1 and 2; gives the servos back and what was heard.
fn with_servos(talk: impl FnOnce(&mut Theirs)) -> (Vec<Servo>, Vec<u8>) {
    let mut servos = vec![Servo::new(1), Servo::new(2)];
    for (servo, position) in servos.iter_mut().zip([166, -2_079]) {
        servo.put(xm430::PRESENT_POSITION, position);
        servo.put(xm430::PRESENT_INPUT_VOLTAGE, 119);
        servo.put(xm430::PRESENT_TEMPERATURE, 36);
    }
    let line = Line::new(servos);
    let mut theirs = open(&line);
    talk(&mut theirs);
    // An instruction without an answer may still be on its way.
    theirs.ping(1).unwrap();
    line.end()
}

/// What our encoder makes of the same instructions, and the ping that ends every talk.
fn ours(packets: &[(u8, Instruction, &[u8])]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for &(id, instruction, parameters) in packets.iter().chain(&[(1, Instruction::Ping, &[] as &[u8])]) {
        let id = Id::new(id).unwrap_or(Id::BROADCAST);
        bytes.extend_from_slice(encode(&mut [0; 512], id, instruction, parameters).unwrap());
    }
    bytes
}

#[test]
fn ping_read_write() {
    let (servos, heard) = with_servos(|bus| {
        let answer = bus.ping(2).unwrap();
        assert_eq!((answer.motor_id, answer.alert, answer.data.model, answer.data.firmware), (2, false, 1020, 45));
        assert_eq!(bus.read_u8(1, 146).unwrap().data, 36);
        assert_eq!(bus.read_u16(1, 144).unwrap().data, 119);
        assert_eq!(bus.read_u32(2, 132).unwrap().data, -2_079i32 as u32);
        assert_eq!(bus.read(1, 132, 15).unwrap().data.len(), 15);
        bus.write_u32(2, 116, 512).unwrap();
        bus.write_u8(1, 65, 1).unwrap();
    });
    assert_eq!((servos[1].value(xm430::GOAL_POSITION), servos[0].value(xm430::LED)), (512, 1));
    assert_eq!(
        heard,
        ours(&[
            (2, Instruction::Ping, &[]),
            (1, Instruction::Read, &[146, 0, 1, 0]),
            (1, Instruction::Read, &[144, 0, 2, 0]),
            (2, Instruction::Read, &[132, 0, 4, 0]),
            (1, Instruction::Read, &[132, 0, 15, 0]),
            (2, Instruction::Write, &[116, 0, 0, 2, 0, 0]),
            (1, Instruction::Write, &[65, 0, 1]),
        ])
    );
}

#[test]
fn several_devices() {
    let (servos, heard) = with_servos(|bus| {
        let answers = bus.sync_read_u32(&[2, 1], 132).unwrap();
        let answers: Vec<_> = answers.iter().map(|answer| (answer.motor_id, answer.data as i32)).collect();
        assert_eq!(answers, [(2, -2_079), (1, 166)]);
        let goals =
            [(1, 150u32), (2, 170)].map(|(motor_id, goal)| SyncWriteData { motor_id, data: goal.to_le_bytes() });
        bus.sync_write(116, 4, &goals).unwrap();
        let answers = bus.bulk_read(&[BulkReadData { motor_id: 2, address: 144, count: 2 }]).unwrap();
        assert_eq!(answers[0].data, [119, 0]);
        let limits = [(1, 32, vec![160, 0]), (2, 31, vec![75])];
        let limits = limits.map(|(motor_id, address, data)| BulkWriteData { motor_id, address, data });
        bus.bulk_write(&limits).unwrap();
    });
    assert_eq!(servos[0].value(xm430::GOAL_POSITION), 150);
    assert_eq!(servos[1].value(xm430::GOAL_POSITION), 170);
    assert_eq!(servos[1].value(xm430::TEMPERATURE_LIMIT), 75);
    assert_eq!(
        heard,
        ours(&[
            (254, Instruction::SyncRead, &[132, 0, 4, 0, 2, 1]),
            (254, Instruction::SyncWrite, &[116, 0, 4, 0, 1, 150, 0, 0, 0, 2, 170, 0, 0, 0]),
            (254, Instruction::BulkRead, &[2, 144, 0, 2, 0]),
            (254, Instruction::BulkWrite, &[1, 32, 0, 2, 0, 160, 0, 2, 31, 0, 1, 0, 75]),
        ])
    );
}

#[test]
fn everything_else() {
    let (servos, heard) = with_servos(|bus| {
        bus.reg_write_u32(1, 116, 300).unwrap();
        bus.action(1).unwrap();
        bus.reboot(2).unwrap();
        bus.factory_reset(2, FactoryResetKind::KeepIdAndBaudRate).unwrap();
        bus.clear_revolution_counter(2).unwrap();
        bus.set_baud_rate(SCAN_BAUD).unwrap();
        let found = bus.scan().unwrap();
        bus.set_baud_rate(PATIENT_BAUD).unwrap();
        let found: Vec<u8> = found.into_iter().map(|answer| answer.unwrap().motor_id).collect();
        assert_eq!(found, [1, 2]);
    });
    assert_eq!(servos[0].value(xm430::GOAL_POSITION), 300);
    assert_eq!((servos[1].reboots, servos[1].clears), (1, 1));
    assert_eq!(servos[1].resets, [ResetScope::ExceptIdAndBaudRate]);
    assert_eq!(
        heard,
        ours(&[
            (1, Instruction::RegWrite, &[116, 0, 44, 1, 0, 0]),
            (1, Instruction::Action, &[]),
            (2, Instruction::Reboot, &[]),
            (2, Instruction::FactoryReset, &[2]),
            (2, Instruction::Clear, &[1, 0x44, 0x58, 0x4C, 0x22]),
            (254, Instruction::Ping, &[]),
        ])
    );
}

#[test]
fn errors_are_understood() {
    with_servos(|bus| {
        assert_eq!(refused(bus.write_u32(1, 132, 0)), 7);
        assert_eq!(refused(bus.write_u16(1, 116, 0)), 5);
        assert_eq!(refused(bus.write_u8(1, 64, 9)), 4);
        assert_eq!(refused(bus.write_u32(1, 116, 9_999)), 6);
        assert_eq!(refused(bus.action(1)), 2);
        assert!(matches!(
            bus.ping(77),
            Err(TransferError::ReadError(ReadError::Io(error))) if error.kind() == ErrorKind::TimedOut
        ));
    });
}

/// Random data, rich in what headers and stuffing are made of, there and back.
#[test]
fn stuffing_agrees() {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut writes = Vec::new();
    let (_, heard) = with_servos(|bus| {
        for _ in 0..500 {
            let pool = [0xFF, 0xFF, 0xFD, 0xFD, 0x00, 0x55];
            let data: Vec<u8> = (0..8).map(|_| pool[random.next_u32() as usize % pool.len()]).collect();
            if data.windows(4).any(|four| four == [0xFF, 0xFF, 0xFF, 0xFD]) {
                continue;
            }
            // Present Position cannot be written; what counts is the packet.
            assert_eq!(refused(bus.write(1, 132, &data)), 7);
            writes.push([&[132, 0], data.as_slice()].concat());
        }
    });
    assert!(writes.len() > 300);
    let expected: Vec<_> = writes.iter().map(|write| (1, Instruction::Write, write.as_slice())).collect();
    assert_eq!(heard, ours(&expected));

    let mut servo = Servo::new(1);
    for data in heard.chunks_exact(60) {
        if data.windows(4).any(|four| four == [0xFF, 0xFF, 0xFF, 0xFD]) {
            continue;
        }
        servo.memory[76..136].copy_from_slice(data);
        let line = Line::new(vec![servo.clone()]);
        let mut theirs = open(&line);
        assert_eq!(theirs.read(1, 76, 60).unwrap().data, data);
        let (_, heard) = line.end();
        assert_eq!(heard, encode(&mut [0; 64], Id::new(1).unwrap(), Instruction::Read, &[76, 0, 60, 0]).unwrap());
    }
}
