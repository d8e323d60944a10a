//! The answer to a fast read: one packet, to which each device adds its block.
//!
//! ```text
//! FF FF FD 00 | FE | length (2) | 55 | error, id, data, CRC (2) | error, id, data, CRC (2) | …
//! ```
//!
//! The first device sends the header with its block, each further one speaks when the block before its own has ended.
//! A block's CRC covers everything before it from the header on, earlier CRCs included, so the last one is the packet's.
//! Nothing is stuffed. Source: ROBOTIS e-Manual, Protocol 2.0, "Fast Sync Read".

use crate::crc;
use crate::packet::{ALERT, CRC_LENGTH, HEADER, Id, Instruction, PREFIX_LENGTH, StatusError};
use crate::request::Entry;

/// Bytes before the first block.
pub(crate) const FRONT_LENGTH: usize = PREFIX_LENGTH + 1;

/// What comes before the first block.
fn front(length: u16) -> [u8; FRONT_LENGTH] {
    let ([a, b, c, d], [low, high]) = (HEADER, length.to_le_bytes());
    [a, b, c, d, Id::BROADCAST.get(), low, high, Instruction::Status.code()]
}

/// Follows the answer to a fast read byte by byte.
#[derive(Clone, Debug)]
pub(crate) struct FastAnswer {
    /// Length field that the answer must have.
    length: u16,
    /// Bytes of the front that have come.
    front: usize,
    /// CRC of everything up to here.
    crc: u16,
    /// The block that is coming.
    block: usize,
    /// Bytes of it that have come.
    place: usize,
    error: u8,
    crc_low: u8,
}

/// What a byte has completed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    /// Nothing yet.
    More,
    /// A block whose CRC is right.
    Block {
        /// Its place in the instruction's list.
        place: usize,
        /// Its error byte.
        error: u8,
        /// Its data bytes.
        length: usize,
    },
    /// This is not the answer that was asked for, or it is damaged. Nothing further is to be made of it.
    Broken,
}

impl FastAnswer {
    /// Waits for an answer with this length field.
    pub(crate) const fn new(length: u16) -> Self {
        Self { length, front: 0, crc: 0, block: 0, place: 0, error: 0, crc_low: 0 }
    }

    /// Whether the answer has begun for certain.
    pub(crate) fn has_begun(&self) -> bool {
        self.front >= PREFIX_LENGTH
    }

    /// The block that is to come next, if the one before it is complete.
    pub(crate) fn awaits(&self) -> Option<usize> {
        (self.front == FRONT_LENGTH && self.place == 0).then_some(self.block)
    }

    /// Takes a byte. `entry` is the instruction's list; the block's data go to `data` as far as there is room.
    pub(crate) fn push(&mut self, byte: u8, entry: impl Fn(usize) -> Option<Entry>, data: &mut [u8]) -> Step {
        if self.front < FRONT_LENGTH {
            self.find_front(byte);
            return Step::More;
        }
        let Some(Entry { id, length, .. }) = entry(self.block) else {
            return Step::Broken;
        };
        let length = usize::from(length);
        let place = self.place;
        self.place += 1;
        match place {
            0 => self.error = byte,
            1 if byte != id => return Step::Broken,
            1 => {}
            _ if place < 2 + length => {
                if let Some(to) = data.get_mut(place - 2) {
                    *to = byte;
                }
            }
            _ if place == 2 + length => {
                self.crc_low = byte;
                return Step::More;
            }
            _ => {
                let given = [self.crc_low, byte];
                if u16::from_le_bytes(given) != self.crc {
                    return Step::Broken;
                }
                self.crc = crc::update(self.crc, &given);
                self.place = 0;
                self.block += 1;
                return Step::Block { place: self.block - 1, error: self.error, length };
            }
        }
        self.crc = crc::update(self.crc, &[byte]);
        Step::More
    }

    fn find_front(&mut self, byte: u8) {
        let front = front(self.length);
        if front.get(self.front) == Some(&byte) {
            self.front += 1;
        } else {
            // The front repeats itself only in its first two bytes.
            self.front = match (byte, self.front) {
                (0xFF, 2) => 2,
                (0xFF, _) => 1,
                _ => 0,
            };
        }
        if self.front == FRONT_LENGTH {
            self.crc = crc::update(0, &front);
        }
    }

    /// Writes a block to be sent now: the front too if it is the first one. Gives its length; nothing if it does not fit.
    pub(crate) fn write(&self, block: &Block<'_>, into: &mut [u8]) -> Option<usize> {
        let front = front(self.length);
        let (crc, front): (u16, &[u8]) = if self.front == FRONT_LENGTH { (self.crc, &[]) } else { (0, &front) };
        let number = block.error.map_or(0, StatusError::code) | if block.alert { ALERT } else { 0 };
        let end = front.len() + 2 + block.data.len();
        let (covered, rest) = into.split_at_mut_checked(end)?;
        let head = [number, block.id.get()];
        let bytes = front.iter().chain(&head).chain(block.data);
        for (to, byte) in covered.iter_mut().zip(bytes) {
            *to = *byte;
        }
        let crc = crc::update(crc, covered).to_le_bytes();
        rest.get_mut(..CRC_LENGTH)?.copy_from_slice(&crc);
        Some(end + CRC_LENGTH)
    }
}

/// A device's part of the answer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Block<'a> {
    pub(crate) id: Id,
    pub(crate) alert: bool,
    pub(crate) error: Option<StatusError>,
    /// As many bytes as were asked for, whatever the error.
    pub(crate) data: &'a [u8],
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::packet::fast_length;
    use std::vec::Vec;

    /// The e-Manual's example of Fast Sync Read: 3, 7 and 4 give positions 166, 2079 and 1023.
    const PUBLISHED: [(u8, [u8; 4], [u8; 2]); 3] =
        [(3, [0xA6, 0, 0, 0], [0x84, 0x08]), (7, [0x1F, 8, 0, 0], [0x16, 0xCA]), (4, [0xFF, 3, 0, 0], [0xD1, 0x9E])];
    const FRONT: [u8; 8] = [0xFF, 0xFF, 0xFD, 0x00, 0xFE, 0x19, 0x00, 0x55];

    fn entry(place: usize) -> Option<Entry> {
        PUBLISHED.get(place).map(|&(id, ..)| Entry { id, address: 132, length: 4 })
    }

    fn published() -> Vec<u8> {
        let mut bytes = FRONT.to_vec();
        for (id, data, crc) in PUBLISHED {
            bytes.extend([0, id]);
            bytes.extend(data);
            bytes.extend(crc);
        }
        bytes
    }

    #[test]
    fn the_published_answer_is_followed() {
        assert_eq!(fast_length([4; 3].into_iter()), Some(0x19));
        for noise in [&[][..], &[0xFF], &[0xFF, 0xFF, 0xFF], &[1, 0xFF, 0xFF, 0xFD, 0x00, 0xFE, 0x18]] {
            let mut answer = FastAnswer::new(0x19);
            let mut data = [0; 4];
            let mut found = Vec::new();
            for &byte in noise.iter().chain(&published()) {
                match answer.push(byte, entry, &mut data) {
                    Step::More => {}
                    Step::Block { place, error, length } => found.push((place, error, length, data)),
                    Step::Broken => panic!("{noise:?}"),
                }
            }
            let expected: Vec<_> =
                PUBLISHED.iter().enumerate().map(|(place, &(_, data, _))| (place, 0, 4, data)).collect();
            assert_eq!(found, expected);
            assert_eq!(answer.push(0, entry, &mut data), Step::Broken);
        }
    }

    #[test]
    fn each_block_is_written_as_published() {
        let mut heard = FastAnswer::new(0x19);
        let mut whole = Vec::new();
        for (place, (id, data, _)) in PUBLISHED.into_iter().enumerate() {
            assert_eq!(heard.awaits(), (place > 0).then_some(place));
            let mut buffer = [0; 32];
            let block = Block { id: Id::new(id).unwrap(), alert: false, error: None, data: &data };
            let length = heard.write(&block, &mut buffer).unwrap();
            assert_eq!(heard.write(&block, &mut buffer[..length - 1]), None);
            for &byte in &buffer[..length] {
                assert_ne!(heard.push(byte, entry, &mut []), Step::Broken);
            }
            whole.extend_from_slice(&buffer[..length]);
        }
        assert_eq!(whole, published());
    }

    /// A damaged byte costs its block and those behind it, never those before.
    #[test]
    fn damage_ends_the_answer_where_it_is() {
        for at in 8..published().len() {
            for bit in 0..8 {
                let mut bytes = published();
                bytes[at] ^= 1 << bit;
                let mut answer = FastAnswer::new(0x19);
                let steps: Vec<Step> = bytes.iter().map(|&byte| answer.push(byte, entry, &mut [])).collect();
                let first = steps.iter().position(|&step| step == Step::Broken).unwrap();
                let blocks = steps[..first].iter().filter(|step| matches!(step, Step::Block { .. })).count();
                assert_eq!(blocks, (at - 8) / 8);
            }
        }
    }
}
