//! The deformed shape: tip, centrelines, and where the motion has taken them.

use super::Solution;
use crate::access::Access;
use crate::object::Motion;
use crate::real::{Real, Vec2};
use crate::size::Size;
use crate::topology::Role;

impl<'a, T: Real, S: Size> Solution<'a, T, S> {
    /// Deformed tip of the front beam, finger frame, mm.
    pub fn tip(self) -> [T; 2] {
        self.model.units.millimetres(self.kinematics.tip(self.model))
    }

    /// Deformed centreline of the front beam, finger frame, mm, from where its held part ends to the tip: the ends of its links, or the ends
    /// and middles of its quadratic elements.
    pub fn front(self) -> impl Iterator<Item = [T; 2]> + 'a {
        self.centreline(0)
    }

    /// Deformed centreline of the back beam; as [`Self::front`].
    pub fn back(self) -> impl Iterator<Item = [T; 2]> + 'a {
        self.centreline(1)
    }

    fn centreline(self, side: usize) -> impl Iterator<Item = [T; 2]> + 'a {
        let mut base = self.model.base;
        if side == 1 {
            base[0] += self.model.base_rung[0];
            base[1] += self.model.base_rung[1];
        }
        let mut end = base;
        let indices = (0..self.model.cells()).filter_map(move |cell| {
            // Spans that are held are no members.
            let role = if side == 0 { Role::Front(cell as u8) } else { Role::Back(cell as u8) };
            self.model.topology.find(role)
        });
        let spans = indices.flat_map(move |index| {
            let work = self.kinematics.members.as_ref().at(index);
            let nodes = self.model.topology.members.as_ref().at(index).nodes();
            let start = end;
            let d = work.end_to_end();
            end = [start[0] + d[0], start[1] + d[1]];
            let rigid = work.rigid_end[0] != T::ZERO || work.rigid_end[1] != T::ZERO;
            let mut at = start;
            let links = (nodes.start + 1..nodes.end).filter_map(move |node| self.link(index, node, &mut at));
            links.chain(rigid.then_some(end))
        });
        core::iter::once(base).chain(spans).map(|point| self.model.units.millimetres(point))
    }

    /// The point of a member's centreline that belongs to a node after the first; `at` is the last link's or element's
    /// end and moves on.
    pub(super) fn link(self, index: usize, node: usize, at: &mut [T; 2]) -> Option<[T; 2]> {
        let (e, weight) = (|node: usize| self.kinematics.nodes.as_ref().at(node).strained, self.model.weight.as_ref());
        let nodes = self.model.topology.members.as_ref().at(index).nodes();
        if !self.model.quadratic || nodes.len() < 3 {
            let w = weight.at(node);
            *at = [at[0] + w * e(node)[0], at[1] + w * e(node)[1]];
            return (w > T::ZERO).then_some(*at);
        }
        let local = node - nodes.start;
        let middle = if local % 2 == 1 { node } else { node - 1 };
        // Simpson's weight of the middle is 4h/6.
        let h = weight.at(middle) * T::of(1.5);
        let (a, m, b) = (e(middle - 1), e(middle), e(middle + 1));
        let sixth = h * T::of(1.0 / 6.0);
        let chord = [0, 1].map(|i| sixth * (a[i] + T::of(4.0) * m[i] + b[i]));
        if local % 2 == 1 {
            // The cubic Hermite curve at ξ = 1/2.
            return Some([0, 1].map(|i| at[i] + T::of(0.5) * chord[i] + T::of(0.125) * h * (a[i] - b[i])));
        }
        *at = [at[0] + chord[0], at[1] + chord[1]];
        Some(*at)
    }

    /// Where the motion has taken the base: how far it has moved, world frame, mm, and how far the motor has turned it about its axis, rad.
    pub fn base(self) -> ([T; 2], T) {
        match self.motion {
            Motion::Rotating { .. } => ([T::ZERO; 2], self.coordinate),
            Motion::Translating { direction } => (direction.map(|part| T::of(part) * self.coordinate), T::ZERO),
        }
    }

    /// Turns a finger-frame point into the world frame, mm.
    pub fn to_world(self, point: [T; 2]) -> [T; 2] {
        let d = self.displacement();
        let p = d.vector_back(Vec2::new(point[0], point[1]) - d.translation);
        [p.x, p.y]
    }
}
