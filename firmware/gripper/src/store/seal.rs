//! One generation: records that belong together come back together, or none of them does.
//!
//! Finger, object and mount of different times give a wrong force that looks sound. So before a record is written, a seal is: the digest of
//! all records as they are, and as they will be then, and the number of the write. What is read at the start has to have one of the two digests, whenever the
//! power was lost.

use messages::FINGERS;

use crate::setup::Key;

/// Records: settings, and a finger, an object and an uncertainty per finger.
const RECORDS: usize = 1 + 3 * FINGERS;

/// Bytes of a seal.
pub(super) const SEAL: usize = 12;

/// A digest of every record that is in flash; 0 for none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Digests([u32; RECORDS]);

impl Digests {
    /// The same with another record.
    pub(super) fn with(mut self, key: Key, record: &[u8]) -> Self {
        let place = match key {
            Key::Settings => 0,
            Key::Finger(finger) => 1 + usize::from(finger),
            Key::Object(finger) => 1 + FINGERS + usize::from(finger),
            Key::Uncertainty(finger) => 1 + 2 * FINGERS + usize::from(finger),
        };
        if let Some(digest) = self.0.get_mut(place) {
            *digest = fnv(record.iter().copied());
        }
        self
    }

    /// Of all of them.
    fn all(&self) -> u32 {
        fnv(self.0.iter().flat_map(|digest| digest.to_le_bytes()))
    }

    /// The seal of a change from these to others, which is the `writes`-th one.
    pub(super) fn seal(&self, next: &Self, writes: u32) -> [u8; SEAL] {
        let mut seal = [0; SEAL];
        let words = [self.all(), next.all(), writes];
        seal.chunks_exact_mut(4).zip(words).for_each(|(place, word)| place.copy_from_slice(&word.to_le_bytes()));
        seal
    }

    /// Whether these are what was sealed, before or after the change.
    pub(super) fn are_sealed_by(&self, seal: &[u8]) -> bool {
        let mut halves = seal.chunks_exact(4).take(2);
        seal.len() == SEAL && halves.any(|half| half == self.all().to_le_bytes())
    }

    /// How many changes there were up to a seal.
    pub(super) fn writes(seal: &[u8]) -> u32 {
        seal.get(8..SEAL).and_then(|count| count.try_into().ok()).map_or(0, u32::from_le_bytes)
    }
}

/// Fowler, Noll and Vo's hash (FNV-1a, 32 bits).
fn fnv(bytes: impl Iterator<Item = u8>) -> u32 {
    bytes.fold(0x811C_9DC5, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seal_holds_before_and_after_and_no_mixture() {
        let old = Digests::default().with(Key::Settings, b"mount").with(Key::Object(1), b"object");
        let new = old.with(Key::Finger(1), b"finger");
        let seal = old.seal(&new, 7);
        assert_eq!(Digests::writes(&seal), 7);
        assert!(old.are_sealed_by(&seal) && new.are_sealed_by(&seal));
        for other in [
            Digests::default(),
            new.with(Key::Settings, b"an older mount"),
            old.with(Key::Finger(2), b"finger"),
            old.with(Key::Uncertainty(1), b"finger"),
        ] {
            assert!(!other.are_sealed_by(&seal), "{other:?}");
        }
        assert!(!old.are_sealed_by(&seal[..11]) && !old.are_sealed_by(&[]));
        assert_eq!(fnv(b"a".iter().copied()), 0xE40C_292C, "as its authors have it");
    }
}
