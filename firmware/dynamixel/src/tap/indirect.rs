//! Indirect addresses: registers that show others at another place.

use crate::xm430::{INDIRECT, INDIRECT_LENGTH, IndirectArea};

/// What the indirect data of one servo show, as far as it is known.
#[derive(Clone, Debug)]
pub(super) struct Indirect {
    /// By area and place in it.
    shows: [[Option<u16>; INDIRECT_LENGTH]; INDIRECT.len()],
}

impl Indirect {
    pub(super) const UNKNOWN: Self = Self { shows: [[None; INDIRECT_LENGTH]; INDIRECT.len()] };

    /// The register that a byte of the control table belongs to; nothing if that is not known.
    pub(super) fn register(&self, address: u16) -> Option<u16> {
        for (area, shows) in INDIRECT.iter().zip(&self.shows) {
            if let Some(place) = area.data_place(address) {
                return shows.get(place).copied().flatten();
            }
        }
        Some(address)
    }

    /// Whether a part of the control table shows others.
    pub(super) fn covers(address: u16, length: usize) -> bool {
        INDIRECT.iter().any(|area| area.covers_data(address, length))
    }

    /// Bytes in the control table from `address` on.
    pub(super) fn learn(&mut self, address: u16, bytes: &[u8]) {
        self.change(address, bytes.len(), |offset| {
            let (low, high) = (bytes.get(offset?), bytes.get(offset? + 1));
            Some(u16::from_le_bytes([*low?, *high?]))
        });
    }

    /// The content of this part of the control table is not known any more.
    pub(super) fn doubt(&mut self, address: u16, length: usize) {
        self.change(address, length, |_| None);
    }

    /// Sets every indirect address that the part touches; `value` is given where it begins in the part, if it does.
    fn change(&mut self, address: u16, length: usize, value: impl Fn(Option<usize>) -> Option<u16>) {
        let (from, to) = (usize::from(address), usize::from(address) + length);
        for (area, shows) in INDIRECT.iter().zip(&mut self.shows) {
            for (place, shown) in shows.iter_mut().enumerate() {
                let at = usize::from(area.addresses) + 2 * place;
                if from < at + 2 && at < to {
                    *shown = value(at.checked_sub(from));
                }
            }
        }
    }
}

impl IndirectArea {
    fn data_place(&self, address: u16) -> Option<usize> {
        let place = usize::from(address.checked_sub(self.data)?);
        (place < INDIRECT_LENGTH).then_some(place)
    }

    fn covers_data(&self, address: u16, length: usize) -> bool {
        let (from, data) = (usize::from(address), usize::from(self.data));
        from < data + INDIRECT_LENGTH && data < from + length
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_known_is_not_guessed() {
        let mut indirect = Indirect::UNKNOWN;
        assert_eq!(indirect.register(132), Some(132));
        assert_eq!(indirect.register(224), None);
        // Indirect Address 1 and 2 to Present Position, and the first half of 3.
        indirect.learn(168, &[132, 0, 133, 0, 134]);
        assert_eq!([224, 225, 226].map(|data| indirect.register(data)), [Some(132), Some(133), None]);
        indirect.learn(170, &[126, 0]);
        assert_eq!(indirect.register(225), Some(126));
        indirect.doubt(169, 1);
        assert_eq!([224, 225].map(|data| indirect.register(data)), [None, Some(126)]);
        indirect.learn(578, &[0x84, 0x00]);
        assert_eq!(indirect.register(634), Some(132));
    }

    #[test]
    fn the_areas_end_where_they_end() {
        for (data, covered) in [(223, false), (224, true), (251, true), (252, false), (633, false), (634, true)] {
            assert_eq!(Indirect::covers(data, 1), covered, "{data}");
            assert_eq!(Indirect::UNKNOWN.register(data).is_none(), covered, "{data}");
        }
        assert!(Indirect::covers(200, 100) && Indirect::covers(661, 1) && !Indirect::covers(662, 9));
    }
}
