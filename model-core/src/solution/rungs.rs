//! Ribs and lamellae of an equilibrium, and what holds those that end on a held beam.
//!
//! A rung's parts lead from the front beam to the back beam; where that is held, they lead the other way, and are read mirrored.

use super::Solution;
use crate::access::Access;
use crate::element::Strain;
use crate::real::Real;
use crate::size::Size;
use crate::topology::{CLAMPED, Member, Role};

fn onwards<T: Real>(from: [T; 2], d: [T; 2]) -> [T; 2] {
    [from[0] + d[0], from[1] + d[1]]
}

fn back<T: Real>(d: [T; 2]) -> [T; 2] {
    [-d[0], -d[1]]
}

/// A part of a rung as it leads from the front beam to the back beam: its rigid part next to the front, what bends, and the other rigid part.
struct Part<T> {
    near: [T; 2],
    chord: [T; 2],
    far: [T; 2],
}

impl<T: Real> Part<T> {
    fn of(member: &Member<T>, out: &Strain<T>) -> Self {
        if member.is_backwards() {
            return Self { near: back(out.rigid_end), chord: back(out.chord), far: back(out.rigid_start) };
        }
        Self { near: out.rigid_start, chord: out.chord, far: out.rigid_end }
    }

    fn whole(self) -> [T; 2] {
        onwards(onwards(self.near, self.chord), self.far)
    }
}

impl<'a, T: Real, S: Size> Solution<'a, T, S> {
    /// The part of a rung with a number, counted from the front.
    fn rung_part(self, cell: usize, number: u8) -> Option<Part<T>> {
        let index = self.model.topology.find(Role::Rung(cell as u8, number))?;
        Some(Part::of(self.model.member(index)?, self.kinematics.members.as_ref().get(index)?))
    }

    /// Deformed centreline of every rib from where it begins to bend, front to back, finger frame, mm, base to tip; none of rigid lamellae.
    pub fn ribs(self) -> impl Iterator<Item = impl Iterator<Item = [T; 2]> + 'a> + 'a {
        (0..self.model.cells().saturating_sub(1)).filter_map(move |cell| {
            let index = self.model.topology.find(Role::Rung(cell as u8, 0))?;
            let member = self.model.member(index).filter(|member| member.start != member.end)?;
            if self.model.topology.find(Role::Rung(cell as u8, 1)).is_some() {
                return None;
            }
            let part = self.rung_part(cell, 0)?;
            let first = onwards(self.kinematics.start.as_ref().at(cell + 1), part.near);
            let count = member.nodes().len();
            let mut at = first;
            let links = (1..count).filter_map(move |step| {
                if member.is_backwards() {
                    self.point_back(member, count - step, &mut at)
                } else {
                    self.point(member, step, &mut at)
                }
            });
            Some(core::iter::once(first).chain(links).map(|point| self.model.units.millimetres(point)))
        })
    }

    /// Ends of the lamellae (front, back), finger frame, mm, base to tip: of rigid ones the bar's, of ribs those of what bends.
    pub fn lamellae(self) -> impl Iterator<Item = [[T; 2]; 2]> + 'a {
        (0..self.model.cells().saturating_sub(1)).map(move |cell| {
            let start = self.kinematics.start.as_ref().at(cell + 1);
            let ends = match (self.rung_part(cell, 0), self.rung_part(cell, 1)) {
                // The bar is the rigid part between both hinges.
                (Some(front), Some(behind)) => {
                    let from = onwards(start, onwards(front.near, front.chord));
                    [from, onwards(from, onwards(front.far, behind.near))]
                }
                (Some(rib), None) if rib.chord != [T::ZERO; 2] => {
                    let from = onwards(start, rib.near);
                    [from, onwards(from, rib.chord)]
                }
                (part, _) => [start, part.map_or(start, |bar| onwards(start, bar.whole()))],
            };
            ends.map(|end| self.model.units.millimetres(end))
        })
    }

    /// What holds the back end of a rung on the part of the back beam that is held, in the model's units: force, and moment about the end
    /// of that part.
    pub(super) fn rung_reaction(self, cell: usize) -> Option<([T; 2], T)> {
        if cell + 1 == self.model.cells() || self.model.topology.find(Role::Back(cell as u8)).is_some() {
            return None;
        }
        let mut from = self.kinematics.start.as_ref().at(cell + 1);
        let (mut force, mut moment) = ([T::ZERO; 2], T::ZERO);
        for number in 0..2 {
            let Some(index) = self.model.topology.find(Role::Rung(cell as u8, number)) else { continue };
            let (member, out) = (self.model.member(index)?, self.kinematics.members.as_ref().get(index)?);
            let part = Part::of(member, out);
            from = onwards(from, part.whole());
            // A part that leads from the held end has the force that acts there; a bar between pins has the other.
            let sign = if member.is_backwards() { T::one() } else { -T::one() };
            force = out.force.map(|f| sign * f);
            if member.start == CLAMPED {
                let gradient = self.kinematics.nodes.as_ref().at(usize::from(member.first)).gradient;
                let [x, y] = out.rigid_start;
                moment = gradient + force[1] * x - force[0] * y;
            }
        }
        let end = onwards(self.model.base, self.model.base_rung);
        let arm = [from[0] - end[0], from[1] - end[1]];
        Some((force, moment + force[1] * arm[0] - force[0] * arm[1]))
    }
}
