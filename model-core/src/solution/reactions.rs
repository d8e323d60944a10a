//! What holds the finger at its clamped base.

use super::Solution;
use crate::real::Real;
use crate::size::Size;
use crate::topology::Role;

impl<T: Real, S: Size> Solution<'_, T, S> {
    /// What the clamped base exerts on the front and on the back beam: force (finger frame, N) and moment about the end of the beam's own
    /// held part, N·mm, counter-clockwise. What it exerts on rungs that end on the held back beam is part of the second.
    ///
    /// The derivatives of the Lagrangian with respect to the clamped places and angles: with the contacts they hold the finger in
    /// balance.
    pub fn base_reactions(self) -> [([T; 2], T); 2] {
        let mut reactions = [0, 1].map(|side| self.beam_reaction(side));
        let unit = self.model.units.moment();
        for cell in 0..self.model.cells() {
            if let Some((force, moment)) = self.rung_reaction(cell) {
                let (sum, total) = &mut reactions[1];
                let force = self.model.units.newtons(force);
                *sum = [sum[0] + force[0], sum[1] + force[1]];
                *total += moment * unit;
            }
        }
        reactions
    }

    fn beam_reaction(self, side: usize) -> ([T; 2], T) {
        // Spans that are held are no members.
        let mut cells = 0..self.model.cells() as u8;
        let role = |cell| if side == 0 { Role::Front(cell) } else { Role::Back(cell) };
        let index = cells.find_map(|cell| self.model.topology.find(role(cell))).unwrap_or(usize::MAX);
        let (Some(member), Some(work)) = (self.model.member(index), self.kinematics.members.as_ref().get(index)) else {
            return ([T::ZERO; 2], T::ZERO);
        };
        let moment =
            self.kinematics.nodes.as_ref().get(usize::from(member.first)).map_or(T::ZERO, |node| node.gradient);
        let mut force = work.force;
        if side == 0 {
            // A member's force is the one at its end: contacts on the span itself come on top.
            for row in self.rows.rows().iter() {
                if row.place.cell == 0 {
                    force = [0, 1].map(|i| force[i] - row.multiplier * row.normal[i]);
                }
            }
        }
        (self.model.units.newtons(force), moment * self.model.units.moment())
    }
}
