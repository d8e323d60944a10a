//! Condensation of a member's interior onto its start joint a, end joint b and force (x, y).
//!
//! The interior block K − σ diag(v·e) has bandwidth 2 (`simpson`) or 1 and is eliminated element by element; the stretch
//! goes through the elimination as one more column and is then eliminated itself. An interior block may be singular or
//! indefinite on a healthy branch (the back beam's spans buckle between lamellae): its pivots are bounded away from zero,
//! which perturbs the step and not the solution, and its negative pivots are counted for the stability test.

use super::{MemberWork, Workspace};
use crate::ladder::{Ladder, Member};
use crate::real::Real;
use crate::size::Size;

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
    /// The stretch's row: inverse pivot (0 for an inextensible member), entries with a, b, x, y, and gradient.
    pub s_inverse: T,
    pub sa: T,
    pub sb: T,
    pub sx: [T; 2],
    pub sr: T,
}

impl<T: Real> Condensed<T> {
    pub(crate) const ZERO: Self = Self {
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
        s_inverse: T::ZERO,
        sa: T::ZERO,
        sb: T::ZERO,
        sx: [T::ZERO; 2],
        sr: T::ZERO,
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

/// Condenses one member; returns the number of negative pivots.
pub(crate) fn condense<T: Real, S: Size>(
    ladder: &Ladder<T, S>,
    work: &mut Workspace<T, S>,
    index: usize,
    stretch: T,
    diagonal: Diagonal<T>,
) -> usize {
    let member = ladder.members.as_ref()[index];
    if member.axial > T::ZERO {
        eliminate::<T, S, true>(ladder, work, index, &member, stretch, diagonal)
    } else {
        eliminate::<T, S, false>(ladder, work, index, &member, stretch, diagonal)
    }
}

/// Raw columns of a node: a, s, x, y, gradient.
const A: usize = 0;
const STRETCH: usize = 1;
const X: usize = 2;
const Y: usize = 3;
const R: usize = 4;

fn eliminate<T: Real, S: Size, const EXTENSIBLE: bool>(
    ladder: &Ladder<T, S>,
    work: &mut Workspace<T, S>,
    index: usize,
    member: &Member<T>,
    stretch: T,
    diagonal: Diagonal<T>,
) -> usize {
    let nodes = member.nodes();
    let interior = usize::from(member.interior);
    let sigma = T::one() + stretch;
    let softening = sigma * diagonal.curvature;
    let stiffening = T::one() + diagonal.shift;
    let weight = &ladder.weight.as_ref()[nodes.clone()];
    let coupling = &ladder.coupling.as_ref()[nodes.clone()];
    let e = &work.e.as_ref()[nodes.clone()];
    let push = &work.push.as_ref()[nodes.clone()];
    let gradient = &work.gradient.as_ref()[nodes.clone()];
    let curvature = &work.curvature.as_ref()[nodes.clone()];
    let factor = &mut work.factor.as_mut()[nodes];
    let out: &mut MemberWork<T> = &mut work.members.as_mut()[index];
    let bound = pivot_bound::<T>();
    let zero = T::ZERO;

    let springs = |i: usize| {
        let mut sum = coupling[i][0] + coupling[i][1];
        if i >= 1 {
            sum += coupling[i - 1][0];
        }
        if i >= 2 {
            sum += coupling[i - 2][1];
        }
        -sum
    };
    let raw = |i: usize, a: T| {
        let scaled = sigma * weight[i];
        [a, if EXTENSIBLE { push[i] } else { zero }, -scaled * e[i][1], scaled * e[i][0], gradient[i]]
    };
    let last = interior + 1;
    let mut negative = 0;
    // Border sums: everything with everything but the gradient with itself.
    let mut aa = springs(0) * stiffening - softening * curvature[0];
    let (mut a_s, mut ax, mut ay, mut ar) = (zero, zero, zero, zero);
    let (mut ss, mut sx, mut sy, mut sr) = (zero, zero, zero, zero);
    let (mut xx, mut xy, mut yy, mut xr, mut yr) = (zero, zero, zero, zero, zero);

    let mut pivot = springs(1) * stiffening - softening * curvature[1];
    let mut near = coupling[1][0];
    let mut column = raw(1, coupling[0][0]);
    let mut next_pivot = zero;
    let mut next_column = [zero; 5];
    if last >= 2 {
        next_pivot = springs(2) * stiffening - softening * curvature[2];
        next_column = raw(2, coupling[0][1]);
    }
    for i in 1..=interior {
        let (p, is_negative) = bounded(pivot, bound * springs(i));
        negative += usize::from(is_negative);
        let inverse = T::one() / p;
        let far = coupling[i][1];
        let (l1, l2) = (near * inverse, far * inverse);
        factor[i] = [inverse, l1, l2];
        let c = column;
        let scaled = [c[A] * inverse, c[STRETCH] * inverse, c[X] * inverse, c[Y] * inverse];
        aa -= scaled[A] * c[A];
        ax -= scaled[A] * c[X];
        ay -= scaled[A] * c[Y];
        ar -= scaled[A] * c[R];
        xx -= scaled[X] * c[X];
        xy -= scaled[X] * c[Y];
        yy -= scaled[Y] * c[Y];
        xr -= scaled[X] * c[R];
        yr -= scaled[Y] * c[R];
        if EXTENSIBLE {
            a_s -= scaled[A] * c[STRETCH];
            ss -= scaled[STRETCH] * c[STRETCH];
            sx -= scaled[STRETCH] * c[X];
            sy -= scaled[STRETCH] * c[Y];
            sr -= scaled[STRETCH] * c[R];
        }
        for k in [A, X, Y, R] {
            column[k] = next_column[k] - l1 * c[k];
        }
        if EXTENSIBLE {
            column[STRETCH] = next_column[STRETCH] - l1 * c[STRETCH];
        }
        pivot = next_pivot - l1 * near;
        if i + 2 <= last {
            near = coupling[i + 1][0] - l1 * far;
            next_pivot = springs(i + 2) * stiffening - softening * curvature[i + 2];
            next_column = raw(i + 2, zero);
            if far != zero {
                next_pivot -= l2 * far;
                for k in [A, STRETCH, X, Y, R] {
                    next_column[k] -= l2 * c[k];
                }
            }
        }
    }
    // Now `pivot` and `column` are the end joint's. The joints' own entries:
    let (f, g) = (out.force, out.end_force);
    let (ra, rb) = (out.rigid_start, out.rigid_end);
    aa -= diagonal.curvature * (f[0] * ra[0] + f[1] * ra[1]);
    let bb = pivot - diagonal.curvature * (g[0] * rb[0] + g[1] * rb[1]);
    let start = raw(0, zero);
    let mut c = Condensed {
        aa,
        ab: column[A],
        bb,
        ax: [ax + start[X] - ra[1], ay + start[Y] + ra[0]],
        bx: [column[X] - rb[1], column[Y] + rb[0]],
        xx,
        xy,
        yy,
        // The joints' full gradients are gathered elsewhere; these are the interior's corrections.
        ra: ar,
        rb: column[R] - gradient[last],
        rx: [xr, yr],
        ..Condensed::ZERO
    };
    if EXTENSIBLE {
        let (p, is_negative) = bounded(member.axial * stiffening + ss, bound * member.axial);
        negative += usize::from(is_negative);
        c.s_inverse = T::one() / p;
        c.sa = a_s + push[0];
        c.sb = column[STRETCH];
        c.sx = [sx + out.chord[0], sy + out.chord[1]];
        c.sr = sr + out.stretch_gradient;
        let (a, b) = (c.sa * c.s_inverse, c.sb * c.s_inverse);
        let x = c.sx.map(|v| v * c.s_inverse);
        c.aa -= a * c.sa;
        c.ab -= a * c.sb;
        c.bb -= b * c.sb;
        for k in 0..2 {
            c.ax[k] -= a * c.sx[k];
            c.bx[k] -= b * c.sx[k];
            c.rx[k] -= x[k] * c.sr;
        }
        c.xx -= x[0] * c.sx[0];
        c.xy -= x[0] * c.sx[1];
        c.yy -= x[1] * c.sx[1];
        c.ra -= a * c.sr;
        c.rb -= b * c.sr;
    }
    out.condensed = c;
    negative
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
