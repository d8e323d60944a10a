//! Messages over a stream of bytes: `00 | COBS(message | CRC-32, little-endian) | 00`.
//!
//! COBS leaves no zero inside, so a frame ends at the next zero whatever happened before, and the zero in front keeps
//! noise between two frames out of the second. The CRC is CRC-32/ISO-HDLC (Ethernet's).

use core::fmt;

use cobs::{CobsEncoder, decode_in_place};
use crc::{CRC_32_ISO_HDLC, Crc, Table};
use model_core::size::Lists;
use postcard_rpc::header::VarHeader;
use serde::Serialize;

use crate::Finger;

/// Longest message, header included, bytes: a shape's, or a finger's where the lists of its description are long.
pub const MESSAGE: usize = bytes(Lists::HERE);

/// Longest message, header included, bytes, where descriptions have such lists.
pub const fn bytes(lists: Lists) -> usize {
    let finger = Finger::bytes(lists) + HEADER;
    if finger > SHAPE { finger } else { SHAPE }
}

/// A header and the finger's number, at most.
const HEADER: usize = 32;
/// Room for a shape.
const SHAPE: usize = 2048;
/// Longest frame, bytes.
pub const FRAME: usize = cobs::max_encoding_length(MESSAGE + CHECK) + 2;

/// Bytes of the CRC.
const CHECK: usize = 4;
const CRC: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);

/// Why bytes are not a message, or a message is not a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FrameError {
    /// Not COBS, or too short for a CRC.
    Malformed,
    /// The CRC is wrong.
    Damaged,
    /// More bytes than the buffer holds.
    TooLong,
}

impl fmt::Display for FrameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Malformed => "the frame is malformed",
            Self::Damaged => "the frame's CRC is wrong",
            Self::TooLong => "the frame is too long",
        })
    }
}

impl core::error::Error for FrameError {}

/// Puts header and message into a buffer of [`MESSAGE`] bytes; returns the part used.
///
/// # Errors
/// [`FrameError::TooLong`] if it does not fit.
pub fn message<'a, T: Serialize + ?Sized>(
    header: &VarHeader,
    body: &T,
    buffer: &'a mut [u8],
) -> Result<&'a [u8], FrameError> {
    let (head, rest) = header.write_to_slice(buffer).ok_or(FrameError::TooLong)?;
    let (head, body) = (head.len(), postcard::to_slice(body, rest).map_err(|_| FrameError::TooLong)?.len());
    buffer.get(..head + body).ok_or(FrameError::TooLong)
}

/// Frames a message into a buffer of [`FRAME`] bytes; returns the part used.
///
/// # Errors
/// [`FrameError::TooLong`] if it does not fit.
pub fn encode<'a>(message: &[u8], buffer: &'a mut [u8]) -> Result<&'a [u8], FrameError> {
    let (first, rest) = buffer.split_first_mut().ok_or(FrameError::TooLong)?;
    *first = 0;
    let mut encoder = CobsEncoder::new(rest);
    encoder.push(message).map_err(|_| FrameError::TooLong)?;
    encoder.push(&CRC.checksum(message).to_le_bytes()).map_err(|_| FrameError::TooLong)?;
    let used = encoder.finalize();
    *rest.get_mut(used).ok_or(FrameError::TooLong)? = 0;
    buffer.get(..used + 2).ok_or(FrameError::TooLong)
}

/// Finds messages in a stream of bytes. `N` bounds a frame between its zeros.
#[derive(Clone, Debug)]
pub struct Decoder<const N: usize = FRAME> {
    bytes: [u8; N],
    used: usize,
    overflowed: bool,
}

impl<const N: usize> Default for Decoder<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> Decoder<N> {
    /// A decoder that has heard nothing.
    pub const fn new() -> Self {
        Self { bytes: [0; N], used: 0, overflowed: false }
    }

    /// Takes bytes from the front of `input` up to the end of a frame; `None` once the input is used up.
    ///
    /// After an error the next frame is read as if nothing had happened.
    pub fn feed(&mut self, input: &mut &[u8]) -> Option<Result<&mut [u8], FrameError>> {
        while let Some((&byte, rest)) = input.split_first() {
            *input = rest;
            if byte != 0 {
                match self.bytes.get_mut(self.used) {
                    Some(place) => {
                        *place = byte;
                        self.used += 1;
                    }
                    None => self.overflowed = true,
                }
                continue;
            }
            let (used, overflowed) = (self.used, self.overflowed);
            self.used = 0;
            self.overflowed = false;
            if overflowed {
                return Some(Err(FrameError::TooLong));
            }
            if used > 0 {
                return Some(open(self.bytes.get_mut(..used)?));
            }
        }
        None
    }
}

/// The message in what was between two zeros.
fn open(bytes: &mut [u8]) -> Result<&mut [u8], FrameError> {
    let length = decode_in_place(bytes).map_err(|_| FrameError::Malformed)?;
    let whole = bytes.get_mut(..length).ok_or(FrameError::Malformed)?;
    let (message, check) = whole.split_last_chunk_mut::<CHECK>().ok_or(FrameError::Malformed)?;
    if CRC.checksum(message) == u32::from_le_bytes(*check) { Ok(message) } else { Err(FrameError::Damaged) }
}
