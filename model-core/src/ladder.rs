//! Kinematics and energy of the ladder: two beams, rigid lamellae, flexible hinges as chains between shared joint angles.
//!
//! Unknowns are changes of orientation θ from the undeformed shape. A lamella k has three joint angles (front beam,
//! lamella, back beam), the tip has one. Cell k between two lamellae closes when
//! D^F_k + R_k − D^B_k − R_{k−1} = 0, with D the end-to-end vectors of the front and back span and R = front hinge +
//! lamella + back hinge; each closure has two multipliers λ_k, the internal force.
//!
//! A member's end-to-end vector is D = Σ lᵢ dᵢ + rigid parts. Without stretch and shear dᵢ = eᵢ, the direction of the link.
//! With them, the force f through the link strains it: dᵢ = eᵢ + (f·eᵢ)/EA·eᵢ + (f·e′ᵢ)/κGA·e′ᵢ for a force that pulls,
//! which is −f in the Lagrangian's sign. Stretch and shear thus need no unknowns of their own: they are eliminated node by
//! node, and λ carries their compliance. The bending stiffness follows the stretch (see `newton::bend`).

use crate::access::Access;
use crate::contact::Sample;
use crate::real::{Real, Vec2};
use crate::size::{Blank, Size, Storage};
use crate::units::Units;

/// Joint index of a beam's clamped base. Unknown 0 is a multiplier, never a joint; and a blank ladder is all zeros, so that a
/// static one needs no image in flash.
pub(crate) const CLAMPED: u16 = 0;
/// Joint angles and multipliers of a cell: λx, λy, front, lamella, back.
pub(crate) const PER_CELL: usize = 5;

/// A chain of links between two joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Member<T> {
    /// First node: the start joint's. The interior nodes follow, then the end joint's.
    pub(crate) first: u16,
    /// Number of interior nodes.
    pub(crate) interior: u16,
    /// Unknown of the start joint, or [`CLAMPED`].
    pub(crate) start: u16,
    /// Unknown of the end joint.
    pub(crate) end: u16,
    /// Rigid part that turns with the start joint, undeformed, mm.
    pub(crate) rigid_start: [T; 2],
    /// Rigid part that turns with the end joint, undeformed, mm.
    pub(crate) rigid_end: [T; 2],
    /// 1/EA and 1/κGA, 1/N: stretch and shear per force; 0 for an inextensible, shear-stiff member.
    pub(crate) compliance: [T; 2],
    /// 3c/EA, 1/N: growth of the bending stiffness per force that stretches the member; 0 where it is constant.
    pub(crate) stiffening: T,
    /// What rounding its angles may leave of a gradient component, N·mm.
    pub(crate) rounding: T,
}

impl<T> Member<T> {
    /// Indices of all its nodes, both joints' included.
    #[inline]
    pub(crate) fn nodes(&self) -> core::ops::Range<usize> {
        usize::from(self.first)..usize::from(self.first) + usize::from(self.interior) + 2
    }
}

impl<T: Real> Blank for Member<T> {
    const BLANK: Self = Self {
        first: 0,
        interior: 0,
        start: CLAMPED,
        end: CLAMPED,
        rigid_start: [T::ZERO; 2],
        rigid_end: [T::ZERO; 2],
        compliance: [T::ZERO; 2],
        stiffening: T::ZERO,
        rounding: T::ZERO,
    };
}

/// The discretised finger: constants only.
pub struct Ladder<T: Real, S: Size> {
    pub(crate) cells: usize,
    pub(crate) node_count: usize,
    pub(crate) sample_count: usize,
    /// Samples on the flexible part of the beam; those on the wedge follow.
    pub(crate) flexible_samples: usize,
    /// Samples per element there.
    pub(crate) per_element: usize,
    /// Places at which a gap can be checked per sample: the sample, and others that divide the way to it from the one before evenly.
    pub(crate) fineness: usize,
    /// Smallest radius of the line along which the centreline touches the object.
    pub(crate) sharpest: T,
    /// Largest radius of such a line at which places between the samples count.
    pub(crate) bluntest: T,
    /// Units of the numbers below: lengths are in units of length, moments in units of moment, and so on.
    pub(crate) units: Units<T>,
    /// Contact softness ε_c asked for, and that of the front beam itself.
    pub(crate) softness: [T; 2],
    /// The first is the second: it goes with Young's modulus.
    pub(crate) softness_is_own: bool,
    /// Nodes are the ends and middles of quadratic elements, not links.
    pub(crate) quadratic: bool,
    /// The lamellae turn with the beams: the three angles at a lamella are one, the back beam's.
    pub(crate) welded: bool,
    /// Weight lᵢ of a node's direction in its member's end-to-end vector, mm.
    pub(crate) weight: S::Nodes<T>,
    /// Undeformed direction (cos β, sin β) at a node.
    pub(crate) direction: S::Nodes<[T; 2]>,
    /// Entries of the energy matrix K towards the next node and the one after, N·mm; K's rows sum to zero.
    pub(crate) coupling: S::Nodes<[T; 2]>,
    /// Diagonal of the energy matrix K, N·mm.
    pub(crate) diagonal: S::Nodes<T>,
    /// Half the thickness over the length of the spring or element that begins at a node: strain per bend.
    pub(crate) fibre: S::Nodes<T>,
    /// Front span, back span, front hinge, back hinge of each cell; the tip cell has no hinges.
    pub(crate) members: S::Members<Member<T>>,
    pub(crate) samples: S::Samples<Sample<T>>,
    /// Closures of the undeformed ladder (rounding residue), mm.
    pub(crate) rest: S::Cells<[T; 2]>,
    /// Magnitude of each diagonal entry of the condensed system at rest.
    pub(crate) scale: S::Unknowns<T>,
    /// What rounding the angles may leave of a joint's gradient, N·mm; 0 at the closures.
    pub(crate) rounding: S::Unknowns<T>,
    /// Front beam's base, mm.
    pub(crate) base: [T; 2],
    /// From the front beam's base to the back beam's, mm.
    pub(crate) base_rung: [T; 2],
}

impl<T: Real, S: Size> Ladder<T, S> {
    /// A ladder to be discretised into.
    pub const EMPTY: Self = Self {
        cells: 0,
        node_count: 0,
        sample_count: 0,
        flexible_samples: 0,
        per_element: 0,
        fineness: 0,
        sharpest: T::ZERO,
        bluntest: T::ZERO,
        units: Units::NONE,
        softness: [T::ZERO; 2],
        softness_is_own: false,
        quadratic: false,
        welded: false,
        weight: <S::Nodes<T> as Storage<T>>::EMPTY,
        direction: <S::Nodes<[T; 2]> as Storage<[T; 2]>>::EMPTY,
        coupling: <S::Nodes<[T; 2]> as Storage<[T; 2]>>::EMPTY,
        diagonal: <S::Nodes<T> as Storage<T>>::EMPTY,
        fibre: <S::Nodes<T> as Storage<T>>::EMPTY,
        members: <S::Members<Member<T>> as Storage<Member<T>>>::EMPTY,
        samples: <S::Samples<Sample<T>> as Storage<Sample<T>>>::EMPTY,
        rest: <S::Cells<[T; 2]> as Storage<[T; 2]>>::EMPTY,
        scale: <S::Unknowns<T> as Storage<T>>::EMPTY,
        rounding: <S::Unknowns<T> as Storage<T>>::EMPTY,
        base: [T::ZERO; 2],
        base_rung: [T::ZERO; 2],
    };

    /// Forgets everything and makes room for the cells; false if there is none.
    pub(crate) fn reset(&mut self, cells: usize) -> bool {
        self.cells = 0;
        self.node_count = 0;
        self.sample_count = 0;
        // The tip cell has no hinges, and one angle.
        let fits = cells == 0
            || self.members.fit(4 * cells - 2)
                && self.rest.fit(cells)
                && self.scale.fit(PER_CELL * cells - 2)
                && self.rounding.fit(PER_CELL * cells - 2);
        if fits {
            self.cells = cells;
            self.members.as_mut().fill(Member::BLANK);
            self.weight.as_mut().fill(T::ZERO);
            self.coupling.as_mut().fill([T::ZERO; 2]);
            self.scale.as_mut().fill(T::ZERO);
            self.rounding.as_mut().fill(T::ZERO);
        }
        fits
    }

    /// Makes room for nodes; false if there is none.
    pub(crate) fn fit_nodes(&mut self, count: usize) -> bool {
        self.weight.fit(count)
            && self.direction.fit(count)
            && self.coupling.fit(count)
            && self.diagonal.fit(count)
            && self.fibre.fit(count)
    }

    /// Unknown of a joint: slot 2 is the front beam's angle at a lamella, 3 the lamella's, 4 the back beam's; the tip has
    /// one angle for all.
    pub(crate) fn joint(&self, cell: usize, slot: usize) -> u16 {
        let slot = match slot {
            _ if cell + 1 == self.cells => 2,
            _ if self.welded => 4,
            slot => slot,
        };
        (PER_CELL * cell + slot) as u16
    }

    /// Number of unknowns of the condensed system.
    #[inline]
    pub(crate) fn unknowns(&self) -> usize {
        // The tip cell has λ and one angle.
        PER_CELL * self.cells - 2
    }

    /// Members in use: 4 per cell but 2 in the tip cell.
    #[inline]
    pub(crate) fn member_count(&self) -> usize {
        4 * self.cells - 2
    }

    /// The members in use.
    #[inline]
    pub(crate) fn members(&self) -> &[Member<T>] {
        // The tip cell has no hinges.
        self.members.as_ref().get(..(4 * self.cells).saturating_sub(2)).unwrap_or(&[])
    }

    /// Number of angles of the model (interior nodes and joints).
    pub fn angles(&self) -> usize {
        if self.cells == 0 {
            return 0;
        }
        let interior: usize = self.members().iter().map(|m| usize::from(m.interior)).sum();
        interior + 3 * (self.cells - 1) + 1
    }

    /// Sets K's diagonal from the entries beside it, and what rounding may leave of the moments: an angle is known to a relative
    /// [`Real::EPSILON`], and a stiff member turns that into a moment that has no meaning.
    pub(crate) fn complete_stiffness(&mut self) {
        let count = self.member_count();
        for member in self.members.as_mut().run_mut(0..count) {
            let nodes = member.nodes();
            let diagonal = self.diagonal.as_mut().run_mut(nodes.clone());
            diagonal.fill(T::ZERO);
            for (node, &[next, after]) in self.coupling.as_ref().run(nodes).iter().enumerate() {
                for (at, entry) in [(node, next), (node + 1, next), (node, after), (node + 2, after)] {
                    if let Some(value) = diagonal.get_mut(at) {
                        *value -= entry;
                    }
                }
            }
            let stiffest = diagonal.iter().fold(T::ZERO, |most, &entry| most.max(entry));
            member.rounding = T::EPSILON * stiffest;
            for joint in [member.start, member.end] {
                if joint != CLAMPED {
                    self.rounding.as_mut().add(usize::from(joint), member.rounding);
                }
            }
        }
    }

    /// Sets the closures' constants so that the undeformed ladder is exactly closed in this precision.
    pub(crate) fn close_at_rest(&mut self) {
        let mut rung = vec2_of(self.base_rung);
        for cell in 0..self.cells {
            let front = self.rest_vector(4 * cell);
            let back = self.rest_vector(4 * cell + 1);
            let next = if cell + 1 < self.cells {
                self.rest_vector(4 * cell + 2) + self.rest_vector(4 * cell + 3)
            } else {
                Vec2::new(T::ZERO, T::ZERO)
            };
            let closure = front + next - back - rung;
            self.rest.as_mut().put(cell, [closure.x, closure.y]);
            rung = next;
        }
    }

    fn rest_vector(&self, member: usize) -> Vec2<T> {
        let m = self.members.as_ref().at(member);
        let mut sum = vec2_of(m.rigid_start) + vec2_of(m.rigid_end);
        for node in m.nodes() {
            sum += vec2_of(self.direction.as_ref().at(node)) * self.weight.as_ref().at(node);
        }
        sum
    }

    /// Adds a member's share to the magnitude that each diagonal entry of the condensed system has at rest, from its
    /// bending stiffness EI/L (N·mm) and length L (mm): 4 EI/L at a joint, L³/(12 EI) at a closure. Enough to tell a
    /// vanishing pivot from a small one.
    pub(crate) fn add_scale(&mut self, index: usize, stiffness: f64, length: f64) {
        let member = self.members.as_ref().at(index);
        let scale = self.scale.as_mut();
        let joint = T::of(4.0 * stiffness);
        if member.start != CLAMPED {
            scale.add(usize::from(member.start), joint);
        }
        scale.add(usize::from(member.end), joint);
        let flexibility = if stiffness > 0.0 { T::of(length * length / (12.0 * stiffness)) } else { T::ZERO };
        let cell = index / 4;
        for offset in 0..2 {
            scale.add(PER_CELL * cell + offset, flexibility);
            if index % 4 >= 2 {
                scale.add(PER_CELL * (cell + 1) + offset, flexibility);
            }
        }
    }
}

#[inline]
pub(crate) fn vec2_of<T: Real>(v: [T; 2]) -> Vec2<T> {
    Vec2::new(v[0], v[1])
}

/// Direction at a node turned by its angle.
#[inline]
pub(crate) fn turned<T: Real>(direction: [T; 2], cosine: T, sine: T) -> [T; 2] {
    [cosine * direction[0] - sine * direction[1], sine * direction[0] + cosine * direction[1]]
}
