//! Indirect addresses: registers that show others at another place.

use crate::item::IndirectArea;

/// Bytes of indirect data that are followed, over all areas: as many as the X series has. The P series has more, of which those behind
/// count as not known.
const FOLLOWED: usize = 56;

/// What the indirect data of one servo show, as far as it is known.
#[derive(Clone, Debug)]
pub(super) struct Indirect {
    areas: &'static [IndirectArea],
    /// By place over all areas.
    shows: [Option<u16>; FOLLOWED],
}

impl Indirect {
    pub(super) const fn unknown(areas: &'static [IndirectArea]) -> Self {
        Self { areas, shows: [None; FOLLOWED] }
    }

    /// The areas, each with its first place.
    fn areas(&self) -> impl Iterator<Item = (&'static IndirectArea, usize)> + use<> {
        self.areas.iter().scan(0, |next, area| {
            let first = *next;
            *next += usize::from(area.length);
            Some((area, first))
        })
    }

    /// The register that a byte of the control table belongs to; nothing if that is not known.
    pub(super) fn register(&self, address: u16) -> Option<u16> {
        for (area, first) in self.areas() {
            if let Some(place) = area.data_place(address) {
                return self.shows.get(first + place).copied().flatten();
            }
        }
        Some(address)
    }

    /// Whether a part of the control table shows others.
    pub(super) fn covers(&self, address: u16, length: usize) -> bool {
        self.areas.iter().any(|area| area.covers_data(address, length))
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
        for (area, first) in self.areas().filter(|(area, _)| area.covers_addresses(address, length)) {
            let places = self.shows.iter_mut().skip(first).take(usize::from(area.length));
            for (place, shown) in places.enumerate() {
                let at = area.addresses + 2 * place as u16;
                if overlap((address, length), (at, 2)) {
                    *shown = value(at.checked_sub(address).map(usize::from));
                }
            }
        }
    }
}

impl IndirectArea {
    fn data_place(&self, address: u16) -> Option<usize> {
        let place = address.checked_sub(self.data)?;
        (place < self.length).then_some(usize::from(place))
    }

    fn covers_addresses(&self, address: u16, length: usize) -> bool {
        overlap((address, length), (self.addresses, 2 * usize::from(self.length)))
    }

    fn covers_data(&self, address: u16, length: usize) -> bool {
        overlap((address, length), (self.data, usize::from(self.length)))
    }
}

/// Whether two parts of a control table, address and bytes, have a byte in common.
fn overlap((one, length): (u16, usize), (other, other_length): (u16, usize)) -> bool {
    let (one, other) = (usize::from(one), usize::from(other));
    one < other + other_length && other < one + length
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::Model;

    fn unknown(model: u16) -> Indirect {
        Indirect::unknown(Model::of(model).unwrap().indirect)
    }

    #[test]
    fn what_is_not_known_is_not_guessed() {
        let mut indirect = unknown(1020);
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
            assert_eq!(unknown(1020).covers(data, 1), covered, "{data}");
            assert_eq!(unknown(1020).register(data).is_none(), covered, "{data}");
        }
        let indirect = unknown(1020);
        assert!(indirect.covers(200, 100) && indirect.covers(661, 1) && !indirect.covers(662, 9));
    }

    /// The X330 series has data where the others have addresses, the P series more than are followed.
    #[test]
    fn every_model_has_its_own_areas() {
        let mut x330 = unknown(1200);
        x330.learn(168, &[132, 0]);
        assert_eq!([208, 209, 224, 228].map(|data| x330.register(data)), [Some(132), None, None, Some(228)]);
        let mut p = unknown(2100);
        p.learn(168, &[68, 2]);
        p.learn(168 + 2 * 100, &[68, 2]);
        assert_eq!([634, 634 + 100, 224].map(|data| p.register(data)), [Some(580), None, Some(224)]);
    }
}
