//! Why a transaction gave nothing.

use core::fmt;

use crate::decode::DecodeError;
use crate::encode::EncodeError;
use crate::packet::{Id, StatusError};

/// Why a transaction gave nothing. `E` is the port's error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Error<E> {
    /// The port failed.
    Port(E),
    /// The port was closed from the other side, or takes no bytes.
    Closed,
    /// No answer began before the deadline.
    Timeout {
        /// Who was asked.
        id: Id,
        /// Microseconds waited.
        waited_us: u32,
    },
    /// An answer began and was not whole at the deadline.
    Truncated {
        /// Who was asked.
        id: Id,
        /// Bytes of the incomplete packet.
        received: usize,
    },
    /// What came was damaged, and nothing sound came after it.
    Damaged(DecodeError),
    /// A device's part of the answer to a fast read is damaged, or another device's.
    Block {
        /// Whose part it should have been.
        id: Id,
    },
    /// Another device answered, and the one that was asked did not.
    WrongId {
        /// Who was asked.
        expected: Id,
        /// Who answered.
        received: Id,
    },
    /// The answer has another number of bytes than was asked for.
    Length {
        /// Who answered.
        id: Id,
        /// Parameter bytes asked for.
        expected: usize,
        /// Parameter bytes received.
        received: usize,
    },
    /// The device refused.
    Refused {
        /// Who refused.
        id: Id,
        /// Why.
        error: StatusError,
        /// Whether the device has a hardware error as well.
        alert: bool,
    },
    /// More bytes came than any answer explains; something else talks on the bus.
    Babble {
        /// Bytes received.
        bytes: usize,
    },
    /// The instruction or its answer does not fit the master's buffers.
    TooLong(EncodeError),
    /// This instruction cannot be asked of every device at once.
    Broadcast,
    /// A device is named twice in an instruction that may name it once.
    Twice {
        /// Which one.
        id: Id,
    },
}

impl<E: fmt::Debug> fmt::Display for Error<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Port(error) => write!(f, "port: {error:?}"),
            Error::Closed => f.write_str("the port is closed"),
            Error::Timeout { id, waited_us } => {
                write!(f, "no answer from {id} within {waited_us} us")
            }
            Error::Truncated { id, received } => {
                write!(f, "answer of {id} broke off after {received} bytes")
            }
            Error::Damaged(error) => write!(f, "damaged answer: {error}"),
            Error::Block { id } => write!(f, "damaged part of {id} in the answer to a fast read"),
            Error::WrongId { expected, received } => {
                write!(f, "asked {expected}, {received} answered")
            }
            Error::Length { id, expected, received } => {
                write!(f, "{id} answered with {received} parameter bytes instead of {expected}")
            }
            Error::Refused { id, error, .. } => write!(f, "{id} refused: {error}"),
            Error::Babble { bytes } => write!(f, "{bytes} bytes on the bus that are not an answer"),
            Error::TooLong(error) => write!(f, "{error}"),
            Error::Twice { id } => write!(f, "{id} is named twice; each device may be named once"),
            Error::Broadcast => f.write_str("not to be asked of every device at once"),
        }
    }
}

impl<E: fmt::Debug> core::error::Error for Error<E> {}
