//! The deformed shape: tip, centrelines, and where the motion has taken them.

use super::Solution;
use crate::access::Access;
use crate::object::Motion;
use crate::real::{Real, Vec2};
use crate::size::Size;
use crate::topology::{Member, Role};

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
            let member = self.model.topology.members.as_ref().at(index);
            let start = end;
            let d = work.end_to_end();
            end = [start[0] + d[0], start[1] + d[1]];
            let rigid = work.rigid_end[0] != T::ZERO || work.rigid_end[1] != T::ZERO;
            let mut at = start;
            let links = (1..member.nodes().len()).filter_map(move |node| self.point(&member, node, &mut at));
            links.chain(rigid.then_some(end))
        });
        core::iter::once(base).chain(spans).map(|point| self.model.units.millimetres(point))
    }

    /// The point of a member's centreline that belongs to a node after its first; `at` is the end of what lies before, and moves on.
    pub(super) fn point(self, member: &Member<T>, node: usize, at: &mut [T; 2]) -> Option<[T; 2]> {
        let weight = self.model.weight.as_ref().run(member.nodes());
        member.kind.point(weight, |node| self.strained(member, node), node, at)
    }

    /// The same from the member's end to its start.
    pub(super) fn point_back(self, member: &Member<T>, node: usize, at: &mut [T; 2]) -> Option<[T; 2]> {
        let weight = self.model.weight.as_ref().run(member.nodes());
        member.kind.point_back(weight, |node| self.strained(member, node), node, at)
    }

    /// Strained direction of a member's node.
    fn strained(self, member: &Member<T>, node: usize) -> [T; 2] {
        self.kinematics.nodes.as_ref().at(usize::from(member.first) + node).strained
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
