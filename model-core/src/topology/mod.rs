//! Topology as data: joints, closures and members, in the order of elimination.
//!
//! A finger is a ladder: two beams, and rungs between them. Unknowns are changes of orientation θ from the undeformed shape. Members
//! that meet at a joint share its angle, so that only positions are left to close: the cell between two rungs closes when the vectors of
//! the members around it sum to a constant (6). Each closure has two multipliers λ, the internal force; a member carries the sum of
//! those of the closures that its vector enters, with their signs (15).
//!
//! The unknowns of the condensed system are numbered as they are eliminated (30): closure before the joints that it binds, cell by cell.
//! The solver reads places and signs from here; what a member is to a person ([`Role`]) it never asks.

mod rung;

use crate::access::Access;
use crate::linear::banded::BAND;
use crate::real::Real;
use crate::size::{Blank, Size, Storage};
pub(crate) use rung::{Part, Rung};

/// Unknown of a joint that does not turn: a beam's clamped base. Unknown 0 is a multiplier, never a joint; and a blank model is all zeros,
/// so that a static one needs no image in flash.
pub(crate) const CLAMPED: u16 = 0;

/// What a member is to the reader of a result. Spans and rungs are counted from 0 at the base.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    /// A span of the front beam.
    Front(u8),
    /// A span of the back beam.
    Back(u8),
    /// A part of a rung, counted from its front end.
    Rung(u8, u8),
    /// The gap between a rung's free end and the back beam.
    Gap(u8),
}

impl Role {
    /// Span or rung.
    pub fn cell(self) -> u8 {
        match self {
            Self::Front(cell) | Self::Back(cell) | Self::Rung(cell, _) | Self::Gap(cell) => cell,
        }
    }
}

/// What a member is made of (see `element`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Quadratic elements: their ends and middles are its nodes.
    #[default]
    Quadratic,
    /// Rigid links between springs.
    Link,
    /// None: a gap, across which a rung's free end is kept from passing.
    Gap,
}

/// A closure that a member's vector enters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Term<T> {
    /// Index of the closure.
    pub closure: u16,
    /// Unknown of its λx; that of λy follows.
    pub unknown: u16,
    /// With which the vector enters it, and its λ the member's force: 1 or −1.
    pub sign: T,
}

/// A run of nodes between two joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Member<T> {
    pub role: Role,
    pub kind: Kind,
    /// First node: the start joint's. The interior nodes follow, then the end joint's.
    pub first: u16,
    /// Number of interior nodes.
    pub interior: u16,
    /// Unknown of the start joint, or [`CLAMPED`].
    pub start: u16,
    /// Unknown of the end joint: that of the start joint, or a later one.
    pub end: u16,
    /// The closures that its vector enters, and how many they are.
    pub terms: [Term<T>; 2],
    pub term_count: u16,
    /// Rigid part that turns with the start joint, undeformed, mm.
    pub rigid_start: [T; 2],
    /// Rigid part that turns with the end joint, undeformed, mm.
    pub rigid_end: [T; 2],
    /// 1/EA and 1/κGA, 1/N: stretch and shear per force; 0 for an inextensible, shear-stiff member.
    pub compliance: [T; 2],
    /// 3c/EA, 1/N: growth of the bending stiffness per force that stretches the member; 0 where it is constant.
    pub stiffening: T,
    /// What rounding its angles may leave of a gradient component, N·mm.
    pub rounding: T,
}

impl<T: Real> Member<T> {
    /// Indices of all its nodes, both joints' included.
    #[inline]
    pub fn nodes(&self) -> core::ops::Range<usize> {
        usize::from(self.first)..usize::from(self.first) + usize::from(self.interior) + 2
    }

    /// A part of a rung that leads from back to front, as its back end does not turn.
    pub fn is_backwards(&self) -> bool {
        matches!(self.role, Role::Rung(..)) && self.terms[0].sign < T::ZERO
    }

    /// The closures that its vector enters.
    #[inline]
    pub fn terms(&self) -> &[Term<T>] {
        self.terms.get(..usize::from(self.term_count)).unwrap_or(&self.terms)
    }

    /// Unknown of λx of the first of them.
    #[inline]
    pub fn force_unknown(&self) -> usize {
        usize::from(self.terms[0].unknown)
    }
}

impl<T: Real> Blank for Member<T> {
    const BLANK: Self = Self {
        role: Role::Front(0),
        kind: Kind::Quadratic,
        first: 0,
        interior: 0,
        start: CLAMPED,
        end: CLAMPED,
        terms: [Term { closure: 0, unknown: 0, sign: T::ZERO }; 2],
        term_count: 0,
        rigid_start: [T::ZERO; 2],
        rigid_end: [T::ZERO; 2],
        compliance: [T::ZERO; 2],
        stiffening: T::ZERO,
        rounding: T::ZERO,
    };
}

/// Members whose vectors sum to a constant: two equations, two multipliers λ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Closure<T> {
    /// Unknown of λx; that of λy follows.
    pub unknown: u16,
    /// The constant, mm: the sum in the undeformed shape.
    pub rest: [T; 2],
}

impl<T: Real> Blank for Closure<T> {
    const BLANK: Self = Self { unknown: 0, rest: [T::ZERO; 2] };
}

/// Joints, closures and members of a finger.
pub(crate) struct Topology<T: Real, S: Size> {
    /// Cells of the ladder: each has a closure, a front span and a back span.
    pub cells: usize,
    closure_count: usize,
    member_count: usize,
    unknowns: usize,
    /// Rungs that end with a gap.
    pub gaps: usize,
    /// The front spans, base to tip, as contacts act on them; then all others, cell by cell.
    pub members: S::Members<Member<T>>,
    closures: S::Cells<Closure<T>>,
    /// Magnitude of each diagonal entry of the condensed system at rest: bounds its pivots.
    pub scale: S::Unknowns<T>,
    /// What rounding the angles may leave of a joint's gradient, N·mm; 0 at the closures.
    pub rounding: S::Unknowns<T>,
}

impl<T: Real, S: Size> Topology<T, S> {
    pub const EMPTY: Self = Self {
        cells: 0,
        closure_count: 0,
        member_count: 0,
        unknowns: 0,
        gaps: 0,
        members: <S::Members<Member<T>> as Storage<Member<T>>>::EMPTY,
        closures: <S::Cells<Closure<T>> as Storage<Closure<T>>>::EMPTY,
        scale: <S::Unknowns<T> as Storage<T>>::EMPTY,
        rounding: <S::Unknowns<T> as Storage<T>>::EMPTY,
    };

    /// Forgets everything and makes room for so many cells; false if there is none.
    pub fn reset(&mut self, cells: usize) -> bool {
        (self.cells, self.closure_count, self.member_count, self.unknowns, self.gaps) = (0, 0, 0, 0, 0);
        // A cell has two spans, and but for the tip's a rung of at most two members and three joints.
        let fits = cells == 0
            || cells <= usize::from(u8::MAX)
                && self.members.fit(4 * cells - 2)
                && self.closures.fit(cells)
                && self.scale.fit(5 * cells - 2)
                && self.rounding.fit(5 * cells - 2);
        if fits {
            (self.cells, self.member_count) = (cells, cells);
            self.members.as_mut().fill(Member::BLANK);
            self.scale.as_mut().fill(T::ZERO);
            self.rounding.as_mut().fill(T::ZERO);
        }
        fits
    }

    /// Numbers the next closure's unknowns; returns its index.
    pub fn add_closure(&mut self) -> u16 {
        let index = self.closure_count;
        self.closures.as_mut().put(index, Closure { unknown: self.unknowns as u16, rest: [T::ZERO; 2] });
        self.closure_count += 1;
        self.unknowns += 2;
        index as u16
    }

    /// Numbers the next joint's unknown.
    pub fn add_joint(&mut self) -> u16 {
        self.unknowns += 1;
        (self.unknowns - 1) as u16
    }

    /// Adds a member between two joints whose vector enters closures with these signs. Returns its index, or nothing if there is no room.
    pub fn add_member(&mut self, mut member: Member<T>, entered: &[(u16, f64)]) -> Option<usize> {
        for (term, &(closure, sign)) in member.terms.iter_mut().zip(entered) {
            let unknown = self.closures.as_ref().get(usize::from(closure))?.unknown;
            *term = Term { closure, unknown, sign: T::of(sign) };
        }
        member.term_count = entered.len() as u16;
        let index = match member.role {
            Role::Front(span) => usize::from(span),
            _ => {
                self.member_count += 1;
                self.member_count - 1
            }
        };
        *self.members.as_mut().get_mut(index)? = member;
        self.gaps += usize::from(member.kind == Kind::Gap);
        Some(index)
    }

    /// No two unknowns of a member lie further apart than the band of the factorisation.
    pub fn fits_the_band(&self) -> bool {
        self.members().iter().all(|member| {
            let joints = [member.start, member.end].into_iter().filter(|&joint| joint != CLAMPED);
            let unknowns = joints.chain(member.terms().iter().flat_map(|term| [term.unknown, term.unknown + 1]));
            let (least, most) = unknowns.fold((u16::MAX, 0), |(least, most), at| (least.min(at), most.max(at)));
            usize::from(most.saturating_sub(least)) <= BAND
        })
    }

    /// Number of unknowns of the condensed system.
    #[inline]
    pub fn unknowns(&self) -> usize {
        self.unknowns
    }

    /// Number of joints that turn.
    pub fn joints(&self) -> usize {
        self.unknowns - 2 * self.closure_count
    }

    #[inline]
    pub fn member_count(&self) -> usize {
        self.member_count
    }

    /// All members: the front spans first.
    #[inline]
    pub fn members(&self) -> &[Member<T>] {
        self.members.as_ref().get(..self.member_count).unwrap_or(&[])
    }

    /// The front spans, base to tip.
    #[inline]
    pub fn fronts(&self) -> &[Member<T>] {
        self.members.as_ref().get(..self.cells).unwrap_or(&[])
    }

    /// The closures, base to tip.
    #[inline]
    pub fn closures(&self) -> &[Closure<T>] {
        self.closures.as_ref().get(..self.closure_count).unwrap_or(&[])
    }

    /// Index of the member with a role.
    pub fn find(&self, role: Role) -> Option<usize> {
        self.members().iter().position(|member| member.role == role)
    }

    /// By how much less than between clamped ends a rung buckles: one whose end is free before the back beam, a sixteenth of the load.
    pub fn eased(&self, rung: u8) -> f64 {
        if self.gaps > 0 && self.find(Role::Gap(rung)).is_some() { 16.0 } else { 1.0 }
    }

    /// Indices of the members in the order in which a person counts them: cell by cell, front span, back span, rung.
    pub fn in_cells(&self) -> impl Iterator<Item = usize> + '_ {
        let members = move || self.members().iter().enumerate();
        (0..self.cells).flat_map(move |cell| {
            members().filter(move |(_, member)| usize::from(member.role.cell()) == cell).map(|(index, _)| index)
        })
    }

    /// Adds a member's vector, mm, to the closures that it enters.
    #[inline(always)]
    pub fn enter(&self, sums: &mut [[T; 2]], member: &Member<T>, [x, y]: [T; 2]) {
        for term in member.terms() {
            if let Some(sum) = sums.get_mut(usize::from(term.closure)) {
                *sum = [sum[0] + term.sign * x, sum[1] + term.sign * y];
            }
        }
    }

    /// Makes the closures' errors (6) of the sums of all members' vectors, mm.
    #[inline]
    pub fn finish_closures(&self, sums: &mut [[T; 2]]) {
        for (sum, closure) in sums.iter_mut().zip(self.closures()) {
            *sum = [sum[0] - closure.rest[0], sum[1] - closure.rest[1]];
        }
    }

    /// Sets the closures' constants from the members' undeformed vectors.
    pub fn close_at_rest(&mut self, vectors: impl Fn(&Member<T>) -> [T; 2]) {
        for at in 0..self.closure_count {
            let mut sum = [T::ZERO; 2];
            for member in self.members() {
                let [x, y] = vectors(member);
                for term in member.terms().iter().filter(|term| usize::from(term.closure) == at) {
                    sum = [sum[0] + term.sign * x, sum[1] + term.sign * y];
                }
            }
            if let Some(closure) = self.closures.as_mut().get_mut(at) {
                closure.rest = sum;
            }
        }
    }

    /// Adds a member's share to the magnitude that each diagonal entry of the condensed system has at rest, from its
    /// bending stiffness EI/L (N·mm) and length L (mm): 4 EI/L at a joint, L³/(12 EI) at a closure. Enough to tell a
    /// vanishing pivot from a small one.
    pub fn add_scale(&mut self, index: usize, stiffness: f64, length: f64) {
        let member = self.members.as_ref().at(index);
        let scale = self.scale.as_mut();
        let joint = T::of(4.0 * stiffness);
        if member.start != CLAMPED {
            scale.add(usize::from(member.start), joint);
        }
        scale.add(usize::from(member.end), joint);
        let flexibility = if stiffness > 0.0 { T::of(length * length / (12.0 * stiffness)) } else { T::ZERO };
        for term in member.terms() {
            scale.add(usize::from(term.unknown), flexibility);
            scale.add(usize::from(term.unknown) + 1, flexibility);
        }
    }
}
