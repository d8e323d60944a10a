//! Frames of MAVLink 1: start, length, sequence, system, component, kind, payload, CRC.

use super::Kind;

/// The first byte of a frame.
const START: u8 = 0xFE;
/// Bytes before the payload.
const HEADER: usize = 6;
/// Bytes around a payload.
const AROUND: usize = HEADER + 2;
/// The longest payload.
const LONGEST: usize = 255;

/// A message: its kind and its payload.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frame {
    /// What it is.
    pub kind: Kind,
    /// As long as its kind has it.
    pub payload: Vec<u8>,
}

impl Frame {
    /// The bytes of the frame with this number.
    pub fn bytes(&self, sequence: u8) -> Vec<u8> {
        // `Kind::bytes` is below 256.
        let mut bytes = vec![START, self.payload.len() as u8, sequence, 0, 0, self.kind.number()];
        bytes.extend(&self.payload);
        let sum = self.kind.sum(&bytes[1..]);
        bytes.extend(sum.to_le_bytes());
        bytes
    }
}

/// The checksum of MAVLink (CRC-16/MCRF4XX) over these bytes, after `before`; it begins with 0xFFFF.
pub fn crc(before: u16, bytes: &[u8]) -> u16 {
    bytes.iter().fold(before, |crc, byte| {
        (0..8).fold(crc ^ u16::from(*byte), |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0x8408 } else { crc >> 1 })
    })
}

/// Takes frames out of bytes as they come. What is not a whole frame of a known kind is skipped.
#[derive(Debug, Default)]
pub struct Decoder {
    bytes: Vec<u8>,
}

impl Decoder {
    /// Adds bytes.
    pub fn feed(&mut self, bytes: &[u8]) {
        self.bytes.extend(bytes);
    }

    /// The next frame, if all of it is there.
    pub fn frame(&mut self) -> Option<Frame> {
        loop {
            let start = self.bytes.iter().position(|byte| *byte == START).unwrap_or(self.bytes.len());
            self.bytes.drain(..start);
            let length = usize::from(*self.bytes.get(1)?);
            let number = self.bytes.get(HEADER - 1).copied()?;
            let Some(kind) = Kind::of(number).filter(|kind| kind.bytes() == length) else {
                self.bytes.drain(..1);
                continue;
            };
            let end = HEADER + length;
            let sum = self.bytes.get(end..end + 2)?;
            if sum != kind.sum(&self.bytes[1..end]).to_le_bytes() {
                self.bytes.drain(..1);
                continue;
            }
            let payload = self.bytes[HEADER..end].to_vec();
            self.bytes.drain(..end + 2);
            return Some(Frame { kind, payload });
        }
    }
}

/// As many zeros as end whatever a loader believes to have begun.
pub(super) const FLUSH: [u8; AROUND + LONGEST] = [0; AROUND + LONGEST];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checksum_is_the_published_one() {
        // The check value of CRC-16/MCRF4XX in the catalogue of CRC algorithms.
        assert_eq!(crc(0xFFFF, b"123456789"), 0x6F91);
    }

    #[test]
    fn frames_are_found_among_noise_and_in_pieces() {
        let frame = |kind: Kind, fill: u8| Frame { kind, payload: vec![fill; kind.bytes()] };
        let (one, two) = (frame(Kind::Acknowledgement, 7), frame(Kind::Erase, START));
        let mut damaged = one.bytes(3);
        damaged[9] ^= 1;
        let stream = [&[1, START, 200, 5][..], &damaged, &one.bytes(4), &[START], &two.bytes(5)].concat();
        for piece in [1, 2, 7, 64, 400] {
            let (mut decoder, mut found) = (Decoder::default(), Vec::new());
            for bytes in stream.chunks(piece) {
                decoder.feed(bytes);
                found.extend(std::iter::from_fn(|| decoder.frame()));
            }
            assert_eq!(found, [one.clone(), two.clone()], "in pieces of {piece}");
        }
    }
}
