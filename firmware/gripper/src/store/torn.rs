//! Power lost while flash is programmed or erased, word by word, on each kind of flash that boards have.
//!
//! - Without error correction (STM32F4, F7: words of 4 bytes) the word that was being programmed holds some of its bits.
//! - With it (STM32G4: 8 bytes, H7: 32 bytes) such a word cannot be read, and no word can be programmed twice.
//! - A sector whose erasing was cut short is erased up to some word, which is torn, and as it was behind it.

use std::vec::Vec;

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};

use model_core::size::Lists;

use super::Found;
use super::tests::{keep, longest, restore, with};
use crate::setup::{Key, Setup};

const SECTOR: usize = 2048;

#[derive(Clone, Copy, PartialEq)]
enum Word {
    Erased,
    Programmed,
    /// Power was lost over it.
    Torn,
}

/// Flash that loses power after so many words programmed or erased.
#[derive(Clone)]
struct Flash<const WORD: usize, const CORRECTS: bool> {
    bytes: Vec<u8>,
    words: Vec<Word>,
    left: usize,
    is_dead: bool,
    done: usize,
    erasures: usize,
    /// Words that were to be programmed though they were not erased.
    twice: usize,
}

impl<const WORD: usize, const CORRECTS: bool> Flash<WORD, CORRECTS> {
    fn new() -> Self {
        let words = std::vec![Word::Erased; 4 * SECTOR / WORD];
        Self {
            bytes: std::vec![0xFF; 4 * SECTOR],
            words,
            left: usize::MAX,
            is_dead: false,
            done: 0,
            erasures: 0,
            twice: 0,
        }
    }

    /// Whether there is power for one more word. Where there is none, this is the last one that anything happens to.
    fn has_power(&mut self) -> bool {
        let has = self.left > 0;
        self.left = self.left.saturating_sub(1);
        self.done += usize::from(has);
        self.is_dead = !has;
        has
    }

    fn start(&mut self) {
        (self.left, self.is_dead) = (usize::MAX, false);
    }

    fn set(&mut self, word: usize, state: Word, bytes: impl Fn(usize, u8) -> u8) {
        self.words[word] = state;
        for at in word * WORD..(word + 1) * WORD {
            self.bytes[at] = bytes(at, self.bytes[at]);
        }
    }
}

/// Any number, always the same for the same word.
fn chance(word: usize) -> usize {
    (word as u32).wrapping_mul(2_654_435_761) as usize >> 13
}

impl<const WORD: usize, const CORRECTS: bool> ErrorType for &mut Flash<WORD, CORRECTS> {
    type Error = NorFlashErrorKind;
}

impl<const WORD: usize, const CORRECTS: bool> ReadNorFlash for &mut Flash<WORD, CORRECTS> {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        check_read(self, offset, bytes.len())?;
        let place = offset as usize..offset as usize + bytes.len();
        if CORRECTS && place.clone().any(|at| self.words[at / WORD] == Word::Torn) {
            bytes.fill(0xA5);
            return Err(NorFlashErrorKind::Other);
        }
        bytes.copy_from_slice(&self.bytes[place]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl<const WORD: usize, const CORRECTS: bool> NorFlash for &mut Flash<WORD, CORRECTS> {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        check_erase(self, from, to)?;
        if self.is_dead {
            return Err(NorFlashErrorKind::Other);
        }
        self.erasures += 1;
        for word in from as usize / WORD..to as usize / WORD {
            if !self.has_power() {
                self.set(word, Word::Torn, |at, old| old | chance(at) as u8);
                return Err(NorFlashErrorKind::Other);
            }
            self.set(word, Word::Erased, |_, _| 0xFF);
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        check_write(self, offset, bytes.len())?;
        if self.is_dead {
            return Err(NorFlashErrorKind::Other);
        }
        let start = offset as usize;
        for word in start / WORD..(start + bytes.len()) / WORD {
            if CORRECTS && self.words[word] != Word::Erased {
                self.twice += 1;
                return Err(NorFlashErrorKind::Other);
            }
            if !self.has_power() {
                self.set(word, Word::Torn, |at, old| old & (bytes[at - start] | chance(at + start) as u8));
                return Err(NorFlashErrorKind::Other);
            }
            self.set(word, Word::Programmed, |at, old| old & bytes[at - start]);
        }
        Ok(())
    }
}

/// Power lost over every single word of a write: afterwards there is the old record or the new one, the other records are as they were,
/// the next one can be kept, and power may be lost over that as well. Of every flash's turn, the writes around the one that erases.
fn cut_everywhere<const WORD: usize, const CORRECTS: bool>(key: Key, make: fn(u32) -> Setup) {
    let part = |setup: &Setup| match key {
        Key::Settings => std::format!("{:?}", setup.settings),
        Key::Finger(finger) => std::format!("{:?}", setup.fingers[usize::from(finger)]),
        Key::Object(finger) => std::format!("{:?}", setup.objects[usize::from(finger)]),
        Key::Uncertainty(finger) => std::format!("{:?}", setup.uncertainties[usize::from(finger)]),
    };
    let mut flash = Flash::<WORD, CORRECTS>::new();
    let mut old = make(0);
    keep(&mut flash, key, &old).unwrap();
    keep(&mut flash, Key::Object(1), &old).unwrap();
    let written = |flash: &Flash<WORD, CORRECTS>, setup: &Setup| {
        let mut whole = flash.clone();
        keep(&mut whole, key, setup).unwrap();
        (whole.done - flash.done, whole.erasures > flash.erasures, whole)
    };
    let whole = Found { records: 2, damaged: 0 };
    let (mut cuts, mut erasures, mut round) = (0, 0, 1);
    while erasures < 3 {
        assert!(round < 1_000, "nothing is ever erased");
        let (next, new) = (make(round + 1), make(round));
        let (steps, erases, after) = written(&flash, &new);
        if erases || round == 1 || written(&after, &next).1 {
            erasures += usize::from(erases);
            for cut in 0..steps {
                let mut broken = flash.clone();
                broken.left = cut;
                let kept = keep(&mut broken, key, &new);
                broken.start();
                let place = std::format!("words of {WORD}, cut after {cut} of {steps} in round {round}");
                let (back, found) = restore(&mut broken);
                assert_eq!(found, whole, "{place}");
                let is_old = part(&back) == part(&old);
                assert!(is_old || part(&back) == part(&new), "{place}");
                assert!(!(is_old && kept.is_ok()), "kept, it said, {place}");
                assert_eq!(back.objects[1], old.objects[1], "{place}");
                // Lost again while the next one is kept, somewhere.
                let mut again = broken.clone();
                again.left = chance(cut + 7) % (steps + 8);
                let _ = keep(&mut again, key, &next);
                again.start();
                let (back, found) = restore(&mut again);
                assert_eq!(found, whole, "{place}, and again");
                assert!([&old, &new, &next].iter().any(|one| part(one) == part(&back)), "{place}, and again");
                keep(&mut broken, key, &next).unwrap();
                assert_eq!(part(&restore(&mut broken).0), part(&next), "{place}");
                assert_eq!((broken.twice, again.twice), (0, 0), "a word was to be programmed twice, {place}");
                cuts += 1;
            }
        }
        (flash, old) = (after, new);
        round += 1;
    }
    assert!(cuts > 3 * SECTOR / WORD, "{cuts} cuts");
}

#[test]
fn a_word_torn_anywhere_leaves_the_old() {
    let make = |round| with(round as f32, 0);
    cut_everywhere::<4, false>(Key::Settings, make);
    cut_everywhere::<8, true>(Key::Settings, make);
    cut_everywhere::<32, true>(Key::Settings, make);
    // The objects stay as they are.
    cut_everywhere::<8, true>(Key::Uncertainty(2), |round| Setup { objects: with(0.0, 0).objects, ..with(0.0, round) });
}

#[test]
fn a_word_torn_in_a_long_record_leaves_the_old() {
    let make = |round: u32| {
        let mut setup = with(0.0, 0);
        let mut finger = longest(Lists::TARGET);
        finger.design.material.youngs_modulus += f64::from(round);
        setup.fingers[2] = Some(finger);
        setup
    };
    cut_everywhere::<4, false>(Key::Finger(2), make);
    cut_everywhere::<8, true>(Key::Finger(2), make);
    cut_everywhere::<32, true>(Key::Finger(2), make);
}
