//! The messages of OpenCR's boot loader: numbers, lengths, fields.

use super::frame::{Frame, crc};

/// What a message is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The loader's answer to each of the others.
    Acknowledgement,
    /// Asks for the loader's version.
    Version,
    /// Asks for the board's name.
    Name,
    /// Begins to write: the loader forgets what it holds.
    Begin,
    /// Ends it: the answer has how many pieces and bytes came.
    End,
    /// Bytes for the next block. The loader answers only if it is asked to.
    Piece,
    /// Writes the pieces that came to flash.
    Block,
    /// Erases as many sectors of the program's flash as so many bytes take.
    Erase,
    /// Compares the flash with a checksum.
    Verify,
    /// Starts the program.
    Start,
}

/// Every kind: number, bytes of its payload, and the byte that MAVLink makes of its definition, which goes into the checksum.
const KINDS: [(Kind, u8, u8, u8); 10] = [
    (Kind::Acknowledgement, 150, 20, 192),
    (Kind::Version, 151, 9, 166),
    (Kind::Name, 152, 9, 140),
    (Kind::Begin, 154, 9, 8),
    (Kind::End, 155, 9, 48),
    (Kind::Piece, 156, 132, 233),
    (Kind::Block, 157, 7, 226),
    (Kind::Erase, 158, 13, 13),
    (Kind::Verify, 159, 17, 31),
    (Kind::Start, 162, 9, 37),
];

impl Kind {
    /// The kind of this number.
    pub fn of(number: u8) -> Option<Self> {
        KINDS.iter().find(|(_, of, ..)| *of == number).map(|(kind, ..)| *kind)
    }

    fn row(self) -> (Self, u8, u8, u8) {
        // Every kind has its row, as a test shows.
        KINDS.iter().copied().find(|(kind, ..)| *kind == self).unwrap_or(KINDS[0])
    }

    /// Its number.
    pub fn number(self) -> u8 {
        self.row().1
    }

    /// Bytes of its payload.
    pub fn bytes(self) -> usize {
        usize::from(self.row().2)
    }

    /// The checksum of a frame of this kind, from its length to its payload's end.
    pub(super) fn sum(self, bytes: &[u8]) -> u16 {
        crc(crc(0xFFFF, bytes), &[self.row().3])
    }

    /// The frame with these bytes first and zeros behind them.
    pub fn frame(self, fields: &[&[u8]]) -> Frame {
        let mut payload = fields.concat();
        payload.resize(self.bytes(), 0);
        Frame { kind: self, payload }
    }
}

/// What the loader answers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Acknowledgement {
    /// Number of what is answered.
    pub of: u8,
    /// 0: it is done.
    pub error: u16,
    /// What was asked for.
    pub data: Vec<u8>,
}

impl Acknowledgement {
    /// Reads a frame, if it is one.
    pub fn read(frame: &Frame) -> Option<Self> {
        if frame.kind != Kind::Acknowledgement {
            return None;
        }
        let (head, data) = frame.payload.split_at_checked(4)?;
        let data = data.get(..usize::from(head[3]))?;
        Some(Self { of: head[2], error: u16::from_le_bytes([head[0], head[1]]), data: data.to_vec() })
    }

    /// The frame of an answer.
    pub fn frame(&self) -> Frame {
        let head = [&self.error.to_le_bytes()[..], &[self.of, self.data.len() as u8]].concat();
        Kind::Acknowledgement.frame(&[&head, &self.data])
    }
}

/// The loader's own checksum of flash.
pub fn checksum(bytes: &[u8]) -> u32 {
    bytes.iter().fold(0_u32, |sum, byte| (sum ^ u32::from(*byte)).wrapping_add(u32::from(*byte)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A message as MAVLink's rules see it: its name, and its fields with type and number of entries (0: no array), larger types first.
    type Definition = (Kind, &'static str, &'static [(&'static str, &'static str, u8)]);

    const PARAM: (&str, &str, u8) = ("uint8_t", "param", 8);
    const RESP: (&str, &str, u8) = ("uint8_t", "resp", 0);
    const DEFINITIONS: [Definition; 10] = [
        (
            Kind::Acknowledgement,
            "ACK",
            &[("uint16_t", "err_code", 0), ("uint8_t", "msg_id", 0), ("uint8_t", "length", 0), ("uint8_t", "data", 16)],
        ),
        (Kind::Version, "READ_VERSION", &[RESP, PARAM]),
        (Kind::Name, "READ_BOARD_NAME", &[RESP, PARAM]),
        (Kind::Begin, "FLASH_FW_WRITE_BEGIN", &[RESP, PARAM]),
        (Kind::End, "FLASH_FW_WRITE_END", &[RESP, PARAM]),
        (
            Kind::Piece,
            "FLASH_FW_WRITE_PACKET",
            &[("uint16_t", "addr", 0), RESP, ("uint8_t", "length", 0), ("uint8_t", "data", 128)],
        ),
        (Kind::Block, "FLASH_FW_WRITE_BLOCK", &[("uint32_t", "addr", 0), ("uint16_t", "length", 0), RESP]),
        (Kind::Erase, "FLASH_FW_ERASE", &[("uint32_t", "length", 0), RESP, PARAM]),
        (Kind::Verify, "FLASH_FW_VERIFY", &[("uint32_t", "length", 0), ("uint32_t", "crc", 0), RESP, PARAM]),
        (Kind::Start, "JUMP_TO_FW", &[RESP, PARAM]),
    ];

    /// Lengths and the bytes in the checksum follow from the definitions by MAVLink's published rules.
    #[test]
    fn the_table_follows_from_the_definitions() {
        for ((kind, name, fields), (of, _, bytes, extra)) in DEFINITIONS.iter().zip(KINDS) {
            assert_eq!(*kind, of);
            let (mut sum, mut length) = (crc(0xFFFF, format!("{name} ").as_bytes()), 0);
            for (form, field, entries) in *fields {
                sum = crc(sum, format!("{form} {field} ").as_bytes());
                if *entries > 0 {
                    sum = crc(sum, &[*entries]);
                }
                let size = match *form {
                    "uint32_t" => 4,
                    "uint16_t" => 2,
                    _ => 1,
                };
                length += size * (*entries).max(1);
            }
            assert_eq!((length, sum.to_le_bytes()[0] ^ sum.to_le_bytes()[1]), (bytes, extra), "{name}");
            assert_eq!(Kind::of(kind.number()), Some(*kind));
        }
    }

    #[test]
    fn an_answer_is_read_as_it_was_written() {
        let answer = Acknowledgement { of: Kind::Name.number(), error: 0x19, data: b"OpenCR R1.0".to_vec() };
        assert_eq!(Acknowledgement::read(&answer.frame()), Some(answer.clone()));
        let mut long = answer.frame();
        long.payload[3] = 17;
        assert_eq!(Acknowledgement::read(&long), None);
        assert_eq!(Acknowledgement::read(&Kind::Name.frame(&[])), None);
    }

    #[test]
    fn the_checksum_depends_on_order() {
        // By hand: 1 → 0^1+1 = 2; 2 → 2^2+2 = 2; 0xff → 2^0xff+0xff = 0xfd + 0xff.
        assert_eq!(checksum(&[1, 2, 0xff]), 0x1fc);
        assert_ne!(checksum(&[2, 1, 0xff]), 0x1fc);
    }
}
