//! Where an open hand meets the object: with friction, slip counts from there.
//!
//! A step that begins in the open and ends in contact would take the way before the contact for slip, and what sticks would be pulled by it:
//! the force would depend on where the steps happen to end. So the step is cut where the finger at rest touches, which costs no iteration.

use super::Follower;
use crate::object::Object;
use crate::real::Real;
use crate::size::Size;

/// Gap up to which a finger counts as touching, mm in the finger's units ([`crate::units`]).
const MET: f64 = 2e-4;
/// Looks at the way at most. The gap changes almost evenly, so that two or three are enough as a rule.
const LOOKS: u32 = 8;

impl<T: Real, S: Size, O: Object<T>> Follower<T, S, O> {
    /// From the accepted open hand towards a coordinate: the last place that was found clear before the finger at rest touches. `None` if it does
    /// not touch on that way, or at its beginning. The workspace shows nothing that may be read.
    #[inline(never)]
    pub(super) fn meets(&mut self, to: T) -> Option<T> {
        let from = self.timeline.at();
        let [mut open, mut shut] = [from, to];
        let mut inside = self.sweep_at_rest(to).nearest;
        if inside >= T::ZERO {
            return None;
        }
        let mut gap = self.sweep_at_rest(from).nearest;
        let met = T::of(MET);
        for _ in 0..LOOKS {
            if gap <= met {
                break;
            }
            // Aims at half of what counts as touching; an end that stays twice counts half (Illinois).
            let part = (gap - T::of(0.5) * met) / (gap - inside);
            let place = open + (shut - open) * part;
            let found = self.sweep_at_rest(place).nearest;
            if found < T::ZERO {
                (shut, inside) = (place, found);
            } else {
                inside *= if open == from { T::one() } else { T::of(0.5) };
                (open, gap) = (place, found);
            }
        }
        (open != from).then_some(open)
    }

    /// Accepts the open hand at a coordinate where it is clear. Without memory a sweep shows all that is remembered of it.
    pub(super) fn wait_open(&mut self, at: T) {
        if self.remembers() {
            self.timeline.present.rest();
            self.accept(at);
        } else {
            self.sweep = self.sweep_at_rest(at);
            self.keep(at);
        }
    }
}
