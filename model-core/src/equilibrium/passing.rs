//! Where the object is that no model of ours knows what it meets: behind the front beam, or against the clamped base.

use super::Follower;
use crate::access::Access;
use crate::contact::Sample;
use crate::model::vec2_of;
use crate::newton::gaps::Sweep;
use crate::object::Object;
use crate::real::Real;
use crate::size::Size;

/// Part of a contact normal (out of the object) that may point to the front beam's outer side. Beyond, the object is behind the front
/// beam, where no finger has a model of what it meets.
const INWARDS: f64 = 0.3;
/// The same at the tip, whose end is round: a wall across it may lie 45° behind.
const ROUND_THE_TIP: f64 = 0.7;

/// Parts of the held front beam between which it is looked at.
const HELD: u8 = 16;

/// The way from the last coordinate at which the object lay clear of the clamped base while something touched: 1 forward, −1 back, 0 if
/// it lies clear. (Not an `Option`, so that [`Follower::EMPTY`] is all zeros.)
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Barred<T> {
    from: T,
    pub(super) way: i8,
}

impl<T: Real> Barred<T> {
    pub(super) const NONE: Self = Self { from: T::ZERO, way: 0 };
}

impl<T: Real, S: Size, O: Object<T>> Follower<T, S, O> {
    /// From the undeformed finger's nearest sample the object lies on the front beam's inner side.
    pub(super) fn rests_behind(&self, sweep: &Sweep<T>) -> bool {
        let [x, y] = self.model.direction.as_ref().at(0);
        sweep.normal[0] * y - sweep.normal[1] * x > T::of(INWARDS)
    }

    /// Some sample touches from the front beam's inner side: the beam has passed the object.
    pub(super) fn presses_from_behind(&self) -> bool {
        let touching = self.timeline.present.touching.as_ref().iter().zip(self.timeline.present.normal.as_ref());
        touching.take(self.timeline.present.touching_count).any(|(&index, normal)| {
            let [x, y] = self.along(&self.model.place(index));
            let is_tip = usize::from(index) + 1 == self.model.place_count();
            let limit = T::of(if is_tip { ROUND_THE_TIP } else { INWARDS });
            // Squared: a root for every sample that touches is worth the trouble on the microcontroller.
            let outwards = normal[0] * y - normal[1] * x;
            outwards > T::ZERO && outwards * outwards > limit * limit * (x * x + y * y)
        })
    }

    /// Where the deformed front beam leads at a sample, of any length.
    fn along(&self, sample: &Sample<T>) -> [T; 2] {
        if sample.rigid != T::ZERO
            && let Some(front) = self.work.kinematics.members.as_ref().get(usize::from(sample.cell))
        {
            return front.rigid_end;
        }
        // The element's node that counts most.
        let [first, middle, last] = sample.weights.map(T::abs);
        let heaviest = if middle >= first && middle >= last { 1 } else { 2 * usize::from(last > first) };
        self.work
            .kinematics
            .nodes
            .as_ref()
            .get(usize::from(sample.node) + heaviest)
            .map_or([T::ZERO; 2], |node| node.strained)
    }

    /// Before the present state is accepted: keeps in mind where the object came against the base while it touched the finger. What the motion would have done to it
    /// from there on nobody knows, until the way has been gone back or the hand opened.
    pub(super) fn bar(&mut self, at: T) {
        let Barred { from, way } = self.barred;
        let is_back = if way > 0 { at <= from } else { at >= from };
        if self.timeline.present.touching_count == 0 {
            self.barred = Barred::NONE;
        } else if !self.base_is_free(at) {
            if way == 0 {
                self.barred = Barred { from: self.timeline.at(), way: if at > self.timeline.at() { 1 } else { -1 } };
            }
        } else if is_back {
            self.barred = Barred::NONE;
        }
    }

    /// The object lies clear of the front beam's clamped end, and of the part that is held, which carry no sample: they cannot give way,
    /// and a model in which the beam beside them does has a force that means nothing.
    pub(super) fn base_is_free(&self, at: T) -> bool {
        // In the world and in mm, where the object is as it was given: one point is moved instead of a whole outline.
        let length = self.model.units.length;
        let to_world = self.motion.world_to_finger(at);
        let (base, held) = (vec2_of(self.model.base), vec2_of(self.model.held));
        let half_thickness = self.model.samples.as_ref().first().map_or(T::ZERO, |sample| sample.half_thickness);
        let pieces = if self.model.held == [T::ZERO; 2] { 0 } else { HELD };
        (0..=pieces).all(|piece| {
            let part = T::of(f64::from(piece) / f64::from(HELD));
            let point = to_world.point_back((base + held * part) * length);
            self.object.gap(point).distance >= (half_thickness - T::TOLERANCE.length) * length
        })
    }
}
