//! What a program says when it ends, for the one that starts after it: kept in RAM that a reset leaves alone.
//!
//! All bit patterns are valid, so that a board may look at memory of which nobody knows what is in it; a check distinguishes
//! words from noise.

use core::fmt::{self, Display, Write};

use messages::{TEXT, Text};

/// Marks a record.
const MARK: u32 = 0x5745_4e54;

/// The record. A board puts it where a reset leaves memory alone (cortex-m-rt: `.uninit`).
#[repr(C)]
#[derive(Clone, Debug)]
pub struct LastWords {
    mark: u32,
    check: u32,
    length: u32,
    words: [u8; TEXT],
}

impl LastWords {
    /// No words.
    pub const EMPTY: Self = Self { mark: 0, check: 0, length: 0, words: [0; TEXT] };

    /// Keeps the words, cut to what fits. Never fails: it is called when something else has.
    pub fn keep(&mut self, words: &impl Display) {
        *self = Self::EMPTY;
        // Cut is better than nothing.
        let _ = write!(self, "{words}");
        if self.length == 0 {
            return;
        }
        self.mark = MARK;
        self.check = self.sum();
    }

    /// Takes the words out, if there are any.
    pub fn take(&mut self) -> Option<Text> {
        let whole = self.mark == MARK && self.check == self.sum();
        let words = self.words.get(..self.length as usize).filter(|_| whole);
        let words = words.and_then(|words| core::str::from_utf8(words).ok()).map(|words| Text::try_from(words).ok());
        *self = Self::EMPTY;
        words.flatten()
    }

    /// FNV-1a over length and words.
    fn sum(&self) -> u32 {
        let length = self.length.to_le_bytes();
        length
            .iter()
            .chain(&self.words)
            .fold(0x811c_9dc5, |sum, byte| (sum ^ u32::from(*byte)).wrapping_mul(0x0100_0193))
    }
}

impl Write for LastWords {
    fn write_str(&mut self, words: &str) -> fmt::Result {
        for letter in words.chars() {
            let mut bytes = [0; 4];
            let bytes = letter.encode_utf8(&mut bytes).as_bytes();
            let start = self.length as usize;
            let room = self.words.get_mut(start..start + bytes.len()).ok_or(fmt::Error)?;
            room.copy_from_slice(bytes);
            self.length += bytes.len() as u32;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_come_back_once() {
        let mut record = LastWords::EMPTY;
        assert_eq!(record.take(), None);
        record.keep(&format_args!("panicked at {}:{}", "grip.rs", 17));
        assert_eq!(record.clone().take().as_deref(), Some("panicked at grip.rs:17"));
        assert!(record.take().is_some());
        assert_eq!(record.take(), None);
    }

    #[test]
    fn long_words_are_cut_between_letters() {
        let mut record = LastWords::EMPTY;
        record.keep(&"ä".repeat(TEXT));
        assert_eq!(record.take().unwrap().as_str(), "ä".repeat(TEXT / 2));
    }

    #[test]
    fn noise_and_damage_are_no_words() {
        let mut record = LastWords { mark: u32::MAX, check: u32::MAX, length: u32::MAX, words: [0xFF; TEXT] };
        assert_eq!(record.take(), None);
        let mut noise = LastWords { mark: MARK, length: u32::MAX, ..record.clone() };
        noise.check = noise.sum();
        assert_eq!(noise.take(), None);
        record.keep(&"words");
        for at in 0..TEXT {
            for bit in 0..8 {
                let mut damaged = record.clone();
                damaged.words[at] ^= 1 << bit;
                assert_eq!(damaged.take(), None);
            }
        }
    }
}
