//! A Dynamixel bus on which anything is said, heard by a tap and by a device: both bounded, and right afterwards.
//!
//! Input: pieces of a byte that tells length and pause, and the piece.

use dynamixel::{
    ControlTable, Decoder, Device, Encoder, Heard, Id, Instruction, StatusError, Tap, Timing, Value, encode, xm430,
};

use crate::Target;

pub(crate) const TARGET: Target = Target { name: "bus", run, seeds, words: Vec::new };

const LONGEST: usize = 128;
const TIMING: Timing = Timing::at(1_000_000);
const ME: u8 = 7;

/// A table that reads and writes anything.
struct Table([u8; 64]);

impl ControlTable for Table {
    fn id(&self) -> Id {
        Id::new(ME).expect("an address")
    }
    fn model_number(&self) -> u16 {
        1
    }
    fn firmware_version(&self) -> u8 {
        2
    }
    fn read(&mut self, address: u16, bytes: &mut [u8]) -> Result<(), StatusError> {
        assert!(!bytes.is_empty());
        let from = usize::from(address);
        bytes.copy_from_slice(self.0.get(from..from + bytes.len()).ok_or(StatusError::Access)?);
        Ok(())
    }
    fn write(&mut self, address: u16, bytes: &[u8]) -> Result<(), StatusError> {
        assert!(!bytes.is_empty());
        let from = usize::from(address);
        self.0.get_mut(from..from + bytes.len()).ok_or(StatusError::Access)?.copy_from_slice(bytes);
        Ok(())
    }
}

/// What a device says is a status packet of its own, or a block with its address.
fn check(reply: &[u8]) {
    let mut decoder = Decoder::<LONGEST>::new();
    let mut rest = reply;
    let packet = decoder.feed(&mut rest);
    match packet {
        Some(Ok(packet)) => assert!(packet.status().is_some_and(|it| it.id.get() == ME) || packet.is_fast_answer()),
        _ => assert!(reply[1] == ME || reply.starts_with(&[0xFF, 0xFF, 0xFD, 0x00, 0xFE]), "{reply:02X?}"),
    }
}

fn run(bytes: &[u8]) {
    let mut tap = Tap::<LONGEST, 4>::new(TIMING);
    let mut device = Device::<LONGEST>::new(TIMING);
    let mut table = Table([0; 64]);
    (1..5).for_each(|id| assert!(tap.watch(Id::new(id).expect("an address"))));
    let mut now_us = 0;
    let mut rest = bytes;
    while let Some((&head, behind)) = rest.split_first() {
        let (piece, next) = behind.split_at(usize::from(head >> 2).min(behind.len()));
        rest = next;
        now_us += [10, 300, 3_000, 100_000][usize::from(head & 3)] + 10 * piece.len() as u64;
        let mut heard = piece;
        while let Some(heard) = tap.hear(now_us, &mut heard) {
            if let Heard::Read { bytes, .. } | Heard::Written { bytes, .. } = heard {
                assert!(bytes.len() <= LONGEST);
            }
        }
        let mut heard = piece;
        while let Some(reply) = device.hear(now_us, &mut heard, &mut table) {
            check(reply.bytes);
        }
        if let Some(reply) = device.poll(now_us, &mut table) {
            check(reply.bytes);
        }
    }
    // Whatever it was: after a pause a question is heard, and its answer learned.
    let one = Id::new(1).expect("an address");
    let mut buffers = [[0; 32]; 3];
    let [question, answer, ping] = &mut buffers;
    let mut question = encode(question, one, Instruction::Read, &[132, 0, 4, 0]).expect("it fits");
    let answer = Encoder::status(answer, one, false, None).bytes(&123_456i32.to_bytes()).finish();
    let (mut answer, mut later_us) = (answer.expect("it fits"), now_us + 200_000);
    while tap.hear(later_us, &mut question).is_some() {}
    later_us += 200;
    let learned = tap.hear(later_us, &mut answer);
    assert!(matches!(learned, Some(Heard::Read { address, .. }) if address == xm430::PRESENT_POSITION.address()));
    let position = tap.servo(one).and_then(|servo| servo.position);
    assert_eq!(position.map(|seen| (seen.value, seen.at_us)), Some((123_456, later_us)));
    let mut ping = encode(ping, table.id(), Instruction::Ping, &[]).expect("it fits");
    let mut answers = 0;
    while let Some(reply) = device.hear(later_us, &mut ping, &mut table) {
        check(reply.bytes);
        answers += 1;
    }
    assert!(answers >= 1);
}

/// Dialogues: a piece per packet.
fn seeds() -> Vec<Vec<u8>> {
    let packet = |id: u8, code: Instruction, parameters: &[u8]| {
        let id = Id::new(id).unwrap_or(Id::BROADCAST);
        encode(&mut [0; 64], id, code, parameters).expect("it fits").to_vec()
    };
    let status = |id: u8, data: &[u8]| packet(id, Instruction::Status, &[&[0], data].concat());
    let position = [0xA6, 0, 0, 0];
    let dialogues: [Vec<Vec<u8>>; 9] = [
        vec![packet(1, Instruction::Read, &[132, 0, 4, 0]), status(1, &position)],
        vec![packet(254, Instruction::SyncRead, &[132, 0, 4, 0, 1, 2, ME]), status(1, &position), status(2, &position)],
        vec![packet(254, Instruction::BulkRead, &[1, 132, 0, 4, 0, ME, 3, 0, 2, 0]), status(1, &position)],
        vec![
            packet(254, Instruction::FastSyncRead, &[132, 0, 4, 0, 3, ME, 4]),
            vec![0xFF, 0xFF, 0xFD, 0, 0xFE, 0x19, 0, 0x55, 0, 3, 0xA6, 0, 0, 0, 0x84, 0x08],
        ],
        vec![packet(254, Instruction::FastBulkRead, &[ME, 1, 0, 4, 0, 1, 132, 0, 4, 0])],
        vec![packet(ME, Instruction::RegWrite, &[3, 0, 1]), packet(254, Instruction::Action, &[])],
        vec![packet(2, Instruction::Write, &[168, 0, 132, 0, 133, 0, 134, 0, 135, 0]), status(2, &[])],
        vec![
            packet(254, Instruction::SyncWrite, &[168, 0, 2, 0, 1, 132, 0, 2, 133, 0]),
            packet(1, Instruction::Reboot, &[]),
        ],
        vec![
            packet(254, Instruction::BulkWrite, &[1, 64, 0, 1, 0, 1]),
            packet(1, Instruction::Ping, &[]),
            status(1, &[0xFC, 3, 45]),
        ],
    ];
    let input = |dialogue: Vec<Vec<u8>>| {
        dialogue.into_iter().flat_map(|packet| [vec![(packet.len() as u8) << 2], packet].concat()).collect()
    };
    dialogues.into_iter().map(input).collect()
}
