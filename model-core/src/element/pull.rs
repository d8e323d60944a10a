//! The force through a member's nodes (15): contacts on the member pull at what lies below them.

use crate::contact::Row;
use crate::real::Real;

/// Forces through a member's nodes, from its end to its start.
pub(crate) struct Pull<'a, T> {
    /// Touching samples on the member, base to tip; those beyond the present node are taken off.
    own: &'a [Row<T>],
    carried: [T; 2],
}

impl<'a, T: Real> Pull<'a, T> {
    /// The force at the member's end; `own` are the rows that touch it.
    #[inline(always)]
    pub fn new(own: &'a [Row<T>], force: [T; 2]) -> Self {
        Self { own, carried: force }
    }

    /// Force per weight through a node of weight w: contacts beyond the node pull the whole of it, those at it a part.
    #[inline(always)]
    pub fn force(&mut self, node: usize, w: T) -> [T; 2] {
        let mut force = self.carried;
        if self.own.is_empty() {
            return force;
        }
        while let Some((row, below)) = self.own.split_last()
            && usize::from(row.place.node) > node
        {
            self.own = below;
            force = [force[0] - row.multiplier * row.normal[0], force[1] - row.multiplier * row.normal[1]];
        }
        self.carried = force;
        if w != T::ZERO {
            for row in self.own {
                let part = row.place.weights.get(node.wrapping_sub(usize::from(row.place.node)));
                if let Some(&part) = part {
                    let share = row.multiplier * part / w;
                    force = [force[0] - share * row.normal[0], force[1] - share * row.normal[1]];
                }
            }
        }
        force
    }
}
