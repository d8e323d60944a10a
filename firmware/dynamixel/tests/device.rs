//! The servo's side alone: what it answers, when, and when it keeps silent.

mod servo;

use dynamixel::{
    BROADCAST_PING_SLOT_US, Decoder, Device, Encoder, Id, Instruction, ResetScope, StatusError, Timing, encode,
    examples, xm430,
};
use servo::Servo;

const TIMING: Timing = Timing::at(1_000_000);

/// An answer taken apart: delay, address, alert, error, data.
type Answer = (u32, u8, bool, Option<StatusError>, Vec<u8>);

fn hear(device: &mut Device<128>, servo: &mut Servo, mut bytes: &[u8]) -> Vec<Answer> {
    let mut answers = Vec::new();
    while let Some(reply) = device.hear(0, &mut bytes, servo) {
        let mut decoder = Decoder::<128>::new();
        let mut rest = reply.bytes;
        let packet = decoder.feed(&mut rest).unwrap().unwrap();
        assert!(rest.is_empty());
        let status = packet.status().unwrap();
        answers.push((reply.delay_us, status.id.get(), status.alert, status.error, status.parameters.to_vec()));
    }
    answers
}

fn instruction(id: u8, instruction: Instruction, parameters: &[u8]) -> Vec<u8> {
    let id = if id == 254 { Id::BROADCAST } else { Id::new(id).unwrap() };
    encode(&mut [0; 256], id, instruction, parameters).unwrap().to_vec()
}

fn status(id: u8) -> Vec<u8> {
    Encoder::status(&mut [0; 32], Id::new(id).unwrap(), false, None).bytes(&[1, 2]).finish().unwrap().to_vec()
}

/// The answer of device 1 without delay or alert.
fn said(error: Option<StatusError>, data: &[u8]) -> Vec<Answer> {
    vec![(0, 1, false, error, data.to_vec())]
}

fn example(name: &str) -> &'static [u8] {
    examples::EXAMPLES.iter().find(|example| example.name == name).unwrap().bytes
}

#[test]
fn the_published_dialogues() {
    let mut device = Device::<128>::new(TIMING);
    let mut first = Servo::new(1);
    first.put(xm430::MODEL_NUMBER, 1030);
    first.put(xm430::FIRMWARE_VERSION, 38);
    first.put(xm430::PRESENT_POSITION, 166);
    first.put(xm430::PRESENT_INPUT_VOLTAGE, 119);
    let dialogues = [
        ("ping", "ping of 1: status"),
        ("read of present position", "read of present position: status, 166"),
        ("write of goal position, 512", "write: status"),
        ("reg write of goal velocity, 200", "write: status"),
        ("action", "write: status"),
        ("factory reset except id", "write: status"),
        ("reboot", "write: status"),
        ("clear of the turns", "write: status"),
        ("sync read of present position", "read of present position: status, 166"),
        ("bulk read of voltage and temperature", "bulk read: status of 1, 11.9 V"),
    ];
    for (question, answer) in dialogues {
        let mut bytes = example(question);
        let reply = device.hear(0, &mut bytes, &mut first).map(|reply| reply.bytes.to_vec());
        assert_eq!(reply.as_deref(), Some(example(answer)), "{question}");
        assert!(bytes.is_empty());
    }
    assert_eq!(first.value(xm430::GOAL_POSITION), 512);
    assert_eq!(first.value(xm430::GOAL_VELOCITY), 200);
    assert_eq!(first.resets, [ResetScope::ExceptId]);
    assert_eq!((first.reboots, first.clears), (1, 1));

    let mut second = Servo::new(2);
    second.put(xm430::MODEL_NUMBER, 1030);
    second.put(xm430::FIRMWARE_VERSION, 38);
    second.put(xm430::PRESENT_POSITION, 2_079);
    second.put(xm430::PRESENT_TEMPERATURE, 36);
    let dialogues: [(&[&str], &str); 3] = [
        (&["broadcast ping"], "broadcast ping: status of 2"),
        (&["sync read of present position", "read of present position: status, 166"], "sync read: status of 2, 2079"),
        (
            &["bulk read of voltage and temperature", "bulk read: status of 1, 11.9 V"],
            "bulk read: status of 2, 36 degrees",
        ),
    ];
    for (heard, answer) in dialogues {
        let mut reply = None;
        for (at, name) in heard.iter().enumerate() {
            assert_eq!(reply, None, "before {at} of {heard:?}");
            reply = device.hear(0, &mut example(name), &mut second).map(|reply| reply.bytes.to_vec());
        }
        assert_eq!(reply.as_deref(), Some(example(answer)), "{heard:?}");
    }
    for (question, servo, expected) in
        [("sync write of goal position, 150 and 170", &mut first, 150), ("", &mut second, 170)]
    {
        let name = if question.is_empty() { "sync write of goal position, 150 and 170" } else { question };
        assert_eq!(device.hear(0, &mut example(name), servo), None);
        assert_eq!(servo.value(xm430::GOAL_POSITION), expected);
    }
    second.put(xm430::TEMPERATURE_LIMIT, 70);
    for servo in [&mut first, &mut second] {
        assert_eq!(device.hear(0, &mut example("bulk write of voltage and temperature limits"), servo), None);
    }
    assert_eq!(first.value(xm430::MAX_VOLTAGE_LIMIT), 160);
    assert_eq!(second.value(xm430::TEMPERATURE_LIMIT), 80);
}

#[test]
fn refusals() {
    let (mut device, mut servo) = (Device::new(TIMING), Servo::new(1));
    let mut ask = |code, parameters: &[u8]| hear(&mut device, &mut servo, &instruction(1, code, parameters));
    use Instruction::{Action, Clear, ControlTableBackup, FactoryReset, FastSyncRead, Read, SyncRead, Write};
    assert_eq!(ask(Write, &[116, 0, 0, 8]), said(Some(StatusError::DataLength), &[]));
    assert_eq!(ask(Write, &[116, 0]), said(Some(StatusError::DataLength), &[]));
    assert_eq!(ask(Write, &[116]), said(Some(StatusError::DataLength), &[]));
    assert_eq!(ask(Write, &[132, 0, 1, 0, 0, 0]), said(Some(StatusError::Access), &[]));
    assert_eq!(ask(Write, &[0xE8, 3, 1]), said(Some(StatusError::Access), &[]));
    assert_eq!(ask(Write, &[64, 0, 2]), said(Some(StatusError::DataRange), &[]));
    assert_eq!(ask(Write, &[116, 0, 0x88, 0x13, 0, 0]), said(Some(StatusError::DataLimit), &[]));
    assert_eq!(ask(Read, &[132, 0, 4]), said(Some(StatusError::DataLength), &[]));
    assert_eq!(ask(Read, &[132, 0, 0, 0]), said(Some(StatusError::DataLength), &[]));
    assert_eq!(ask(Read, &[132, 0, 0xFF, 0xFF]), said(Some(StatusError::DataLength), &[]));
    assert_eq!(ask(Read, &[0xE8, 3, 4, 0]), said(Some(StatusError::Access), &[]));
    assert_eq!(ask(Action, &[]), said(Some(StatusError::Instruction), &[]));
    assert_eq!(ask(FactoryReset, &[3]), said(Some(StatusError::DataRange), &[]));
    assert_eq!(ask(Clear, &[1, 2, 3, 4, 5]), said(Some(StatusError::DataRange), &[]));
    assert_eq!(ask(ControlTableBackup, &[1]), said(Some(StatusError::DataLength), &[]));
    assert_eq!(ask(ControlTableBackup, &[1, 2, 3, 4, 5]), said(Some(StatusError::DataRange), &[]));
    assert_eq!(ask(ControlTableBackup, b"\x03CTRL"), said(Some(StatusError::DataRange), &[]));
    assert_eq!(ask(ControlTableBackup, b"\x01CTRL"), said(None, &[]));
    for undefined in [SyncRead, FastSyncRead] {
        assert_eq!(ask(undefined, &[]), said(Some(StatusError::Instruction), &[]));
    }
    let unknown = Encoder::with_code(&mut [0; 32], Id::new(1).unwrap(), 0x77).finish().unwrap().to_vec();
    assert_eq!(hear(&mut device, &mut servo, &unknown), said(Some(StatusError::Instruction), &[]));
    servo.put(xm430::TORQUE_ENABLE, 1);
    let locked = instruction(1, Instruction::Write, &[9, 0, 0]);
    assert_eq!(hear(&mut device, &mut servo, &locked), said(Some(StatusError::Access), &[]));
    assert_eq!(servo.value(xm430::GOAL_POSITION), 0);
}

#[test]
fn damage_is_reported_by_the_device_addressed() {
    let (mut device, mut servo) = (Device::new(TIMING), Servo::new(1));
    let mut damaged = instruction(1, Instruction::Write, &[64, 0, 1]);
    damaged[10] ^= 0x40;
    assert_eq!(hear(&mut device, &mut servo, &damaged), said(Some(StatusError::Crc), &[]));
    assert_eq!(servo.value(xm430::TORQUE_ENABLE), 0);
    damaged[4] = 2;
    assert_eq!(hear(&mut device, &mut servo, &damaged), []);
    let mut own = status(1);
    own[9] ^= 1;
    assert_eq!(hear(&mut device, &mut servo, &own), []);
    assert_eq!(hear(&mut device, &mut servo, &instruction(1, Instruction::Write, &[64, 0, 1])), said(None, &[]));
    assert_eq!(servo.value(xm430::TORQUE_ENABLE), 1);
}

#[test]
fn alert_delay_and_level() {
    let (mut device, mut servo) = (Device::new(TIMING), Servo::new(4));
    servo.put(xm430::HARDWARE_ERROR_STATUS, 4);
    servo.put(xm430::RETURN_DELAY_TIME, 100);
    let ping = instruction(4, Instruction::Ping, &[]);
    let read = instruction(4, Instruction::Read, &[122, 0, 1, 0]);
    let write = instruction(4, Instruction::Write, &[65, 0, 1]);
    let broadcast = instruction(254, Instruction::Ping, &[]);
    let identity = vec![0xFC, 0x03, 45];
    assert_eq!(hear(&mut device, &mut servo, &write), [(200, 4, true, None, vec![])]);
    let slot = 200 + 4 * BROADCAST_PING_SLOT_US;
    assert_eq!(hear(&mut device, &mut servo, &broadcast), [(slot, 4, true, None, identity.clone())]);
    let sync = [instruction(254, Instruction::SyncRead, &[122, 0, 1, 0, 9, 4]), status(9)].concat();
    for (level, answers) in [(2, 4), (1, 3), (0, 1)] {
        servo.put(xm430::STATUS_RETURN_LEVEL, level);
        let all = [&ping[..], &read, &sync, &write].concat();
        let heard = hear(&mut device, &mut servo, &all);
        assert_eq!(heard.len(), answers, "level {level}");
        assert_eq!(heard[0].4, identity);
    }
    // A write to the level is still answered at the level that was.
    servo.put(xm430::STATUS_RETURN_LEVEL, 2);
    let quiet = instruction(4, Instruction::Write, &[68, 0, 0]);
    assert_eq!(hear(&mut device, &mut servo, &quiet).len(), 1);
    assert_eq!(hear(&mut device, &mut servo, &quiet), []);
}

#[test]
fn a_new_address_holds_after_the_answer() {
    let (mut device, mut servo) = (Device::new(TIMING), Servo::new(1));
    let rename = instruction(1, Instruction::Write, &[7, 0, 5]);
    assert_eq!(hear(&mut device, &mut servo, &rename), said(None, &[]));
    assert_eq!(hear(&mut device, &mut servo, &instruction(1, Instruction::Ping, &[])), []);
    assert_eq!(hear(&mut device, &mut servo, &instruction(5, Instruction::Ping, &[]))[0].1, 5);
}

#[test]
fn broadcasts_are_carried_out_in_silence() {
    let (mut device, mut servo) = (Device::new(TIMING), Servo::new(1));
    let mut tell = |code, parameters: &[u8]| hear(&mut device, &mut servo, &instruction(254, code, parameters));
    assert_eq!(tell(Instruction::Write, &[65, 0, 1]), []);
    assert_eq!(tell(Instruction::Read, &[65, 0, 1, 0]), []);
    assert_eq!(tell(Instruction::Reboot, &[]), []);
    assert_eq!(tell(Instruction::Write, &[132, 0, 1, 0, 0, 0]), []);
    assert_eq!(tell(Instruction::SyncWrite, &[116, 0, 4, 0, 1, 9, 0, 0]), []);
    assert_eq!(tell(Instruction::SyncWrite, &[116, 0, 0, 0, 1]), []);
    assert_eq!(tell(Instruction::SyncWrite, &[116, 0]), []);
    assert_eq!(tell(Instruction::BulkWrite, &[1, 116, 0, 4, 0, 9]), []);
    assert_eq!(tell(Instruction::BulkRead, &[1, 116, 0, 4]), []);
    assert_eq!(servo.value(xm430::LED), 1);
    assert_eq!(servo.value(xm430::GOAL_POSITION), 0);
    assert_eq!((servo.reboots, servo.reads), (1, 0));
    // "Reset all" is never obeyed by broadcast.
    let reset = instruction(254, Instruction::FactoryReset, &[0xFF]);
    assert_eq!(hear(&mut device, &mut servo, &reset), []);
    assert_eq!(servo.resets, []);
}

#[test]
fn turns_are_kept_and_forgotten() {
    let (mut device, mut servo) = (Device::new(TIMING), Servo::new(3));
    let read = instruction(254, Instruction::SyncRead, &[122, 0, 1, 0, 7, 5, 3]);
    assert_eq!(hear(&mut device, &mut servo, &read), []);
    assert_eq!(hear(&mut device, &mut servo, &status(7)), []);
    assert_eq!(hear(&mut device, &mut servo, &status(5)).len(), 1);
    assert_eq!(hear(&mut device, &mut servo, &status(5)), []);
    // Another instruction ends the waiting.
    assert_eq!(hear(&mut device, &mut servo, &read), []);
    assert_eq!(hear(&mut device, &mut servo, &instruction(9, Instruction::Ping, &[])), []);
    assert_eq!(hear(&mut device, &mut servo, &status(5)), []);
    // What cannot be read is refused in its turn.
    let beyond = instruction(254, Instruction::SyncRead, &[0xE8, 3, 1, 0, 5, 3]);
    assert_eq!(hear(&mut device, &mut servo, &beyond), []);
    assert_eq!(hear(&mut device, &mut servo, &status(5)), [(0, 3, false, Some(StatusError::Access), vec![])]);
}

#[test]
fn a_registered_write_waits_for_its_action() {
    let (mut device, mut servo) = (Device::new(TIMING), Servo::new(1));
    assert_eq!(hear(&mut device, &mut servo, &instruction(1, Instruction::RegWrite, &[65, 0, 1])), said(None, &[]));
    assert_eq!(servo.value(xm430::LED), 0);
    assert_eq!(servo.value(xm430::REGISTERED_INSTRUCTION), 1);
    assert_eq!(hear(&mut device, &mut servo, &instruction(254, Instruction::Action, &[])), []);
    assert_eq!(servo.value(xm430::LED), 1);
    assert_eq!(servo.value(xm430::REGISTERED_INSTRUCTION), 0);
}

#[test]
fn the_longest_read_fits_whatever_the_bytes_are() {
    let (mut device, mut servo) = (Device::new(TIMING), Servo::new(1));
    let longest = Device::<128>::LONGEST_READ;
    assert_eq!(longest, 87);
    for (at, byte) in servo.memory[52..52 + longest].iter_mut().enumerate() {
        *byte = [0xFF, 0xFF, 0xFD][at % 3];
    }
    // The alert comes from the bytes just written; return level and torque lock do not matter to a read.
    servo.put(xm430::STATUS_RETURN_LEVEL, 2);
    let expected = servo.memory[52..52 + longest].to_vec();
    let read = instruction(1, Instruction::Read, &[52, 0, longest as u8, 0]);
    assert_eq!(hear(&mut device, &mut servo, &read)[0].4, expected);
    let more = instruction(1, Instruction::Read, &[52, 0, longest as u8 + 1, 0]);
    assert_eq!(hear(&mut device, &mut servo, &more)[0].3, Some(StatusError::DataLength));
}

/// The e-Manual's examples of Fast Sync Read and Fast Bulk Read: each device adds its block behind the others'.
#[test]
fn the_published_fast_reads() {
    let sync: [(u8, i32, &[u8]); 3] = [
        (3, 166, &[0xFF, 0xFF, 0xFD, 0, 0xFE, 0x19, 0, 0x55, 0, 3, 0xA6, 0, 0, 0, 0x84, 0x08]),
        (7, 2_079, &[0, 7, 0x1F, 8, 0, 0, 0x16, 0xCA]),
        (4, 1_023, &[0, 4, 0xFF, 3, 0, 0, 0xD1, 0x9E]),
    ];
    let question = instruction(254, Instruction::FastSyncRead, &[132, 0, 4, 0, 3, 7, 4]);
    assert_eq!(question[15..], [0x20, 0xF2]);
    let bulk: [(u8, i32, &[u8]); 3] = [
        (3, 166, &[0xFF, 0xFF, 0xFD, 0, 0xFE, 0x14, 0, 0x55, 0, 3, 0xA6, 0, 0, 0, 0x67, 0xA4]),
        (7, 0, &[0, 7, 0xA5, 1, 0x24, 0x74]),
        (4, 0, &[0, 4, 0x1F, 0xD9, 0xC1]),
    ];
    let entries = [3, 132, 0, 4, 0, 7, 124, 0, 2, 0, 4, 146, 0, 1, 0];
    let dialogues = [(question, sync), (instruction(254, Instruction::FastBulkRead, &entries), bulk)];
    for (question, answer) in dialogues {
        let mut devices = answer.map(|(id, position, _)| {
            let mut servo = Servo::new(id);
            servo.put(xm430::PRESENT_POSITION, position);
            servo.put(xm430::PRESENT_PWM, 421);
            servo.put(xm430::PRESENT_TEMPERATURE, 31);
            servo.put(xm430::RETURN_DELAY_TIME, 10);
            (Device::<128>::new(TIMING), servo)
        });
        let mut heard = vec![question];
        for (place, (.., expected)) in answer.iter().enumerate() {
            for (index, (device, servo)) in devices.iter_mut().enumerate() {
                let mut bytes = heard.last().unwrap().as_slice();
                let reply = device.hear(0, &mut bytes, servo).map(|reply| (reply.delay_us, reply.bytes.to_vec()));
                // Only the first waits for its return delay: the others continue its packet.
                let delay = if place == 0 { 20 } else { 0 };
                assert_eq!(reply, (index == place).then(|| (delay, expected.to_vec())));
            }
            heard.push(expected.to_vec());
        }
    }
}

/// What a device adds to a fast answer of 3 and 4 (or 4 and 3) of which it hears this.
fn block(servo: &mut Servo, ids: [u8; 2], heard: &[u8]) -> Option<Vec<u8>> {
    let mut device = Device::<128>::new(TIMING);
    let question = instruction(254, Instruction::FastSyncRead, &[122, 0, 1, 0, ids[0], ids[1]]);
    let bytes = [&question[..], heard].concat();
    device.hear(0, &mut bytes.as_slice(), servo).map(|reply| reply.bytes.to_vec())
}

#[test]
fn a_block_keeps_its_place_whatever_is_wrong() {
    let mut servo = Servo::new(4);
    let first = [0xFF, 0xFF, 0xFD, 0, 0xFE, 11, 0, 0x55, 0, 3, 0x40];
    let crc = dynamixel::crc::update(0, &first).to_le_bytes();
    let ahead = [&first[..], &crc].concat();
    assert_eq!(block(&mut servo, [3, 4], &ahead).map(|block| block.len()), Some(5));
    // Any damage ahead of it, and it says nothing: the packet is lost anyway.
    for at in 0..ahead.len() {
        let mut damaged = ahead.clone();
        damaged[at] ^= 0x10;
        assert_eq!(block(&mut servo, [3, 4], &damaged), None, "{at}");
    }
    assert_eq!(block(&mut servo, [3, 4], &ahead[1..]), None);
    // What cannot be read is as long as what can; the alert is in the block too.
    servo.put(xm430::HARDWARE_ERROR_STATUS, 4);
    let mut device = Device::<128>::new(TIMING);
    let question = instruction(254, Instruction::FastSyncRead, &[0xE8, 3, 2, 0, 4]);
    let reply = device.hear(0, &mut question.as_slice(), &mut servo).unwrap();
    assert_eq!(reply.bytes[..12], [0xFF, 0xFF, 0xFD, 0, 0xFE, 7, 0, 0x55, 0x87, 4, 0, 0]);
    servo.put(xm430::STATUS_RETURN_LEVEL, 0);
    assert_eq!(block(&mut servo, [4, 3], &[]), None);
}

/// Those before may be silent: whoever waits speaks when each of them has had its time.
#[test]
fn silence_before_does_not_silence_for_ever() {
    let (mut device, mut servo) = (Device::<128>::new(TIMING), Servo::new(3));
    let read = instruction(254, Instruction::SyncRead, &[122, 0, 1, 0, 7, 5, 3]);
    assert_eq!(hear(&mut device, &mut servo, &read), []);
    // An answer of one byte is 13 bytes at most, 10 µs each.
    let turn = u64::from(TIMING.latency_us) + 130;
    assert_eq!(device.deadline(), Some(2 * turn));
    assert_eq!(device.poll(2 * turn - 1, &mut servo), None);
    let late = device.poll(2 * turn, &mut servo).unwrap();
    assert_eq!((late.delay_us, late.bytes[4]), (0, 3));
    assert_eq!(device.poll(9 * turn, &mut servo), None);
    assert_eq!(device.deadline(), None);
    // Once 7 has spoken only 5 is waited for; a damaged answer was one too.
    assert_eq!(hear(&mut device, &mut servo, &read), []);
    let mut damaged = status(7);
    damaged[9] ^= 1;
    assert_eq!(device.hear(500, &mut damaged.as_slice(), &mut servo), None);
    assert_eq!(device.deadline(), Some(500 + turn));
    // Addresses that nobody can have are not waited for.
    let read = instruction(254, Instruction::SyncRead, &[122, 0, 1, 0, 255, 254, 3]);
    assert_eq!(hear(&mut device, &mut servo, &read).len(), 1);
}

/// A question cut short is given up after a pause, and does not hide the one that follows it.
#[test]
fn a_pause_ends_a_packet() {
    let (mut device, mut servo) = (Device::<128>::new(TIMING), Servo::new(1));
    let ping = instruction(1, Instruction::Ping, &[]);
    let long = instruction(1, Instruction::Write, &[0; 100]);
    // The header of an answer to a fast read hides everything for its length, as it is not stuffed.
    let fast = [0xFF, 0xFF, 0xFD, 0, 0xFE, 100, 0, 0x55, 0];
    for cut in [&long[..20], &fast] {
        assert_eq!(device.hear(0, &mut &cut[..], &mut servo), None);
        let pause = device.deadline().unwrap();
        assert_eq!(device.poll(pause, &mut servo), None);
        assert_eq!(device.deadline(), None);
        assert!(device.hear(pause, &mut &ping[..], &mut servo).is_some());
        // Without a pause it is found as well.
        assert_eq!(device.hear(pause, &mut &cut[..], &mut servo), None);
        assert!(device.hear(pause, &mut &ping[..], &mut servo).is_some());
    }
}
