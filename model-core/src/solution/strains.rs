//! Strains along beams, hinges and ribs, from the bends and stretches of an equilibrium.

use super::Solution;
use crate::access::Access;
use crate::real::Real;
use crate::size::Size;
use crate::topology::{Kind, Role};

/// What is strained; spans and lamellae are counted from 0 at the base.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// A span of the front beam.
    Front(usize),
    /// A span of the back beam.
    Back(usize),
    /// The front hinge of a lamella.
    FrontHinge(usize),
    /// The back hinge of a lamella.
    BackHinge(usize),
    /// A rib, its necks included.
    Rib(usize),
}

/// Longitudinal strain of a cross-section, dimensionless, positive where material is drawn out.
///
/// Through the thickness it runs from `stretch + bending` on the right of the direction of growing arc length to
/// `stretch − bending` on its left. Beams lead from base to tip: their right is the side of the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strain<T> {
    /// Beam, hinge or rib.
    pub place: Place,
    /// Undeformed arc length, mm: from the base of a beam, from the front end of a hinge or rib.
    pub arc: T,
    /// Of the centreline: ε = (d·e) − 1, e the direction and d the strained direction of a link.
    pub stretch: T,
    /// Of the right face, from bending alone: θ′·t/2.
    pub bending: T,
}

impl<T: Real> Strain<T> {
    /// The larger magnitude of both faces.
    pub fn largest(self) -> T {
        self.stretch.abs() + self.bending.abs()
    }
}

impl<'a, T: Real, S: Size> Solution<'a, T, S> {
    /// Strains of all flexible members, span by span from the base: at the springs of `paper` and `trapezoid`, at both
    /// ends of the quadratic elements (between which the bend is linear). Pins and welds have none.
    pub fn strains(self) -> impl Iterator<Item = Strain<T>> + 'a {
        let model = self.model;
        let mut beam_arc = model.clamps;
        model.topology.in_cells().flat_map(move |index| {
            let member = model.topology.members.as_ref()[index];
            let nodes = member.nodes();
            let length = model.weight.as_ref()[nodes.clone()].iter().fold(T::ZERO, |sum, &weight| sum + weight);
            let [x, y] = member.rigid_end;
            let mut along = |side: usize| {
                let start = beam_arc[side];
                beam_arc[side] += length + (x * x + y * y).sqrt();
                start
            };
            let (place, start) = match member.role {
                Role::Front(cell) => (Place::Front(usize::from(cell)), along(0)),
                Role::Back(cell) => (Place::Back(usize::from(cell)), along(1)),
                Role::Rung(rung, 0) if model.topology.find(Role::Rung(rung, 1)).is_none() => {
                    (Place::Rib(usize::from(rung)), T::ZERO)
                }
                Role::Rung(rung, 0) => (Place::FrontHinge(usize::from(rung)), T::ZERO),
                Role::Rung(rung, _) => (Place::BackHinge(usize::from(rung)), T::ZERO),
                Role::Gap(rung) => (Place::Rib(usize::from(rung)), T::ZERO),
            };
            let elements = nodes.len() - 1;
            let flexible = length > T::ZERO && member.kind != Kind::Gap;
            (0..if flexible { elements } else { 0 }).map(move |element| {
                let angle = self.state.angle.as_ref().run(nodes.clone());
                let stretch = |node: usize| self.stretch(nodes.start + node);
                let (stretch, bend) = member.kind.section(angle, stretch, element);
                let arc = member.kind.arc(model.weight.as_ref().run(nodes.clone()), element);
                // Of a rung's part that leads from back to front: counted from the front, and bent to the other side.
                let (arc, bend) = if member.is_backwards() { (length - arc, -bend) } else { (arc, bend) };
                Strain {
                    place,
                    arc: model.units.length * (start + arc),
                    stretch,
                    bending: model.fibre.as_ref()[nodes.start + element] * bend,
                }
            })
        })
    }
}

impl<'a, T: Real, S: Size> Solution<'a, T, S> {
    fn stretch(self, node: usize) -> T {
        let on = self.kinematics.nodes.as_ref().at(node);
        let (e, d) = (on.e, on.strained);
        (d[0] - e[0]) * e[0] + (d[1] - e[1]) * e[1]
    }

    /// Largest strain at an outer fibre (bending plus stretch) of front beam, back beam, hinges and ribs, dimensionless.
    pub fn max_strain(self) -> [T; 4] {
        let mut most = [T::ZERO; 4];
        for strain in self.strains() {
            let part = match strain.place {
                Place::Front(_) => 0,
                Place::Back(_) => 1,
                Place::FrontHinge(_) | Place::BackHinge(_) => 2,
                Place::Rib(_) => 3,
            };
            most[part] = most[part].max(strain.largest());
        }
        most
    }
}
