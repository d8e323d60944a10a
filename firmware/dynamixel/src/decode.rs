//! From bytes to packets: an incremental decoder that finds its way back after damage.

use core::fmt;

use crate::crc;
use crate::packet::{CRC_LENGTH, HEADER, Id, Instruction, PREFIX_LENGTH, Packet};

/// A packet that began and was not whole.
///
/// After each of these the decoder searches the bytes it holds for the next header, so that a good packet behind a broken one is not lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum DecodeError {
    /// The CRC does not match the bytes.
    Crc {
        /// The address field as received.
        id: u8,
        /// The instruction code as received.
        code: u8,
        /// CRC of the bytes received.
        computed: u16,
        /// CRC at the end of the packet.
        received: u16,
    },
    /// The address field holds 253 or 255.
    Id {
        /// The address field.
        id: u8,
    },
    /// The length field is below 3 (instruction and CRC) or the packet longer than the decoder's buffer.
    Length {
        /// The address field.
        id: u8,
        /// The length field: instruction, stuffed parameters and CRC.
        length: u16,
        /// The greatest length field this decoder takes.
        longest: u16,
    },
    /// A new header came before the packet's end: bytes were lost.
    Interrupted {
        /// The address field.
        id: u8,
        /// The length field.
        length: u16,
        /// Bytes of the packet before the new header, its own header included.
        received: usize,
    },
}

impl fmt::Display for DecodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            DecodeError::Crc { id, code, computed, received } => {
                write!(f, "CRC {received:#06x} received, {computed:#06x} computed (id {id}, instruction {code:#04x})")
            }
            DecodeError::Id { id } => write!(f, "id {id}, allowed are 0 to 252 and 254"),
            DecodeError::Length { id, length, longest } => {
                write!(f, "length {length}, allowed are 3 to {longest} (id {id})")
            }
            DecodeError::Interrupted { id, length, received } => {
                write!(f, "a new header after {received} of {} bytes (id {id})", PREFIX_LENGTH + usize::from(*length))
            }
        }
    }
}

impl core::error::Error for DecodeError {}

/// Turns a stream of bytes into packets. `N` is the longest packet in bytes, stuffing included.
///
/// The answer to a fast read ([`Packet::is_fast_answer`]) is not stuffed, so its data may look like a header. Such an
/// answer is given up for another packet only when that packet is whole.
///
/// ```
/// use dynamixel::Decoder;
/// let mut decoder = Decoder::<64>::new();
/// let mut bytes: &[u8] = &[7, 7, 0xFF, 0xFF, 0xFD, 0x00, 1, 3, 0, 0x01, 0x19, 0x4E];
/// let mut packets = 0;
/// while let Some(event) = decoder.feed(&mut bytes) {
///     assert_eq!(event.unwrap().code, 0x01);
///     packets += 1;
/// }
/// assert_eq!((packets, decoder.skipped()), (1, 2));
/// ```
#[derive(Clone, Debug)]
pub struct Decoder<const N: usize> {
    buffer: [u8; N],
    /// Bytes held, from the beginning of the buffer.
    held: usize,
    /// Bytes of the packet that was handed out last, to be dropped at the next call.
    finished: usize,
    /// The bytes held have been examined, and more are needed.
    examined: bool,
    /// They begin with a whole header.
    begun: bool,
    /// With fewer bytes than these nothing is complete, but for a new header.
    needed: usize,
    /// Bytes of the candidate already searched for a new header.
    searched: usize,
    /// Where in the candidate, the answer to a fast read, something begins like a packet; 0: nowhere.
    inner: usize,
    /// Bytes held that no further byte completes.
    stale: usize,
    skipped: u32,
}

/// What a header ends with.
const HEADER_END: u8 = {
    let [.., end] = HEADER;
    end
};

enum Verdict {
    More,
    Broken(DecodeError),
    Whole { id: Id, total: usize, stuffed: bool },
}

impl<const N: usize> Decoder<N> {
    /// An empty decoder.
    pub const fn new() -> Self {
        const {
            assert!(N >= 16 && N <= 32_768, "a decoder holds 16 to 32768 bytes");
        }
        Decoder {
            buffer: [0; N],
            held: 0,
            finished: 0,
            examined: false,
            begun: false,
            needed: 0,
            searched: 0,
            inner: 0,
            stale: 0,
            skipped: 0,
        }
    }

    /// Takes bytes from the front of `input` until a packet or an error is complete.
    ///
    /// Nothing means that all bytes are taken and no packet is complete. Call it until then: one byte can end more than
    /// one packet, when a damaged length had swallowed the following ones.
    pub fn feed(&mut self, input: &mut &[u8]) -> Option<Result<Packet<'_>, DecodeError>> {
        self.next(input).map(|(event, _)| event)
    }

    /// [`Decoder::feed`], and [`Decoder::skipped`] at that point.
    pub(crate) fn next(&mut self, input: &mut &[u8]) -> Option<(Result<Packet<'_>, DecodeError>, u32)> {
        self.drop_front(self.finished);
        self.finished = 0;
        loop {
            // However often it is called between two bytes, it examines what it holds once.
            let verdict = if self.examined { Verdict::More } else { self.examine() };
            self.examined = matches!(verdict, Verdict::More);
            match verdict {
                Verdict::More if self.stale > 0 => self.skip(1),
                Verdict::More => self.fill(input)?,
                Verdict::Broken(error) => {
                    self.skip(1);
                    return Some((Err(error), self.skipped));
                }
                Verdict::Whole { id, total, stuffed } => {
                    self.finished = total;
                    let end = if stuffed { self.unstuff(total) } else { total - CRC_LENGTH };
                    let body = self.buffer.get(PREFIX_LENGTH..end).unwrap_or_default();
                    let (code, parameters) = body.split_first().map_or((0, body), |(&code, rest)| (code, rest));
                    return Some((Ok(Packet { id, code, parameters }), self.skipped));
                }
            }
        }
    }

    /// Forgets the bytes held.
    pub fn reset(&mut self) {
        self.held = 0;
        self.finished = 0;
        self.examined = false;
        self.begun = false;
        self.needed = 0;
        self.searched = 0;
        self.inner = 0;
        self.stale = 0;
    }

    /// The line has paused: an incomplete packet will not be completed. What came behind its first byte is searched anew
    /// by the next [`Decoder::feed`], which may be one without bytes.
    pub fn pause(&mut self) {
        self.drop_front(self.finished);
        self.finished = 0;
        self.stale = self.held;
    }

    /// Bytes of an incomplete packet held at present; 0 when the last packet ended with the last byte.
    pub fn pending(&self) -> usize {
        self.held - self.finished
    }

    /// Bytes that belonged to no packet since the decoder was made (wraps around).
    pub fn skipped(&self) -> u32 {
        self.skipped
    }

    /// Takes bytes up to one after which there is something to examine; nothing if none is.
    fn fill(&mut self, input: &mut &[u8]) -> Option<()> {
        loop {
            let (&byte, rest) = input.split_first()?;
            *input = rest;
            self.push(byte);
            if !self.examined {
                return Some(());
            }
        }
    }

    fn push(&mut self, byte: u8) {
        // There is room: a candidate is never longer than the buffer, and is judged as soon as it is whole.
        if let Some(place) = self.buffer.get_mut(self.held) {
            *place = byte;
            self.held += 1;
            self.examined = self.held < self.needed && byte != HEADER_END;
        }
    }

    fn drop_front(&mut self, count: usize) {
        let count = count.min(self.held);
        if count == 0 {
            return;
        }
        // By hand: the compiler does not see that `copy_within` cannot panic here. Mostly nothing is left to be moved.
        for from in count..self.held {
            let byte = self.buffer.get(from).copied().unwrap_or_default();
            if let Some(place) = self.buffer.get_mut(from - count) {
                *place = byte;
            }
        }
        self.held -= count;
        self.examined = false;
        self.begun = false;
        self.needed = 0;
        self.searched = 0;
        self.inner = 0;
        self.stale = self.stale.saturating_sub(count);
    }

    fn skip(&mut self, count: usize) {
        self.skipped = self.skipped.wrapping_add(count as u32);
        self.drop_front(count);
    }

    /// Drops what cannot be the beginning of a packet.
    fn align(&mut self) {
        if self.begun {
            return;
        }
        let held = self.buffer.get(..self.held).unwrap_or_default();
        let begins = |at: &usize| {
            let rest = held.get(*at..).unwrap_or_default();
            rest.iter().zip(HEADER).all(|(&byte, header)| byte == header)
        };
        let start = (0..self.held).find(begins).unwrap_or(self.held);
        if start > 0 {
            self.skip(start);
        }
        self.begun = self.held >= HEADER.len();
        self.needed = if self.begun { PREFIX_LENGTH } else { 0 };
    }

    fn examine(&mut self) -> Verdict {
        self.align();
        let held = self.buffer.get(..self.held).unwrap_or_default();
        let &[_, _, _, _, id, length_low, length_high, ref body @ ..] = held else {
            return Verdict::More;
        };
        let length = u16::from_le_bytes([length_low, length_high]);
        let total = PREFIX_LENGTH + usize::from(length);
        let Some(address) = Id::from_field(id) else {
            return Verdict::Broken(DecodeError::Id { id });
        };
        if length < 3 || total > N {
            let longest = (N - PREFIX_LENGTH) as u16;
            return Verdict::Broken(DecodeError::Length { id, length, longest });
        }
        // Stuffing keeps the header out of a packet's body; only the CRC, which is not stuffed, can complete one.
        let unstuffed = body.get(..usize::from(length) - 1).unwrap_or(body);
        let from = self.searched.saturating_sub(HEADER.len() - 1);
        let mut headers = unstuffed.get(from..).unwrap_or_default().windows(HEADER.len());
        let stuffed = !(address.is_broadcast() && body.first() == Some(&Instruction::Status.code()));
        let interrupted = if stuffed {
            headers.position(|four| four == HEADER).map(|at| PREFIX_LENGTH + from + at)
        } else {
            let last = headers.rposition(|four| four == HEADER);
            self.inner = last.map_or(self.inner, |at| PREFIX_LENGTH + from + at);
            Some(self.inner).filter(|&at| at > 0 && is_whole(held.get(at..).unwrap_or_default()))
        };
        if let Some(received) = interrupted {
            return Verdict::Broken(DecodeError::Interrupted { id, length, received });
        }
        self.searched = unstuffed.len();
        self.needed = if stuffed && !body.is_empty() { total } else { 0 };
        let Some(([covered @ .., crc_low, crc_high], _)) = held.split_at_checked(total) else {
            return Verdict::More;
        };
        let received = u16::from_le_bytes([*crc_low, *crc_high]);
        let computed = crc::update(0, covered);
        if received != computed {
            let code = body.first().copied().unwrap_or(0);
            return Verdict::Broken(DecodeError::Crc { id, code, computed, received });
        }
        Verdict::Whole { id: address, total, stuffed }
    }

    /// Removes the stuffing of the packet of `total` bytes in place; returns where instruction and parameters end now.
    fn unstuff(&mut self, total: usize) -> usize {
        let mut tail = 0u32;
        let mut write = PREFIX_LENGTH;
        for read in PREFIX_LENGTH..total.saturating_sub(2) {
            let Some(&byte) = self.buffer.get(read) else {
                break;
            };
            tail = tail << 8 | u32::from(byte);
            if tail == 0xFFFF_FDFD {
                continue;
            }
            if let Some(place) = self.buffer.get_mut(write) {
                *place = byte;
                write += 1;
            }
        }
        write
    }
}

/// Whether the bytes begin with a packet whose CRC is right.
fn is_whole(bytes: &[u8]) -> bool {
    let &[_, _, _, _, _, low, high, ..] = bytes else {
        return false;
    };
    let total = PREFIX_LENGTH + usize::from(u16::from_le_bytes([low, high]));
    let Some(([covered @ .., crc_low, crc_high], _)) = bytes.split_at_checked(total) else {
        return false;
    };
    covered.len() > PREFIX_LENGTH && crc::update(0, covered) == u16::from_le_bytes([*crc_low, *crc_high])
}

impl<const N: usize> Default for Decoder<N> {
    fn default() -> Self {
        Decoder::new()
    }
}
