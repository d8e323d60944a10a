//! From fields to bytes: header, stuffing, length, CRC.

use core::fmt;

use crate::crc;
use crate::packet::{ALERT, HEADER, Id, Instruction, PREFIX_LENGTH, StatusError};

/// A packet that does not fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum EncodeError {
    /// The packet needs more bytes than the buffer has.
    BufferTooSmall {
        /// Bytes of the packet, stuffing included.
        needed: usize,
        /// Bytes of the buffer.
        capacity: usize,
    },
    /// Stuffed instruction, parameters and CRC exceed what the length field can say (65535).
    TooLong {
        /// Value the length field would need.
        length: usize,
    },
}

impl fmt::Display for EncodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            EncodeError::BufferTooSmall { needed, capacity } => {
                write!(f, "the packet takes {needed} bytes, the buffer has {capacity}")
            }
            EncodeError::TooLong { length } => write!(f, "packet length {length}, at most 65535"),
        }
    }
}

impl core::error::Error for EncodeError {}

/// Writes one packet into a buffer, parameter by parameter, stuffing as it goes.
///
/// The answer to a fast read ([`crate::Packet::is_fast_answer`]) is not stuffed.
///
/// ```
/// use dynamixel::{Encoder, Id, Instruction};
/// let mut buffer = [0; 32];
/// let packet = Encoder::new(&mut buffer, Id::new(1).unwrap(), Instruction::Read)
///     .bytes(&132u16.to_le_bytes())
///     .bytes(&4u16.to_le_bytes())
///     .finish()
///     .unwrap();
/// assert_eq!(packet, [0xFF, 0xFF, 0xFD, 0x00, 1, 7, 0, 0x02, 0x84, 0, 4, 0, 0x1D, 0x15]);
/// ```
#[derive(Debug)]
pub struct Encoder<'a> {
    buffer: &'a mut [u8],
    /// Bytes of the packet so far, counted on even where the buffer has ended.
    at: usize,
    /// The last three bytes of instruction and parameters, before stuffing.
    tail: u32,
    stuffed: bool,
}

impl<'a> Encoder<'a> {
    /// Begins a packet.
    pub fn new(buffer: &'a mut [u8], id: Id, instruction: Instruction) -> Self {
        Encoder::with_code(buffer, id, instruction.code())
    }

    /// Begins a packet with an instruction code that Protocol 2.0 need not define.
    pub fn with_code(buffer: &'a mut [u8], id: Id, code: u8) -> Self {
        let stuffed = !(id.is_broadcast() && code == Instruction::Status.code());
        let mut encoder = Encoder { buffer, at: 0, tail: 0, stuffed };
        for byte in HEADER {
            encoder.put(byte);
        }
        encoder.put(id.get());
        encoder.put(0);
        encoder.put(0);
        encoder.byte(code)
    }

    /// Begins a device's answer: instruction Status and the error byte.
    pub fn status(buffer: &'a mut [u8], id: Id, alert: bool, error: Option<StatusError>) -> Self {
        let number = error.map_or(0, StatusError::code);
        let alert = if alert { ALERT } else { 0 };
        Encoder::new(buffer, id, Instruction::Status).byte(number | alert)
    }

    /// Appends one parameter byte.
    pub fn byte(mut self, byte: u8) -> Self {
        self.put(byte);
        self.tail = (self.tail << 8 | u32::from(byte)) & 0x00FF_FFFF;
        if self.tail == 0x00FF_FFFD && self.stuffed {
            self.put(0xFD);
        }
        self
    }

    /// Appends parameter bytes.
    pub fn bytes(self, bytes: &[u8]) -> Self {
        bytes.iter().fold(self, |encoder, &byte| encoder.byte(byte))
    }

    /// Fills in length and CRC; returns the packet's bytes at the beginning of the buffer.
    pub fn finish(mut self) -> Result<&'a [u8], EncodeError> {
        let length = self.at - PREFIX_LENGTH + 2;
        let needed = self.at + 2;
        let capacity = self.buffer.len();
        let field = u16::try_from(length).map_err(|_| EncodeError::TooLong { length })?;
        let too_small = EncodeError::BufferTooSmall { needed, capacity };
        self.buffer.get_mut(5..PREFIX_LENGTH).ok_or(too_small)?.copy_from_slice(&field.to_le_bytes());
        let crc = crc::update(0, self.buffer.get(..self.at).ok_or(too_small)?);
        for byte in crc.to_le_bytes() {
            self.put(byte);
        }
        let packet: &'a [u8] = self.buffer;
        packet.get(..needed).ok_or(too_small)
    }

    fn put(&mut self, byte: u8) {
        if let Some(place) = self.buffer.get_mut(self.at) {
            *place = byte;
        }
        self.at += 1;
    }
}

/// Writes a whole packet into `buffer` and returns its bytes.
pub fn encode<'a>(
    buffer: &'a mut [u8],
    id: Id,
    instruction: Instruction,
    parameters: &[u8],
) -> Result<&'a [u8], EncodeError> {
    Encoder::new(buffer, id, instruction).bytes(parameters).finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one() -> Id {
        Id::new(1).unwrap()
    }

    #[test]
    fn stuffing_follows_the_pattern_wherever_it_is() {
        let cases: [(&[u8], &[u8]); 6] = [
            (&[0xFF, 0xFF, 0xFD], &[0xFF, 0xFF, 0xFD, 0xFD]),
            (&[0xFF, 0xFF, 0xFD, 0xFD], &[0xFF, 0xFF, 0xFD, 0xFD, 0xFD]),
            (&[0xFF, 0xFF, 0xFF, 0xFD, 1], &[0xFF, 0xFF, 0xFF, 0xFD, 0xFD, 1]),
            (&[0xFF, 0xFD, 0xFF, 0xFD], &[0xFF, 0xFD, 0xFF, 0xFD]),
            (&[0xFF, 0xFF], &[0xFF, 0xFF]),
            (&[0xFF, 0xFF, 0xFD, 0xFF, 0xFF, 0xFD, 0], &[0xFF, 0xFF, 0xFD, 0xFD, 0xFF, 0xFF, 0xFD, 0xFD, 0]),
        ];
        for (plain, stuffed) in cases {
            let mut buffer = [0; 32];
            let packet = encode(&mut buffer, one(), Instruction::Write, plain).unwrap();
            assert_eq!(&packet[8..packet.len() - 2], stuffed);
            assert_eq!(usize::from(packet[5]), stuffed.len() + 3);
        }
    }

    #[test]
    fn the_instruction_belongs_to_the_pattern() {
        let mut buffer = [0; 32];
        let packet = Encoder::with_code(&mut buffer, one(), 0xFF).bytes(&[0xFF, 0xFD]).finish().unwrap();
        assert_eq!(packet[7..packet.len() - 2], [0xFF, 0xFF, 0xFD, 0xFD]);
    }

    #[test]
    fn a_short_buffer_says_how_much_is_needed() {
        for capacity in 0..13 {
            let mut buffer = [0; 13];
            let result = encode(&mut buffer[..capacity], one(), Instruction::Write, &[1, 2, 3]);
            assert_eq!(result, Err(EncodeError::BufferTooSmall { needed: 13, capacity }));
        }
        assert!(encode(&mut [0; 13], one(), Instruction::Write, &[1, 2, 3]).is_ok());
    }
}
