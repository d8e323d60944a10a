//! What can go wrong between a servo and its master, on purpose.

use std::collections::VecDeque;

/// What becomes of one answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fault {
    /// It is not sent.
    Drop,
    /// The bits of `mask` are flipped in the byte at `index` (of the last byte if the answer is shorter).
    Corrupt {
        /// Which byte, from 0.
        index: usize,
        /// Which bits.
        mask: u8,
    },
    /// Only its first bytes are sent.
    Truncate {
        /// How many.
        bytes: usize,
    },
    /// It comes later, µs.
    Delay {
        /// How much.
        us: u32,
    },
    /// These bytes are sent before it.
    Noise(Vec<u8>),
    /// It is sent as it is: for faults that begin later.
    None,
}

/// Faults of the answers to come.
#[derive(Clone, Debug, Default)]
pub(super) struct Faults {
    pub(super) queue: VecDeque<Fault>,
    /// Until when nothing is heard or said, µs; `u64::MAX`: until it is set otherwise.
    pub(super) silent_until_us: u64,
    /// Answers that a fault has changed or suppressed.
    pub(super) done: u64,
}

impl Faults {
    /// Applies the next fault to an answer and its delay; none if it is not sent.
    pub(super) fn apply(&mut self, mut bytes: Vec<u8>, mut delay_us: u32) -> Option<(Vec<u8>, u32)> {
        let Some(fault) = self.queue.pop_front() else {
            return Some((bytes, delay_us));
        };
        self.done += u64::from(fault != Fault::None);
        match fault {
            Fault::Drop => return None,
            Fault::Corrupt { index, mask } => {
                let index = index.min(bytes.len().saturating_sub(1));
                if let Some(byte) = bytes.get_mut(index) {
                    *byte ^= mask;
                }
            }
            Fault::Truncate { bytes: length } => bytes.truncate(length),
            Fault::Delay { us } => delay_us = delay_us.saturating_add(us),
            Fault::Noise(noise) => bytes = [noise, bytes].concat(),
            Fault::None => {}
        }
        Some((bytes, delay_us))
    }
}
