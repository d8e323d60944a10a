//! Condensation of a member's interior onto its start joint a, end joint b and force (x, y).
//!
//! The interior block, K less the forces' geometric softening on its diagonal, has bandwidth 2 (`simpson`) or 1 and is
//! eliminated element by element. An interior block may be singular or indefinite on a healthy branch (the back beam's spans buckle between lamellae): its pivots are bounded away from zero,
//! which perturbs the step and not the solution, and its negative pivots are counted for the stability test.

use super::{MemberWork, Workspace};
use crate::ladder::Ladder;
use crate::real::Real;
use crate::size::{Blank, Size};

/// Condensed Hessian and gradient of a member in (a, b, x, y).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Condensed<T> {
    pub aa: T,
    pub ab: T,
    pub bb: T,
    /// Entries of a, of b and of the force with the force, and the correction of the end-to-end vector.
    pub ax: [T; 2],
    pub bx: [T; 2],
    pub xx: T,
    pub xy: T,
    pub yy: T,
    /// Corrections of the gradient at a, b and of the end-to-end vector.
    pub ra: T,
    pub rb: T,
    pub rx: [T; 2],
}

impl<T: Real> Blank for Condensed<T> {
    const BLANK: Self = Self {
        aa: T::ZERO,
        ab: T::ZERO,
        bb: T::ZERO,
        ax: [T::ZERO; 2],
        bx: [T::ZERO; 2],
        xx: T::ZERO,
        xy: T::ZERO,
        yy: T::ZERO,
        ra: T::ZERO,
        rb: T::ZERO,
        rx: [T::ZERO; 2],
    };
}

/// Smallest pivot, relative to the diagonal at rest. Square root of the precision: the perturbation costs the step and
/// the amplified rounding costs it about as many digits.
pub(crate) fn pivot_bound<T: Real>() -> T {
    T::of(4.0) * T::EPSILON.sqrt()
}

/// Pivot kept at least `least` away from zero, on its own side; true if it is negative.
#[inline]
pub(crate) fn bounded<T: Real>(pivot: T, least: T) -> (T, bool) {
    if pivot < T::ZERO { (pivot.min(-least), true) } else { (pivot.max(least), false) }
}

/// How a member's diagonal is made: curvature (true) or not (Gauss–Newton), and a shift relative to the diagonal at rest.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Diagonal<T> {
    pub curvature: T,
    pub shift: T,
}

/// Columns of a node: start joint, x and y of the force, gradient.
const A: usize = 0;
const X: usize = 1;
const Y: usize = 2;
const R: usize = 3;

/// Condenses one member; with it the number of negative pivots.
pub(crate) fn condense<T: Real, S: Size>(
    ladder: &Ladder<T, S>,
    work: &mut Workspace<T, S>,
    index: usize,
    diagonal: Diagonal<T>,
) -> (Condensed<T>, usize) {
    let member = &ladder.members.as_ref()[index];
    let nodes = member.nodes();
    let interior = usize::from(member.interior);
    let stiffening = T::one() + diagonal.shift;
    let at_rest = &ladder.diagonal.as_ref()[nodes.clone()];
    let coupling = super::coupling(ladder, work.coupling.as_ref(), work.curved, index);
    let lever = &work.lever.as_ref()[nodes.clone()];
    let gradient = &work.gradient.as_ref()[nodes.clone()];
    let curvature = &work.curvature.as_ref()[nodes.clone()];
    let factor = &mut work.factor.as_mut()[nodes];
    let out: &MemberWork<T> = &work.members.as_ref()[index];
    let bound = pivot_bound::<T>();
    let zero = T::ZERO;

    let own = |i: usize| at_rest[i] * stiffening - diagonal.curvature * curvature[i];
    let raw = |i: usize, a: T| [a, lever[i][0], lever[i][1], gradient[i]];
    let last = interior + 1;
    let mut negative = 0;
    // Border sums: everything with everything but the gradient with itself.
    let mut aa = own(0);
    let (mut ax, mut ay, mut ar) = (zero, zero, zero);
    let [mut xx, mut xy, mut yy] = out.give;
    let (mut xr, mut yr) = (zero, zero);

    let mut pivot = own(1);
    let mut near = coupling[1][0];
    let mut column = raw(1, coupling[0][0]);
    let mut next_pivot = zero;
    let mut next_column = [zero; 4];
    if last >= 2 {
        next_pivot = own(2);
        next_column = raw(2, coupling[0][1]);
    }
    for i in 1..=interior {
        let (p, is_negative) = bounded(pivot, bound * at_rest[i]);
        negative += usize::from(is_negative);
        let inverse = T::one() / p;
        let far = coupling[i][1];
        let (l1, l2) = (near * inverse, far * inverse);
        factor[i] = [inverse, l1, l2];
        let c = column;
        let scaled = [c[A] * inverse, c[X] * inverse, c[Y] * inverse];
        aa -= scaled[A] * c[A];
        ax -= scaled[A] * c[X];
        ay -= scaled[A] * c[Y];
        ar -= scaled[A] * c[R];
        xx -= scaled[X] * c[X];
        xy -= scaled[X] * c[Y];
        yy -= scaled[Y] * c[Y];
        xr -= scaled[X] * c[R];
        yr -= scaled[Y] * c[R];
        for k in [A, X, Y, R] {
            column[k] = next_column[k] - l1 * c[k];
        }
        pivot = next_pivot - l1 * near;
        if i + 2 <= last {
            near = coupling[i + 1][0] - l1 * far;
            next_pivot = own(i + 2);
            next_column = raw(i + 2, zero);
            if far != zero {
                next_pivot -= l2 * far;
                for k in [A, X, Y, R] {
                    next_column[k] -= l2 * c[k];
                }
            }
        }
    }
    // Now `pivot` and `column` are the end joint's. The joints' own entries:
    let (f, g) = (out.force, out.end_force);
    let (ra, rb) = (out.rigid_start, out.rigid_end);
    let start = raw(0, zero);
    let condensed = Condensed {
        aa: aa - diagonal.curvature * (f[0] * ra[0] + f[1] * ra[1]),
        ab: column[A],
        bb: pivot - diagonal.curvature * (g[0] * rb[0] + g[1] * rb[1]),
        ax: [ax + start[X] - ra[1], ay + start[Y] + ra[0]],
        bx: [column[X] - rb[1], column[Y] + rb[0]],
        xx,
        xy,
        yy,
        // The joints' full gradients are gathered elsewhere; these are the interior's corrections.
        ra: ar,
        rb: column[R] - gradient[last],
        rx: [xr, yr],
    };
    (condensed, negative)
}

/// Solves H z = r on a member's interior in place, with `after` the value of the end joint (0, or its step with the
/// right-hand side still lacking the end joint's coupling).
pub(crate) fn solve_interior<T: Real>(factor: &[[T; 3]], z: &mut [T], interior: usize, after: T) {
    for i in 2..=interior {
        let mut v = z[i] - factor[i - 1][1] * z[i - 1];
        if i >= 3 {
            v -= factor[i - 2][2] * z[i - 2];
        }
        z[i] = v;
    }
    z[interior + 1] = after;
    for i in (1..=interior).rev() {
        let mut v = z[i] * factor[i][0] - factor[i][1] * z[i + 1];
        if i + 2 <= interior + 1 {
            v -= factor[i][2] * z[i + 2];
        }
        z[i] = v;
    }
}
