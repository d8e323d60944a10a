//! Condensation of a member's interior onto its start joint a, end joint b and force (x, y).
//!
//! The interior block, K less the forces' geometric softening on its diagonal, has bandwidth 2 (`simpson`) or 1 and is
//! eliminated element by element. An interior block may be singular or indefinite on a healthy branch (the back beam's spans buckle
//! between lamellae): its pivots are bounded away from zero, which perturbs the step and not the solution, and its negative pivots
//! are counted for the stability test.

use super::condensed::{Condensed, Corrections};
use crate::access::Access;
use crate::element::{Node, Strain};
use crate::linear::pivot::{bounded, pivot_bound};
use crate::real::Real;
use crate::size::Blank;
use crate::topology::{Kind, Member};

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

/// What the interior leaves of a member's own entries: those of the start joint with itself, the force and the gradient, and
/// those of the force with itself (xx, xy, yy) and the gradient (x, y).
struct Sums<T> {
    start: [T; 4],
    force: [T; 5],
}

impl<T: Real> Sums<T> {
    /// Takes a node out whose column is c.
    #[inline(always)]
    fn take(&mut self, c: [T; 4], inverse: T) {
        let scaled = [c[A] * inverse, c[X] * inverse, c[Y] * inverse];
        for k in [A, X, Y, R] {
            self.start[k] -= scaled[A] * c[k];
        }
        let products = [scaled[X] * c[X], scaled[X] * c[Y], scaled[Y] * c[Y], scaled[X] * c[R], scaled[Y] * c[R]];
        for (sum, product) in self.force.iter_mut().zip(products) {
            *sum -= product;
        }
    }
}

/// A member at the evaluated state: runs of one length, an entry per node.
#[derive(Clone, Copy)]
pub(super) struct Interior<'a, T> {
    pub member: &'a Member<T>,
    pub out: &'a Strain<T>,
    /// Diagonal of the energy matrix K, and its entries towards the next node and the one after, N·mm.
    pub at_rest: &'a [T],
    pub constant: &'a [[T; 2]],
    pub nodes: &'a [Node<T>],
    /// The nodes' coupling counts, not the constant one.
    pub curved: bool,
}

/// Condenses a member, whose interior's factors it leaves; with it the number of negative pivots.
pub(super) fn condense<T: Real>(
    of: Interior<'_, T>,
    factors: &mut [[T; 3]],
    diagonal: Diagonal<T>,
) -> (Condensed<T>, usize) {
    if of.member.kind == Kind::Quadratic {
        condense_band::<T, true>(of, factors, diagonal)
    } else {
        condense_band::<T, false>(of, factors, diagonal)
    }
}

/// As [`condense`], the interior's bandwidth being 2 (`WIDE`) or 1.
fn condense_band<T: Real, const WIDE: bool>(
    of: Interior<'_, T>,
    factors: &mut [[T; 3]],
    diagonal: Diagonal<T>,
) -> (Condensed<T>, usize) {
    let Interior { member, out, curved, .. } = of;
    let count = usize::from(member.interior) + 2;
    let stiffening = T::one() + diagonal.shift;
    // All of one length, which the indices below stay within.
    let (Some(at_rest), Some(constant), Some(list), Some(factors)) =
        (of.at_rest.get(..count), of.constant.get(..count), of.nodes.get(..count), factors.get_mut(..count))
    else {
        return (Condensed::BLANK, 0);
    };
    let coupling = |i: usize, node: &Node<T>| if curved { node.coupling() } else { constant.at(i) };
    let bound = pivot_bound::<T>();
    let zero = T::ZERO;

    let own = |rest: T, node: &Node<T>| rest * stiffening - diagonal.curvature * node.curvature;
    let raw = |node: &Node<T>, a: T| [a, node.lever[0], node.lever[1], node.gradient];
    let mut negative = 0;
    let [start, first, ..] = list else { return (Condensed::BLANK, 0) };
    let from_start = coupling(0, start);
    let [xx, xy, yy] = out.compliance;
    let mut sums = Sums { start: [own(at_rest.at(0), start), zero, zero, zero], force: [xx, xy, yy, zero, zero] };

    let (mut pivot, mut column);
    if WIDE {
        pivot = own(at_rest.at(1), first);
        column = raw(first, from_start[0]);
        let mut coupled = coupling(1, first);
        let mut near = coupled[0];
        let mut next_pivot = zero;
        let mut next_column = [zero; 4];
        if let Some(second) = list.get(2) {
            next_pivot = own(at_rest.at(2), second);
            next_column = raw(second, from_start[1]);
        }
        for i in 1..count - 1 {
            let Some(&least) = at_rest.get(i) else { break };
            let (p, is_negative) = bounded(pivot, bound * least);
            negative += usize::from(is_negative);
            let inverse = T::one() / p;
            let far = coupled[1];
            let (l1, l2) = (near * inverse, far * inverse);
            factors[i] = [inverse, l1, l2];
            let c = column;
            sums.take(c, inverse);
            for k in [A, X, Y, R] {
                column[k] = next_column[k] - l1 * c[k];
            }
            pivot = next_pivot - l1 * near;
            if i + 2 < count {
                coupled = coupling(i + 1, &list[i + 1]);
                near = coupled[0] - l1 * far;
                next_pivot = own(at_rest.at(i + 2), &list[i + 2]);
                next_column = raw(&list[i + 2], zero);
                if far != zero {
                    next_pivot -= l2 * far;
                    for k in [A, X, Y, R] {
                        next_column[k] -= l2 * c[k];
                    }
                }
            }
        }
    } else {
        let ([_, inner @ .., end], [_, rests @ .., rest_end], [_, constants @ .., _], [_, factors @ .., _]) =
            (list, at_rest, constant, factors)
        else {
            return (Condensed::BLANK, 0);
        };
        // What the node before takes.
        let (mut less, mut taken) = (zero, [-from_start[0], zero, zero, zero]);
        for (((node, factor), &rest), &[constant, _]) in inner.iter().zip(factors).zip(rests).zip(constants) {
            let c = [-taken[A], node.lever[0] - taken[X], node.lever[1] - taken[Y], node.gradient - taken[R]];
            let (p, is_negative) = bounded(own(rest, node) - less, bound * rest);
            negative += usize::from(is_negative);
            let inverse = T::one() / p;
            let near = if curved { node.coupling()[0] } else { constant };
            let l = near * inverse;
            (factor[0], factor[1]) = (inverse, l);
            sums.take(c, inverse);
            less = l * near;
            taken = c.map(|c| l * c);
        }
        pivot = own(*rest_end, end) - less;
        column = [-taken[A], end.lever[0] - taken[X], end.lever[1] - taken[Y], end.gradient - taken[R]];
    }
    let Sums { start: [aa, ax, ay, ar], force: [xx, xy, yy, xr, yr] } = sums;
    let start = raw(start, zero);
    // Now `pivot` and `column` are the end joint's. The joints' own entries:
    let (f, g) = (out.force, out.end_force);
    let (ra, rb) = (out.rigid_start, out.rigid_end);
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
        corrections: Corrections { ra: ar, rb: column[R] - list.last().map_or(zero, |end| end.gradient), rx: [xr, yr] },
    };
    (condensed, negative)
}

/// Solves H z = r on a member's interior with its factors; z comes into `into`. `right` gives r at a node, whose place in `into` may hold it.
/// `before` is what the start joint's value takes from the first two nodes' r, `after` the value of the end joint; the interior's
/// bandwidth is 2 if `wide`, else 1. Returns the largest magnitude in z, the end joint's included.
#[inline]
pub(super) fn solve_interior<T: Real>(
    (nodes, factors, into): (&[Node<T>], &[[T; 3]], &mut [T]),
    before: [T; 2],
    after: T,
    wide: bool,
    right: impl Fn(&Node<T>, T) -> T,
) -> T {
    if wide {
        solve_band::<T, true>((nodes, factors, into), before, after, right)
    } else {
        solve_band::<T, false>((nodes, factors, into), before, after, right)
    }
}

#[inline]
fn solve_band<T: Real, const WIDE: bool>(
    (nodes, factors, into): (&[Node<T>], &[[T; 3]], &mut [T]),
    before: [T; 2],
    after: T,
    right: impl Fn(&Node<T>, T) -> T,
) -> T {
    let mut largest = after.abs();
    let ([_, nodes @ .., _], [_, factors @ .., _], [_, into @ .., end]) = (nodes, factors, into) else {
        return largest;
    };
    // What the nodes before take: the nearest one, the one before it, and that from the next node.
    let ([mut near_before, mut far_next], mut far_before) = (before, T::ZERO);
    for ((node, &[_, near, far]), value) in nodes.iter().zip(factors).zip(&mut *into) {
        let own = right(node, *value);
        let v = if WIDE { own - near_before - far_before } else { own - near_before };
        *value = v;
        near_before = near * v;
        if WIDE {
            (far_before, far_next) = (far_next, far * v);
        }
    }
    *end = after;
    let (mut above, mut over) = (after, T::ZERO);
    for (value, &[inverse, near, far]) in into.iter_mut().zip(factors).rev() {
        let v = *value * inverse - near * above;
        let v = if WIDE { v - far * over } else { v };
        *value = v;
        largest = v.abs().max(largest);
        (over, above) = (above, v);
    }
    largest
}
