//! The master against devices: what works, and every way in which it can go wrong.

use dynamixel::{
    Answer, DecodeError, Encoder, Error, Id, Identity, Instruction, StatusError, SyncAnswer, Timing, encode, xm430,
};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use crate::world::Bus;
use crate::{TIMING, id, master, plain};

/// A status packet as device `from` would send it.
fn status(from: u8, data: &[u8]) -> Vec<u8> {
    Encoder::status(&mut [0; 64], id(from), false, None).bytes(data).finish().unwrap().to_vec()
}

#[test]
fn asks_and_is_answered() {
    let bus = Bus::new(&[1, 2]);
    bus.servo(1, |servo| {
        servo.put(xm430::PRESENT_POSITION, -5_000);
        servo.put(xm430::PRESENT_CURRENT, -12);
        servo.put(xm430::PRESENT_INPUT_VOLTAGE, 121);
        servo.put(xm430::RETURN_DELAY_TIME, 250);
    });
    let mut master = master(&bus);
    bus.run(async {
        let identity = Identity { model: 1020, firmware: 45 };
        assert_eq!(master.ping(id(2)).await, Ok(plain(identity)));
        assert_eq!(master.get(id(2), xm430::PRESENT_POSITION).await, Ok(plain(-5_000)));
        assert_eq!(master.get(id(2), xm430::PRESENT_CURRENT).await, Ok(plain(-12)));
        assert_eq!(master.read_i32(id(2), 132).await, Ok(plain(-5_000)));
        assert_eq!(master.read_u32(id(2), 132).await, Ok(plain(-5_000i32 as u32)));
        assert_eq!(master.read_i16(id(2), 126).await, Ok(plain(-12)));
        assert_eq!(master.read_u16(id(2), 144).await, Ok(plain(121)));
        assert_eq!(master.read_u8(id(2), 9).await, Ok(plain(250)));
        assert_eq!(master.set(id(2), xm430::GOAL_POSITION, 2_048).await, Ok(plain(())));
        assert_eq!(master.get(id(2), xm430::GOAL_POSITION).await, Ok(plain(2_048)));
        assert_eq!(master.get(id(1), xm430::GOAL_POSITION).await, Ok(plain(0)));
        let mut several = [0; 10];
        assert_eq!(master.read(id(2), 126, &mut several).await, Ok(plain(())));
        assert_eq!(several, [0xF4, 0xFF, 0, 0, 0, 0, 0x78, 0xEC, 0xFF, 0xFF]);
        assert_eq!(master.reboot(id(1)).await, Ok(plain(())));
    });
    assert_eq!(bus.servo(0, |servo| servo.reboots), 1);
}

#[test]
fn data_that_looks_like_a_header_passes() {
    let bus = Bus::new(&[1]);
    bus.servo(0, |servo| {
        servo.put(xm430::PRESENT_POSITION, i32::from_le_bytes([0xFF, 0xFF, 0xFD, 0x00]));
        servo.put(xm430::PRESENT_VELOCITY, i32::from_le_bytes([0xFF, 0xFF, 0xFD, 0xFF]));
    });
    let mut master = master(&bus);
    let mut bytes = [0; 8];
    assert_eq!(bus.run(master.read(id(1), 128, &mut bytes)), Ok(plain(())));
    assert_eq!(bytes, [0xFF, 0xFF, 0xFD, 0xFF, 0xFF, 0xFF, 0xFD, 0x00]);
}

#[test]
fn several_devices_at_once() {
    let bus = Bus::new(&[1, 7, 3]);
    for (index, position) in [100, 2_079, -3].into_iter().enumerate() {
        bus.servo(index, |servo| servo.put(xm430::PRESENT_POSITION, position));
    }
    let mut master = master(&bus);
    let mut devices = [7, 3, 1].map(|n| SyncAnswer::<_, 4>::new(id(n)));
    assert_eq!(bus.run(master.sync_read(132, &mut devices)), Ok(()));
    let positions = devices.map(|device| device.result.unwrap().map(|answer| i32::from_le_bytes(answer.value)));
    assert_eq!(positions, [Ok(2_079), Ok(-3), Ok(100)]);

    let goals = [(id(1), 150u32.to_le_bytes()), (id(3), 170u32.to_le_bytes())];
    assert_eq!(bus.run(master.sync_write(116, &goals)), Ok(()));
    assert_eq!(bus.run(master.write(Id::BROADCAST, 65, &[1])), Ok(plain(())));
    bus.rest(1_000);
    let goals = [0, 1, 2].map(|index| bus.servo(index, |servo| servo.value(xm430::GOAL_POSITION)));
    assert_eq!(goals, [150, 0, 170]);
    assert_eq!([0, 1, 2].map(|index| bus.servo(index, |servo| servo.value(xm430::LED))), [1, 1, 1]);
}

#[test]
fn a_fast_read_gives_the_same_in_less_time() {
    let bus = Bus::new(&[1, 7, 3]);
    for (index, position) in [100, i32::from_le_bytes([0xFF, 0xFF, 0xFD, 0]), -3].into_iter().enumerate() {
        bus.servo(index, |servo| servo.put(xm430::PRESENT_POSITION, position));
        bus.servo(index, |servo| servo.put(xm430::RETURN_DELAY_TIME, 50));
    }
    bus.servo(2, |servo| servo.put(xm430::HARDWARE_ERROR_STATUS, 1));
    let mut master = master(&bus);
    bus.run(master.ping(id(1))).unwrap();
    let mut devices = [7, 3, 1].map(|n| SyncAnswer::<_, 10>::new(id(n)));
    let start = bus.now_us();
    assert_eq!(bus.run(master.sync_read(126, &mut devices)), Ok(()));
    let (plain, middle) = (devices, bus.now_us());
    assert_eq!(bus.run(master.fast_sync_read(126, &mut devices)), Ok(()));
    assert_eq!(devices, plain);
    let alerts = devices.map(|device| device.result.unwrap().unwrap().alert);
    assert_eq!(alerts, [false, true, false]);
    // Question 17 bytes; three answers of 21 bytes (one with a stuffed byte) against one of 50. One return delay, not three.
    assert_eq!((middle - start, bus.now_us() - middle), (170 + 640 + 300, 170 + 500 + 100));
}

#[test]
fn silence_and_damage_in_a_fast_read_cost_what_is_behind_them() {
    let bus = Bus::new(&[1, 3]);
    let mut master = master(&bus);
    let mut devices = [1, 2, 3].map(|n| SyncAnswer::<_, 4>::new(id(n)));
    assert_eq!(bus.run(master.fast_sync_read(132, &mut devices)), Ok(()));
    assert!(matches!(devices[0].result, Some(Ok(_))));
    assert!(matches!(devices[1].result, Some(Err(Error::Timeout { id: who, .. })) if who == id(2)));
    assert!(matches!(devices[2].result, Some(Err(Error::Timeout { id: who, .. })) if who == id(3)));
    let mut devices = [1, 3].map(|n| SyncAnswer::<_, 4>::new(id(n)));
    for at in 8..16 {
        bus.tamper(move |answer| {
            let mut answer = answer.to_vec();
            answer[at] ^= 1;
            vec![(0, answer)]
        });
        assert_eq!(bus.run(master.fast_sync_read(132, &mut devices)), Ok(()));
        assert_eq!(devices[0].result, Some(Err(Error::Block { id: id(1) })), "{at}");
        assert!(matches!(devices[1].result, Some(Err(Error::Timeout { id: who, .. })) if who == id(3)));
        assert_eq!(bus.run(master.fast_sync_read(132, &mut devices)), Ok(()));
        assert!(devices.iter().all(|device| matches!(device.result, Some(Ok(_)))));
    }
    let refused = bus.run(master.fast_sync_read(1_000, &mut devices));
    let access = |n| Some(Err(Error::Refused { id: id(n), error: StatusError::Access, alert: false }));
    assert_eq!((refused, devices[0].result, devices[1].result), (Ok(()), access(1), access(3)));
}

#[test]
fn every_device_is_discovered() {
    let bus = Bus::new(&[252, 0, 17]);
    bus.servo(2, |servo| servo.put(xm430::HARDWARE_ERROR_STATUS, 1));
    bus.servo(0, |servo| servo.put(xm430::FIRMWARE_VERSION, 44));
    let mut master = master(&bus);
    let mut found = [None; 4];
    assert_eq!(bus.run(master.discover(&mut found)), Ok(3));
    let found: Vec<_> =
        found.into_iter().flatten().map(|it| (it.id.get(), it.identity.reads_fast(), it.alert)).collect();
    assert_eq!(found, [(0, true, false), (17, true, true), (252, false, false)]);
    let mut two = [None; 2];
    assert_eq!(bus.run(master.discover(&mut two)), Ok(2));
    assert!(bus.run(master.ping(id(17))).is_ok());
}

/// ROBOTIS' SDK waits 3 ms per address, and for the bytes of the answers: at a slow rate one takes longer than its slot.
#[test]
fn as_many_answers_are_waited_for_as_there_is_room_for() {
    let bus = Bus::new(&[]);
    let mut master = master(&bus);
    master.set_timing(Timing { baud_rate: 9_600, ..TIMING });
    let mut waited = [1, 16].map(|room| {
        let begun = bus.now_us();
        assert_eq!(bus.run(master.discover(&mut vec![None; room])), Ok(0));
        bus.now_us() - begun
    });
    assert!(waited[0] > 3_000 * 252 + 14_583);
    waited[1] -= waited[0];
    assert!(waited[1].abs_diff(15 * 14_583) < 2_000, "{waited:?}");
}

#[test]
fn a_silent_device_costs_the_deadline_and_no_more() {
    let bus = Bus::new(&[1]);
    let mut master = master(&bus);
    assert!(bus.run(master.ping(id(1))).is_ok());
    let start = bus.now_us();
    let result = bus.run(master.get(id(9), xm430::PRESENT_POSITION));
    let Err(Error::Timeout { id: who, waited_us }) = result else { panic!("{result:?}") };
    assert_eq!(who, id(9));
    // Question 14 bytes, answer at most 17 (stuffed), 10 us each, and the latency.
    assert_eq!(waited_us, 310 + TIMING.latency_us);
    assert_eq!(bus.now_us() - start, 140 + u64::from(waited_us));
    assert!(bus.run(master.ping(id(1))).is_ok());
}

#[test]
fn silence_in_the_middle_of_a_sync_read() {
    let bus = Bus::new(&[1, 3]);
    let mut master = master(&bus);
    let mut devices = [1, 2, 3].map(|n| SyncAnswer::<_, 4>::new(id(n)));
    assert_eq!(bus.run(master.sync_read(132, &mut devices)), Ok(()));
    assert!(matches!(devices[0].result, Some(Ok(_))));
    assert!(matches!(devices[1].result, Some(Err(Error::Timeout { id: who, .. })) if who == id(2)));
    assert!(matches!(devices[2].result, Some(Err(Error::Timeout { id: who, .. })) if who == id(3)));
    let mut devices = [1, 3].map(|n| SyncAnswer::<_, 4>::new(id(n)));
    assert_eq!(bus.run(master.sync_read(132, &mut devices)), Ok(()));
    assert!(devices.iter().all(|device| matches!(device.result, Some(Ok(_)))));
}

#[test]
fn another_device_answers() {
    let bus = Bus::new(&[1]);
    let mut master = master(&bus);
    bus.tamper(|_| vec![(0, status(2, &[0; 4]))]);
    let result = bus.run(master.get(id(1), xm430::PRESENT_POSITION));
    assert_eq!(result, Err(Error::WrongId { expected: id(1), received: id(2) }));
    // Followed by the right answer, it is passed over.
    bus.tamper(|answer| vec![(0, status(2, &[9; 4])), (150, answer.to_vec())]);
    assert_eq!(bus.run(master.get(id(1), xm430::PRESENT_POSITION)), Ok(plain(0)));
}

#[test]
fn damaged_and_truncated_answers() {
    let bus = Bus::new(&[1]);
    let mut master = master(&bus);
    bus.tamper(|answer| {
        let mut bytes = answer.to_vec();
        bytes[10] ^= 0x10;
        vec![(0, bytes)]
    });
    let result = bus.run(master.get(id(1), xm430::PRESENT_POSITION));
    assert!(matches!(result, Err(Error::Damaged(DecodeError::Crc { id: 1, code: 0x55, .. }))), "{result:?}");

    for kept in 1..15 {
        bus.tamper(move |answer| vec![(0, answer[..kept].to_vec())]);
        let result = bus.run(master.get(id(1), xm430::PRESENT_POSITION));
        assert_eq!(result, Err(Error::Truncated { id: id(1), received: kept }));
    }

    // Garbage before the answer, and the tail of another packet.
    bus.tamper(|answer| vec![(0, [&[0xFF, 0xFD, 3, 0xFF, 0xFF, 0xFD, 0x00, 1], answer].concat())]);
    assert_eq!(bus.run(master.get(id(1), xm430::PRESENT_POSITION)), Ok(plain(0)));
}

#[test]
fn refusals_carry_their_reason() {
    let bus = Bus::new(&[1]);
    let mut master = master(&bus);
    let refused = |error| Err(Error::Refused { id: id(1), error, alert: false });
    bus.run(async {
        assert_eq!(master.write(id(1), 132, &[0; 4]).await, refused(StatusError::Access));
        assert_eq!(master.write(id(1), 116, &[0; 2]).await, refused(StatusError::DataLength));
        assert_eq!(master.set(id(1), xm430::TORQUE_ENABLE, 2).await, refused(StatusError::DataRange));
        assert_eq!(master.set(id(1), xm430::GOAL_POSITION, 5_000).await, refused(StatusError::DataLimit));
        assert_eq!(master.read(id(1), 1_000, &mut [0]).await, refused(StatusError::Access));
    });
    for code in 1..=127 {
        bus.tamper(move |_| {
            let error = StatusError::from_code(code);
            vec![(0, Encoder::status(&mut [0; 64], id(1), true, error).finish().unwrap().to_vec())]
        });
        let error = StatusError::from_code(code).unwrap();
        let result = bus.run(master.get(id(1), xm430::MOVING));
        assert_eq!(result, Err(Error::Refused { id: id(1), error, alert: true }));
    }
    bus.servo(0, |servo| servo.put(xm430::HARDWARE_ERROR_STATUS, 0x20));
    let answer = bus.run(master.get(id(1), xm430::HARDWARE_ERROR_STATUS));
    assert_eq!(answer, Ok(Answer { value: 0x20, alert: true }));
}

#[test]
fn an_answer_of_the_wrong_length() {
    let bus = Bus::new(&[1]);
    let mut master = master(&bus);
    for received in [0, 2, 3, 5, 9] {
        bus.tamper(move |_| vec![(0, status(1, &vec![7; received]))]);
        let result = bus.run(master.get(id(1), xm430::PRESENT_POSITION));
        assert_eq!(result, Err(Error::Length { id: id(1), expected: 4, received }));
        bus.tamper(move |_| vec![(0, status(1, &vec![7; received]))]);
        let mut devices = [SyncAnswer::<_, 4>::new(id(1))];
        assert_eq!(bus.run(master.sync_read(132, &mut devices)), Ok(()));
        assert_eq!(devices[0].result, Some(Err(Error::Length { id: id(1), expected: 4, received })));
    }
}

/// However late the first answer comes, within the deadline and the silence waited for after it, the second question
/// gets its own answer.
#[test]
fn a_late_answer_is_not_taken_for_the_next_one() {
    for late in (0..=2_300).step_by(10) {
        let bus = Bus::new(&[1]);
        let mut master = master(&bus);
        bus.servo(0, |servo| servo.put(xm430::PRESENT_POSITION, 111));
        bus.tamper(move |answer| vec![(late, answer.to_vec())]);
        let first = bus.run(master.get(id(1), xm430::PRESENT_POSITION));
        assert!(first == Ok(plain(111)) || first.is_err());
        assert_eq!(first.is_ok(), late <= 1_160, "late by {late}");
        bus.servo(0, |servo| servo.put(xm430::PRESENT_POSITION, 222));
        let second = bus.run(master.get(id(1), xm430::PRESENT_POSITION));
        assert_eq!(second, Ok(plain(222)), "late by {late}");
    }
}

#[test]
fn what_arrived_between_two_questions_is_discarded() {
    let bus = Bus::new(&[1]);
    let mut master = master(&bus);
    assert!(bus.run(master.ping(id(1))).is_ok());
    bus.inject(&status(1, &[9, 9, 9, 9]));
    bus.inject(&[0xFF, 0xFF, 0xFD, 0x00, 1, 90]);
    assert_eq!(bus.run(master.get(id(1), xm430::PRESENT_POSITION)), Ok(plain(0)));
}

#[test]
fn the_echo_of_the_question_is_no_answer() {
    let bus = Bus::new(&[1, 2]);
    bus.0.borrow_mut().echo = true;
    let mut master = master(&bus);
    assert_eq!(bus.run(master.set(id(2), xm430::GOAL_POSITION, 77)), Ok(plain(())));
    assert_eq!(bus.run(master.get(id(2), xm430::GOAL_POSITION)), Ok(plain(77)));
    let mut devices = [2, 1].map(|n| SyncAnswer::<_, 4>::new(id(n)));
    assert_eq!(bus.run(master.sync_read(116, &mut devices)), Ok(()));
    assert!(devices.iter().all(|device| matches!(device.result, Some(Ok(_)))));
    assert!(matches!(bus.run(master.ping(id(5))), Err(Error::Timeout { .. })));
    assert!(bus.run(master.ping(id(1))).is_ok());
    assert_eq!(master.take_foreign(), 0);
}

/// Wherever another master speaks: between two questions, or while an answer is waited for.
#[test]
fn instructions_of_another_master_are_counted() {
    for echo in [false, true] {
        let bus = Bus::new(&[1, 2]);
        bus.0.borrow_mut().echo = echo;
        let mut master = master(&bus);
        assert!(bus.run(master.set(id(2), xm430::GOAL_POSITION, 77)).is_ok());
        let mut buffer = [0; 64];
        let other = dynamixel::encode(&mut buffer, id(2), Instruction::Ping, &[]).unwrap().to_vec();
        bus.inject(&other);
        assert!(bus.run(master.set(id(1), xm430::GOAL_POSITION, 7)).is_ok());
        assert_eq!((master.take_foreign(), master.take_foreign()), (1, 0));
        bus.tamper(move |answer| vec![(0, [other.clone(), answer.to_vec()].concat())]);
        assert!(bus.run(master.get(id(1), xm430::GOAL_POSITION)).is_ok());
        assert_eq!(master.take_foreign(), 1);
    }
}

#[test]
fn endless_chatter_ends() {
    let bus = Bus::new(&[1]);
    let mut master = master(&bus);
    assert!(bus.run(master.ping(id(1))).is_ok());
    bus.tamper(|_| vec![(0, vec![0x55; 100_000])]);
    let result = bus.run(master.get(id(1), xm430::PRESENT_POSITION));
    assert!(matches!(result, Err(Error::Babble { bytes: 90..200 })), "{result:?}");
    let result = bus.run(master.ping(id(1)));
    assert!(matches!(result, Err(Error::Babble { bytes: 512..600 })), "{result:?}");
    bus.rest(1_000_000);
    // What the port has kept of the chatter in its own buffer still has to go.
    let tries = (0..300).find(|_| bus.run(master.ping(id(1))).is_ok());
    assert!(tries.is_some());
}

#[test]
fn what_cannot_be_asked() {
    let bus = Bus::new(&[1]);
    let mut master = master(&bus);
    assert_eq!(bus.run(master.ping(Id::BROADCAST)), Err(Error::Broadcast));
    assert_eq!(bus.run(master.read(Id::BROADCAST, 0, &mut [0; 2])), Err(Error::Broadcast));
    let mut devices = [SyncAnswer::<_, 4>::new(Id::BROADCAST)];
    assert_eq!(bus.run(master.sync_read(0, &mut devices)), Err(Error::Broadcast));
    assert!(matches!(bus.run(master.read(id(1), 0, &mut [0; 120])), Err(Error::TooLong(_))));
    assert!(matches!(bus.run(master.write(id(1), 0, &[0; 120])), Err(Error::TooLong(_))));
    assert_eq!(bus.servo(0, |servo| servo.reads), 0);
}

#[test]
fn a_device_that_answers_reads_only() {
    let bus = Bus::new(&[1]);
    bus.servo(0, |servo| servo.put(xm430::STATUS_RETURN_LEVEL, 1));
    let mut master = master(&bus);
    assert!(matches!(bus.run(master.set(id(1), xm430::LED, 1)), Err(Error::Timeout { .. })));
    let status_return = dynamixel::StatusReturn::Read;
    master.set_timing(Timing { status_return, ..TIMING });
    assert_eq!(bus.run(master.set(id(1), xm430::LED, 0)), Ok(plain(())));
    assert_eq!(bus.run(master.get(id(1), xm430::LED)), Ok(plain(0)));
}

/// Ten thousand answers damaged at random: the true value or an error, and the next question is answered.
#[test]
fn random_damage_gives_the_truth_or_an_error() {
    let mut random = ChaCha8Rng::seed_from_u64(20_240_501);
    let bus = Bus::new(&[1, 2]);
    let mut master = master(&bus);
    let (mut right, mut wrong) = (0, 0);
    for round in 0..10_000 {
        let value = random.next_u32() as i32;
        bus.servo(0, |servo| servo.put(xm430::PRESENT_POSITION, value));
        let kind = random.next_u32() % 5;
        let seed = random.next_u64();
        bus.tamper(move |answer| damage(answer, kind, seed));
        match bus.run(master.get(id(1), xm430::PRESENT_POSITION)) {
            Ok(answer) => {
                assert_eq!(answer, plain(value), "round {round}, damage {kind}");
                right += 1;
            }
            Err(_) => wrong += 1,
        }
        bus.0.borrow_mut().tamper.clear();
        assert!(bus.run(master.ping(id(2))).is_ok(), "round {round}, damage {kind}");
    }
    assert!(right > 1_000 && wrong > 1_000, "{right} right, {wrong} wrong");
}

fn damage(answer: &[u8], kind: u32, seed: u64) -> Vec<(u64, Vec<u8>)> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut pick = |below: usize| random.next_u32() as usize % below;
    let mut bytes = answer.to_vec();
    match kind {
        0 => {
            for _ in 0..=pick(3) {
                let at = pick(bytes.len());
                bytes[at] ^= 1 << pick(8);
            }
        }
        1 => bytes.truncate(pick(bytes.len())),
        2 => {
            bytes.remove(pick(answer.len()));
        }
        3 => {
            let at = pick(bytes.len());
            bytes.insert(at, [0xFF, 0xFD, 0x00, 0x55][pick(4)]);
        }
        _ => {
            let garbage = (0..pick(12)).map(|_| [0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x55][pick(6)]);
            bytes = garbage.chain(answer.iter().copied()).collect();
        }
    }
    vec![(0, bytes)]
}

#[test]
fn an_instruction_of_another_master_is_no_answer() {
    let bus = Bus::new(&[1]);
    let mut master = master(&bus);
    bus.tamper(|answer| {
        let ping = encode(&mut [0; 16], id(1), Instruction::Ping, &[]).unwrap().to_vec();
        vec![(0, ping), (200, answer.to_vec())]
    });
    assert_eq!(bus.run(master.get(id(1), xm430::PRESENT_POSITION)), Ok(plain(0)));
}
