//! Which measurement is at a place, found without a look at all others: a file may have a million places.

use std::collections::HashMap;

/// Places closer than this are the same one.
const SAME_PLACE: f64 = 1e-6;

/// Places with the index of their measurement, by the interval of the width [`SAME_PLACE`] in which they lie.
#[derive(Default)]
pub(super) struct Places(HashMap<i64, Vec<(usize, f64)>>);

impl Places {
    /// The first measurement that is at the same place.
    pub(super) fn find(&self, place: f64) -> Option<usize> {
        let middle = interval(place);
        let near = (middle - 1..=middle + 1).filter_map(|interval| self.0.get(&interval)).flatten();
        near.filter(|(_, other)| (other - place).abs() < SAME_PLACE).map(|(index, _)| *index).min()
    }

    /// Takes note of a measurement.
    pub(super) fn add(&mut self, place: f64, index: usize) {
        self.0.entry(interval(place)).or_default().push((index, place));
    }
}

/// The interval in which a place lies. Places are degrees or mm within their limits, so that its number fits.
fn interval(place: f64) -> i64 {
    (place / SAME_PLACE).floor() as i64
}

#[cfg(test)]
mod tests {
    use super::Places;

    #[test]
    fn places_a_little_apart_are_the_same_one() {
        let mut places = Places::default();
        places.add(2.0, 0);
        places.add(-2.0, 1);
        assert_eq!(
            [2.0, 2.0 + 0.9e-6, 2.0 - 0.9e-6, -2.0].map(|at| places.find(at)),
            [Some(0), Some(0), Some(0), Some(1)]
        );
        assert_eq!([2.0 + 1.1e-6, 0.0].map(|at| places.find(at)), [None, None]);
    }
}
