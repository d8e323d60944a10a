//! Room for words in a picture: which places others have taken already.

use super::path::Rect;

/// Places that are taken.
#[derive(Debug, Default)]
pub(super) struct Room {
    taken: Vec<Rect>,
    avoided: Vec<Rect>,
}

impl Room {
    /// Takes a place, whatever else is there.
    pub(super) fn take(&mut self, place: Rect) {
        self.taken.push(place);
    }

    /// Has words keep off a place while there is another one for them.
    pub(super) fn avoid(&mut self, place: Rect) {
        self.avoided.push(place);
    }

    /// Takes the first of some places that is within bounds and free of all others, at best of those to avoid too; none if there is
    /// none.
    pub(super) fn first(&mut self, within: Rect, places: impl IntoIterator<Item = Rect>) -> Option<Rect> {
        let fits = |place: &Rect| {
            place.left >= within.left
                && place.right <= within.right
                && place.top >= within.top
                && place.bottom <= within.bottom
        };
        let apart =
            |a: &Rect, b: &Rect| a.right <= b.left || b.right <= a.left || a.bottom <= b.top || b.bottom <= a.top;
        let mut free =
            places.into_iter().filter(|place| fits(place) && self.taken.iter().all(|other| apart(place, other)));
        let first = free.next()?;
        let open = |place: &Rect| self.avoided.iter().all(|other| apart(place, other));
        let found = std::iter::once(first).chain(free).find(open).unwrap_or(first);
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
        // One to avoid is taken only where there is no other.
        let mut room = Room::default();
        room.avoid(square(5.0, 0.0));
        let places = [square(0.0, 0.0), square(20.0, 0.0)];
        assert_eq!(room.first(within, places), Some(square(20.0, 0.0)));
        assert_eq!(room.first(within, places), Some(square(0.0, 0.0)));
    }
}
