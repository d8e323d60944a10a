//! Elements: what a force does to a member between two joints, and what the member's angles do against it.
//!
//! [`Element`] is the one interface; [`Quadratic`] (`simpson`), [`Link`] (`paper`, `trapezoid`) and [`EndGap`] (no element) are behind it. A
//! member is asked for its kind once; the loops over its nodes know theirs. All that is here sees one member at a time, as runs of one
//! length per node: no finger, no closures.
//!
//! Bending: a fibre at nominal strain u stores ½E(u² + c u³) per volume (see [`crate::design::MaterialLaw`]). Over a section of area A
//! and second moment I, bent by κ and stretched by ε, that is ½EA ε² + ½EI κ² (1 + 3c ε) up to third order: the bending
//! stiffness follows the stretch. With ε = −(f·e)/EA for the force f (in the Lagrangian's sign) an element of bending energy
//! ½q(θ) adds ½q (1 − t f·e), t = 3c/EA, with e the direction of the element's middle node, its carrier; for the schemes of
//! links the carrier is the link above the spring, or below it where there is none above (17).
//!
//! Being linear in f, the term is an end-to-end vector shorter by ½ t q along e: a bent element is shorter by η = ½ t q/w per
//! weight w of its carrier. Under compression the element is softer: what makes a back beam buckle as finite elements say.

mod end_gap;
mod kind;
mod link;
mod node;
mod past;
mod pull;
mod quadratic;

use crate::contact::{Row, Sample};
use crate::real::Real;
use crate::size::Blank;
use crate::topology::Member;
pub(crate) use end_gap::EndGap;
pub(crate) use link::Link;
pub(crate) use node::Node;
pub(crate) use past::{NoPast, Past, Remembered, Trace};
pub(crate) use pull::Pull;
pub(crate) use quadratic::{Quadratic, hermite_weights};

/// How much a walk over a member finds. What it does not find stays as it was.
pub(crate) trait Depth {
    /// Bending moments and the gradient.
    const GRADIENT: bool;
    /// Second derivatives, levers and the compliance of the force with itself.
    const TANGENT: bool;
}

/// Strained directions and the chord.
pub(crate) struct Places;
/// Those and the gradient.
pub(crate) struct Residuals;
/// Those and the second derivatives.
pub(crate) struct Tangents;

impl Depth for Places {
    const GRADIENT: bool = false;
    const TANGENT: bool = false;
}

impl Depth for Residuals {
    const GRADIENT: bool = true;
    const TANGENT: bool = false;
}

impl Depth for Tangents {
    const GRADIENT: bool = true;
    const TANGENT: bool = true;
}

/// A member's constants: runs of one length, an entry per node.
#[derive(Clone, Copy)]
pub(crate) struct Constants<'a, T> {
    pub member: &'a Member<T>,
    /// Weight of a node's direction in the end-to-end vector, mm.
    pub weight: &'a [T],
    /// Entries of the energy matrix K towards the next node and the one after, N·mm.
    pub coupling: &'a [[T; 2]],
}

/// A member under its force.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Strain<T> {
    /// Σ lᵢ dᵢ, mm.
    pub chord: [T; 2],
    /// Rigid parts, turned, mm.
    pub rigid_start: [T; 2],
    pub rigid_end: [T; 2],
    /// Force f that multiplies the member's end-to-end vector in the Lagrangian, N.
    pub force: [T; 2],
    /// Force that turns the rigid end, N (less than `force` where a contact acts on it).
    pub end_force: [T; 2],
    /// −Σ lᵢ Cᵢ with C = e eᵀ/EA + e′e′ᵀ/κGA: entries xx, xy, yy of the force with itself, mm/N.
    pub compliance: [T; 3],
    /// Largest gradient component of the interior nodes of a chain of links, N·mm.
    pub steepest: T,
}

impl<T: Real> Strain<T> {
    /// End-to-end vector Σ l d + rigid parts, mm.
    #[inline]
    pub fn end_to_end(&self) -> [T; 2] {
        [
            self.chord[0] + self.rigid_start[0] + self.rigid_end[0],
            self.chord[1] + self.rigid_start[1] + self.rigid_end[1],
        ]
    }
}

impl<T: Real> Blank for Strain<T> {
    const BLANK: Self = Self {
        chord: [T::ZERO; 2],
        rigid_start: [T::ZERO; 2],
        rigid_end: [T::ZERO; 2],
        force: [T::ZERO; 2],
        end_force: [T::ZERO; 2],
        compliance: [T::ZERO; 3],
        steepest: T::ZERO,
    };
}

/// The mechanics of a member's elements. [`Kind`](crate::topology::Kind) asks those of a member.
pub(crate) trait Element<T: Real> {
    /// A walk as deep as [`Residuals`] leaves the second derivatives of an earlier state.
    const SPARES_TANGENT: bool;

    /// Walks from the member's end to its start under the force through each node (15): strained directions and the chord (20), and as
    /// deep as asked the force's part of the gradient (19) and of the second derivatives (21). `rows` touch the member, base to tip.
    fn walk<D: Depth, P: Past<T>>(
        of: Constants<'_, T>,
        past: P,
        angle: &[T],
        rows: &[Row<T>],
        nodes: &mut [Node<T>],
        out: &mut Strain<T>,
    );

    /// Adds the bending moments to the gradient (23), and completes the second derivatives.
    fn bend(of: Constants<'_, T>, angle: &[T], nodes: &mut [Node<T>], out: &mut Strain<T>);

    /// Derivatives of a sample's position with respect to the angles of three nodes, from `first` on, the sample's own: its element's,
    /// where it has weights of its own and its share of the shortening, mm.
    fn lever(of: Constants<'_, T>, first: usize, sample: &Sample<T>, nodes: &[Node<T>]) -> [[T; 2]; 3];

    /// First node and weights of a place short of a sample, at ξ of its element or link: 0 … 1. `weight` is that of all nodes, `first` the
    /// member's first one.
    fn between(weight: &[T], first: u16, sample: &Sample<T>, xi: T) -> (u16, [T; 3]);

    /// By how much the section at a place, at ξ of its element or link, turns with each of three nodes; and the first of these, from the
    /// place's own on.
    fn turns(place: &Sample<T>, xi: T) -> (usize, [T; 3]);

    /// Stretch and bend of a section that is strained, counted from the member's start: of a spring, or of an end of an element, two ends to
    /// an element. `stretch` is that of a node's direction.
    fn section(angle: &[T], stretch: impl Fn(usize) -> T, section: usize) -> (T, T);

    /// Arc from the member's start to that section, mm.
    fn arc(weight: &[T], section: usize) -> T;

    /// The point of the deformed centreline that belongs to a node after the first: the end of a link, the middle or the end of an element;
    /// none of a node that has no length. `at` is the end of the link or element before, and moves on; `strained` is a node's direction.
    fn point(weight: &[T], strained: impl Fn(usize) -> [T; 2], node: usize, at: &mut [T; 2]) -> Option<[T; 2]>;

    /// As [`Self::point`] from the member's end to its start: the point before a node's link, or in the middle or at the start of its element.
    fn point_back(weight: &[T], strained: impl Fn(usize) -> [T; 2], node: usize, at: &mut [T; 2]) -> Option<[T; 2]>;
}
