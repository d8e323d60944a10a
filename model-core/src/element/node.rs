//! A node: its strained direction, and what the force through it does (18)–(21).

use super::Past;
use crate::real::Real;
use crate::size::Blank;

/// A node while a step is made: one run of numbers, as the loops over a member's nodes need most of them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node<T> {
    /// Direction e(β+θ).
    pub e: [T; 2],
    /// Strained direction d: the node's weight times d is its part of the end-to-end vector.
    pub strained: [T; 2],
    /// Derivative of the member's end-to-end vector with respect to the node's angle, mm.
    pub lever: [T; 2],
    /// Of the element or spring that begins at the node: t ∂(½q)/∂θ of its start, at a quadratic element's middle that of its
    /// end, mm; and the shortening η that the node carries (see [`super`]).
    pub bent: [T; 2],
    /// One place for two things that are never needed together: [`Self::pull`] from the walk to the bending moments, [`Self::coupling`]
    /// from there on.
    either: [T; 2],
    /// Gradient of the Lagrangian, N·mm.
    pub gradient: T,
    /// Geometric softening, N·mm: what the force takes from the diagonal of K.
    pub curvature: T,
}

impl<T: Real> Blank for Node<T> {
    const BLANK: Self = Self {
        e: [T::ZERO; 2],
        strained: [T::ZERO; 2],
        lever: [T::ZERO; 2],
        bent: [T::ZERO; 2],
        either: [T::ZERO; 2],
        gradient: T::ZERO,
        curvature: T::ZERO,
    };
}

impl<T: Real> Node<T> {
    /// Second derivatives towards the next node and the one after it, N·mm: the model's, or as the stretch has made them.
    #[inline(always)]
    pub fn coupling(&self) -> [T; 2] {
        self.either
    }

    #[inline(always)]
    pub(super) fn set_coupling(&mut self, coupling: [T; 2]) {
        self.either = coupling;
    }

    /// Second derivative towards the next node where that is the only one: of a link.
    #[inline(always)]
    pub(super) fn set_next_coupling(&mut self, coupling: T) {
        self.either[0] = coupling;
    }

    /// Forces f·e and f·e′ that a walk has left: those that soften a quadratic element whose middle the node is, N.
    #[inline(always)]
    pub(super) fn pull(&self) -> [T; 2] {
        self.either
    }

    #[inline(always)]
    pub(super) fn set_pull(&mut self, pull: [T; 2]) {
        self.either = pull;
    }
}

/// What a force does to a link or node of weight w and direction e that bending shortens by η.
///
/// With f the force per weight, a = f·e, b = f·e′, k = 1/EA − 1/κGA: ψ = (1 − η) a − ½(a²/EA + b²/κGA), d = ∂ψ/∂f, and the node
/// adds w ψ to the Lagrangian. What the past adds to a and b where they strain the node comes along and across (73).
pub(super) struct Strained<T> {
    /// Strained direction d, and w times its derivative with respect to the angle.
    pub direction: [T; 2],
    pub lever: [T; 2],
    /// First derivative of w ψ with respect to the angle, and the second with its sign changed, N·mm.
    pub gradient: T,
    pub curvature: T,
    /// f·e, what the past adds included, and f·e′.
    pub pull: [T; 2],
}

#[inline(always)]
pub(super) fn strained<T: Real, P: Past<T>, const RIGID: bool>(
    e: [T; 2],
    w: T,
    force: [T; 2],
    [stretch, shear]: [T; 2],
    shorter: T,
    [along, across]: [T; 2],
) -> Strained<T> {
    let [x, y] = e;
    let a = force[0] * x + force[1] * y;
    let b = force[1] * x - force[0] * y;
    if RIGID {
        let lever = [-(w * y), w * x];
        return Strained { direction: e, lever, gradient: w * b, curvature: w * a, pull: [a, b] };
    }
    let whole = T::one() - shorter;
    if P::IS_ANY {
        let (pulled, sheared) = (a + along, b + across);
        let (p, q) = (whole - stretch * pulled, shear * sheared);
        let (r, t) = (p + shear * a, stretch * b - q);
        let (wx, wy) = (w * x, w * y);
        return Strained {
            direction: [x * p + y * q, y * p - x * q],
            lever: [-(wy * r + wx * t), wx * r - wy * t],
            gradient: w * (b * p + a * q),
            curvature: w * (a * r + b * t),
            pull: [pulled, b],
        };
    }
    let k = stretch - shear;
    let (p, q) = (whole - stretch * a, shear * b);
    let (r, t) = (whole - k * a, k * b);
    let (wx, wy) = (w * x, w * y);
    Strained {
        direction: [x * p + q * y, y * p - q * x],
        lever: [-(wy * r + wx * t), wx * r - wy * t],
        gradient: w * b * r,
        curvature: w * (a * r + b * t),
        pull: [a, b],
    }
}
