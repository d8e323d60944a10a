//! The discretised finger: all that does not change while a motion is followed.
//!
//! A member's end-to-end vector is D = Σ lᵢ dᵢ + rigid parts. Without stretch and shear dᵢ = eᵢ, the direction of the link.
//! With them, the force f through the link strains it: dᵢ = eᵢ + (f·eᵢ)/EA·eᵢ + (f·e′ᵢ)/κGA·e′ᵢ for a force that pulls,
//! which is −f in the Lagrangian's sign. Stretch and shear thus need no unknowns of their own: they are eliminated node by
//! node, and λ carries their compliance. The bending stiffness follows the stretch (see `element`).

use crate::access::Access;
use crate::contact::Sample;
use crate::element::Constants;
use crate::real::{Real, Vec2};
use crate::size::{Size, Storage};
use crate::topology::{CLAMPED, Member, Topology};
use crate::units::Units;

/// The discretised finger: constants only.
pub struct Model<T: Real, S: Size> {
    pub(crate) topology: Topology<T, S>,
    pub(crate) node_count: usize,
    pub(crate) sample_count: usize,
    /// First sample of each front span; those on its rigid end follow those on its elements.
    pub(crate) first_samples: S::Cells<u16>,
    /// Samples per element there.
    pub(crate) per_element: usize,
    /// Places at which a gap can be checked per sample: the sample, and others that divide the way to it from the one before evenly.
    pub(crate) fineness: usize,
    /// Of the samples every how many one counts, from the tip down; 0 as 1 (see [`crate::places`]).
    pub(crate) every: u16,
    /// Smallest radius of the line along which the centreline touches the object.
    pub(crate) sharpest: T,
    /// Largest radius of such a line at which places between the samples count.
    pub(crate) bluntest: T,
    /// Units of the numbers below: lengths are in units of length, moments in units of moment, and so on.
    pub(crate) units: Units<T>,
    /// Contact softness ε_c asked for, and that of the front beam itself.
    pub(crate) softness: [T; 2],
    /// Unit of force, and softness, of a sudden step at the modulus that the design has: those in use go with the step.
    pub(crate) sudden: (T, [T; 2]),
    /// The first is the second: it goes with Young's modulus.
    pub(crate) softness_is_own: bool,
    /// There is friction, which a contact without softness would not find an equilibrium with where what sticks begins to slip.
    pub(crate) rubs: bool,
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
    pub(crate) samples: S::Samples<Sample<T>>,
    /// Buckling load of each rib between clamped ends, 4π²EI/L² of an even one, in units of force, or a sixteenth of it where one end is free;
    /// 0 where a rung is none.
    pub(crate) buckling_loads: S::Cells<T>,
    /// Where the front beam's held part ends, mm.
    pub(crate) base: [T; 2],
    /// From there to where the back beam's held part ends, mm.
    pub(crate) base_rung: [T; 2],
    /// Arc lengths of the held parts of front and back beam, mm.
    pub(crate) clamps: [T; 2],
    /// From the end of the front beam's to its start, mm.
    pub(crate) held: [T; 2],
}

impl<T: Real, S: Size> Model<T, S> {
    /// A model to be discretised into.
    pub const EMPTY: Self = Self {
        topology: Topology::EMPTY,
        node_count: 0,
        sample_count: 0,
        first_samples: <S::Cells<u16> as Storage<u16>>::EMPTY,
        per_element: 0,
        fineness: 0,
        every: 0,
        sharpest: T::ZERO,
        bluntest: T::ZERO,
        units: Units::NONE,
        softness: [T::ZERO; 2],
        sudden: (T::ZERO, [T::ZERO; 2]),
        softness_is_own: false,
        rubs: false,
        weight: <S::Nodes<T> as Storage<T>>::EMPTY,
        direction: <S::Nodes<[T; 2]> as Storage<[T; 2]>>::EMPTY,
        coupling: <S::Nodes<[T; 2]> as Storage<[T; 2]>>::EMPTY,
        diagonal: <S::Nodes<T> as Storage<T>>::EMPTY,
        fibre: <S::Nodes<T> as Storage<T>>::EMPTY,
        samples: <S::Samples<Sample<T>> as Storage<Sample<T>>>::EMPTY,
        buckling_loads: <S::Cells<T> as Storage<T>>::EMPTY,
        base: [T::ZERO; 2],
        base_rung: [T::ZERO; 2],
        clamps: [T::ZERO; 2],
        held: [T::ZERO; 2],
    };

    /// Forgets everything and makes room for the cells; false if there is none.
    pub(crate) fn reset(&mut self, cells: usize) -> bool {
        self.node_count = 0;
        self.sample_count = 0;
        self.weight.as_mut().fill(T::ZERO);
        self.coupling.as_mut().fill([T::ZERO; 2]);
        let fits = self.topology.reset(cells) && self.first_samples.fit(cells) && self.buckling_loads.fit(cells);
        self.buckling_loads.as_mut().fill(T::ZERO);
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

    /// Takes the unit of force of a step whose material has `stiffness` times the stiffness of a sudden one, and whose modulus is
    /// `modulus` times the design's (72). Returns the old unit as a part of the new one.
    pub(crate) fn stiffen(&mut self, stiffness: T, modulus: T) -> T {
        let (force, softness) = self.sudden;
        let old = self.units.force;
        self.units.force = force * (stiffness * modulus);
        // A softness in mm/N keeps its value; the beam's own is as much less as the modulus is more.
        let [asked, own] = softness;
        let own = own * stiffness;
        self.softness = [if self.softness_is_own { own } else { asked * (stiffness * modulus) }, own];
        old / self.units.force
    }

    /// Cells of the ladder; none before it was discretised.
    #[inline]
    pub(crate) fn cells(&self) -> usize {
        self.topology.cells
    }

    /// Number of unknowns of the condensed system.
    #[inline]
    pub(crate) fn unknowns(&self) -> usize {
        self.topology.unknowns()
    }

    /// All members: the front spans first.
    #[inline]
    pub(crate) fn members(&self) -> &[Member<T>] {
        self.topology.members()
    }

    /// A member by its index.
    #[inline]
    pub(crate) fn member(&self, index: usize) -> Option<&Member<T>> {
        self.topology.members.as_ref().get(index)
    }

    /// A member's constants.
    #[inline]
    pub(crate) fn constants<'a>(&'a self, member: &'a Member<T>) -> Option<Constants<'a, T>> {
        let (weight, coupling) =
            (self.weight.as_ref().get(member.nodes())?, self.coupling.as_ref().get(member.nodes())?);
        Some(Constants { member, weight, coupling })
    }

    /// Number of angles of the model (interior nodes and joints).
    pub fn angles(&self) -> usize {
        let interior: usize = self.members().iter().map(|m| usize::from(m.interior)).sum();
        interior + self.topology.joints()
    }

    /// Sets K's diagonal from the entries beside it, and what rounding may leave of the moments: an angle is known to a relative
    /// [`Real::EPSILON`], and a stiff member turns that into a moment that has no meaning.
    pub(crate) fn complete_stiffness(&mut self) {
        let Self { topology, diagonal, coupling, .. } = self;
        let count = topology.member_count();
        for member in topology.members.as_mut().run_mut(0..count) {
            let nodes = member.nodes();
            let diagonal = diagonal.as_mut().run_mut(nodes.clone());
            diagonal.fill(T::ZERO);
            for (node, &[next, after]) in coupling.as_ref().run(nodes).iter().enumerate() {
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
                    topology.rounding.as_mut().add(usize::from(joint), member.rounding);
                }
            }
        }
    }

    /// Sets the closures' constants so that the undeformed finger is closed in this precision.
    pub(crate) fn close_at_rest(&mut self) {
        let Self { topology, direction, weight, .. } = self;
        topology.close_at_rest(|member| {
            let mut sum = vec2_of(member.rigid_start) + vec2_of(member.rigid_end);
            for node in member.nodes() {
                sum += vec2_of(direction.as_ref().at(node)) * weight.as_ref().at(node);
            }
            [sum.x, sum.y]
        });
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
