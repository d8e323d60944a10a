//! Room for words in a picture: which places others have taken already.

use super::path::Rect;

/// Places that are taken.
#[derive(Debug, Default)]
pub(super) struct Room {
    taken: Vec<Rect>,
}

impl Room {
    /// Takes a place, whatever else is there.
    pub(super) fn take(&mut self, place: Rect) {
        self.taken.push(place);
    }

    /// Takes the first of some places that is within bounds and free of all others; none if there is none.
    pub(super) fn first(&mut self, within: Rect, places: impl IntoIterator<Item = Rect>) -> Option<Rect> {
        let fits = |place: &Rect| {
            place.left >= within.left
                && place.right <= within.right
                && place.top >= within.top
                && place.bottom <= within.bottom
        };
        let apart =
            |a: &Rect, b: &Rect| a.right <= b.left || b.right <= a.left || a.bottom <= b.top || b.bottom <= a.top;
        let found =
            places.into_iter().find(|place| fits(place) && self.taken.iter().all(|other| apart(place, other)))?;
        self.taken.push(found);
        Some(found)
    }
}

#[cfg(test)]
mod tests {
    use super::{Rect, Room};

    #[test]
    fn a_place_is_given_once() {
        let square = |left: f64, top: f64| Rect { left, top, right: left + 10.0, bottom: top + 10.0 };
        let within = Rect { left: 0.0, top: 0.0, right: 30.0, bottom: 10.0 };
        let mut room = Room::default();
        room.take(square(0.0, 0.0));
        // The first is taken, the second out of bounds.
        let places = [square(5.0, 0.0), square(25.0, 0.0), square(10.0, 0.0)];
        assert_eq!(room.first(within, places), Some(square(10.0, 0.0)));
        assert_eq!(room.first(within, places), None);
    }
}
