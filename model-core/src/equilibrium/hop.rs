//! Where the force hops: a fall so steep that it is a snap-through for whoever holds something, on a branch that goes on.
//!
//! Where a small change of the finger rounds a fold off (another hinge, another height), the same loss of force comes continuously, and no
//! branch ends. It is flagged alike: a fall by [`HOP`] of the force within [`WAY`] of a degree, or of the finger's unit of length. A force that falls as the finger
//! closes, or rises as it opens, is one that the finger does not hold by itself; what falls more slowly can be followed and corrected.

use super::{Follower, Settings};
use crate::object::{Motion, Object};
use crate::real::Real;
use crate::size::Size;

/// Part of the force that a hop takes at least.
const HOP: f64 = 0.02;
/// Way on which it takes that, in parts of the largest step's default: 0.016°. A force that went on like this would be gone within 0.8°.
const WAY: f64 = 1.0 / 64.0;

/// Where the force began to fall, as far back as it matters: coordinate and Σ μ n there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fall<T> {
    from: T,
    force: [T; 2],
    /// It has been flagged: it counts once, however far it goes.
    hopped: bool,
}

impl<T: Real> Fall<T> {
    pub(super) const NONE: Self = Self { from: T::ZERO, force: [T::ZERO; 2], hopped: false };
}

impl<T: Real> Fall<T> {
    /// Expresses its force in another unit, which the old one is `part` of.
    pub(super) fn express(&mut self, part: T) {
        self.force = self.force.map(|force| part * force);
    }
}

fn size<T: Real>([x, y]: [T; 2]) -> T {
    (x * x + y * y).sqrt()
}

/// Difference of two forces as a part of the larger one.
pub(super) fn change<T: Real>(now: [T; 2], before: [T; 2]) -> T {
    let most = size(now).max(size(before));
    if most > T::ZERO { size([now[0] - before[0], now[1] - before[1]]) / most } else { T::ZERO }
}

impl<T: Real, S: Size, O: Object<T>> Follower<T, S, O> {
    /// Way of the coordinate on which a fall is a hop. Whatever steps are asked for, it is the same.
    fn window(&self) -> T {
        match self.motion {
            Motion::Rotating { .. } => T::of(WAY * Settings::DEFAULT.max_angle_step),
            Motion::Translating { .. } => T::of(WAY * Settings::DEFAULT.max_distance_step) * self.model.units.length,
        }
    }

    /// The forces of the present and of the accepted state.
    pub(super) fn forces(&self) -> [[T; 2]; 2] {
        [self.timeline.present.force(), self.timeline.accepted.force()]
    }

    /// The force falls from the accepted state to the present one, further along the motion at `to`. (Whichever way an object is carried, its
    /// force may well fall.)
    fn falls(&self, to: T, [now, before]: [[T; 2]; 2]) -> bool {
        let closes = to > self.timeline.at();
        let square = |v: [T; 2]| v[0] * v[0] + v[1] * v[1];
        let falls = (square(now) < square(before)) == closes;
        let holds = self.timeline.present.touching_count > 0 && self.timeline.accepted.touching_count > 0;
        holds && falls && to != self.timeline.at() && !self.timeline.is_marked()
    }

    /// A step to the present state passes over a fall that the last one has not announced: only smaller ones can tell whether it is steep.
    pub(super) fn passes_a_fall(&self, to: T, forces: [[T; 2]; 2]) -> bool {
        let long = (to - self.timeline.at()).abs() > self.window();
        long && self.falls(to, forces) && {
            let [now, before] = forces;
            let slope = self.timeline.ahead(to).unwrap_or(T::ZERO);
            let earlier = self.timeline.previous.force();
            let expected = [0, 1].map(|i| before[i] + slope * (before[i] - earlier[i]));
            change(now, before) > T::of(HOP) && change(now, expected) > T::of(HOP)
        }
    }

    /// Notes whether the force falls, and whether it has hopped by the step to the present state, which is about to be accepted.
    pub(super) fn hops(&mut self, to: T, forces: [[T; 2]; 2]) -> bool {
        let [now, before] = forces;
        if !self.falls(to, forces) {
            self.fall = Fall { from: to, force: now, hopped: false };
            return false;
        }
        if (to - self.fall.from).abs() > self.window() {
            self.fall = Fall { from: self.timeline.at(), force: before, ..self.fall };
        }
        // A longer step is one whose fall was announced: it hops if it is as steep all along.
        let ways = ((to - self.fall.from).abs() / self.window()).max(T::one());
        let hops = !self.fall.hopped && change(now, self.fall.force) > T::of(HOP) * ways;
        self.fall.hopped |= hops;
        self.snapped |= hops;
        hops
    }

    /// A fall begins at the present state, if one does.
    pub(super) fn begin_fall(&mut self, at: T) {
        self.fall = Fall { from: at, force: self.timeline.present.force(), hopped: false };
    }
}
