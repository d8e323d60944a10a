//! Condensation of a member's interior onto its start joint a, end joint b and force (x, y).
//!
//! The interior block, K less the forces' geometric softening on its diagonal, has bandwidth 2 (`simpson`) or 1 and is
//! eliminated element by element. An interior block may be singular or indefinite on a healthy branch (the back beam's spans buckle
//! between lamellae): its pivots are bounded away from zero, which perturbs the step and not the solution, and its negative pivots
//! are counted for the stability test.

use super::Workspace;
use super::condensed::{Condensed, Corrections};
use crate::access::Access;
use crate::element::Node;
use crate::linear::pivot::{bounded, pivot_bound};
use crate::model::Model;
use crate::real::Real;
use crate::size::{Blank, Size};
use crate::topology::Kind;

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

/// Condenses one member; with it the number of negative pivots.
pub(crate) fn condense<T: Real, S: Size>(
    model: &Model<T, S>,
    work: &mut Workspace<T, S>,
    index: usize,
    diagonal: Diagonal<T>,
) -> (Condensed<T>, usize) {
    if model.member(index).is_some_and(|member| member.kind == Kind::Quadratic) {
        condense_band::<T, S, true>(model, work, index, diagonal)
    } else {
        condense_band::<T, S, false>(model, work, index, diagonal)
    }
}

/// As [`condense`], the interior's bandwidth being 2 (`WIDE`) or 1.
fn condense_band<T: Real, S: Size, const WIDE: bool>(
    model: &Model<T, S>,
    work: &mut Workspace<T, S>,
    index: usize,
    diagonal: Diagonal<T>,
) -> (Condensed<T>, usize) {
    let (Some(member), Some(out)) = (model.member(index), work.shape.members.as_ref().get(index)) else {
        return (Condensed::BLANK, 0);
    };
    let nodes = member.nodes();
    let count = usize::from(member.interior) + 2;
    let stiffening = T::one() + diagonal.shift;
    // All of one length, which the indices below stay within.
    let (Some(at_rest), Some(constant), Some(list)) = (
        model.diagonal.as_ref().get(nodes.clone()).and_then(|all| all.get(..count)),
        model.coupling.as_ref().get(nodes.clone()).and_then(|all| all.get(..count)),
        work.shape.nodes.as_mut().get_mut(nodes).and_then(|all| all.get_mut(..count)),
    ) else {
        return (Condensed::BLANK, 0);
    };
    let curved = work.factorisation.curved;
    let coupling = |i: usize, node: &Node<T>| if curved { node.coupling } else { constant.at(i) };
    let bound = pivot_bound::<T>();
    let zero = T::ZERO;

    let own = |rest: T, node: &Node<T>| rest * stiffening - diagonal.curvature * node.curvature;
    let raw = |node: &Node<T>, a: T| [a, node.lever[0], node.lever[1], node.gradient];
    let mut negative = 0;
    let &mut [start, first, ..] = &mut *list else { return (Condensed::BLANK, 0) };
    let from_start = coupling(0, &start);
    let [xx, xy, yy] = out.compliance;
    let mut sums = Sums { start: [own(at_rest.at(0), &start), zero, zero, zero], force: [xx, xy, yy, zero, zero] };

    let (mut pivot, mut column);
    if WIDE {
        pivot = own(at_rest.at(1), &first);
        column = raw(&first, from_start[0]);
        let mut coupled = coupling(1, &first);
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
            list[i].factor = [inverse, l1, l2];
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
        let ([_, inner @ .., end], [_, rests @ .., rest_end], [_, constants @ .., _]) = (&mut *list, at_rest, constant)
        else {
            return (Condensed::BLANK, 0);
        };
        // What the node before takes.
        let (mut less, mut taken) = (zero, [-from_start[0], zero, zero, zero]);
        for ((node, &rest), &[constant, _]) in inner.iter_mut().zip(rests).zip(constants) {
            let c = [-taken[A], node.lever[0] - taken[X], node.lever[1] - taken[Y], node.gradient - taken[R]];
            let (p, is_negative) = bounded(own(rest, node) - less, bound * rest);
            negative += usize::from(is_negative);
            let inverse = T::one() / p;
            let near = if curved { node.coupling[0] } else { constant };
            let l = near * inverse;
            node.factor = [inverse, l, zero];
            sums.take(c, inverse);
            less = l * near;
            taken = c.map(|c| l * c);
        }
        pivot = own(*rest_end, end) - less;
        column = [-taken[A], end.lever[0] - taken[X], end.lever[1] - taken[Y], end.gradient - taken[R]];
    }
    let Sums { start: [aa, ax, ay, ar], force: [xx, xy, yy, xr, yr] } = sums;
    let start = raw(&start, zero);
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

/// Solves H z = r on a member's interior, `right` giving r at a node; z becomes the nodes' `delta`. `before` is what the start joint's
/// value takes from the first two nodes' r, `after` the value of the end joint; the interior's bandwidth is 2 if `wide`, else 1.
/// Returns the largest magnitude in z, the end joint's included.
#[inline]
pub(crate) fn solve_interior<T: Real>(
    nodes: &mut [Node<T>],
    before: [T; 2],
    after: T,
    wide: bool,
    right: impl Fn(&Node<T>) -> T,
) -> T {
    if wide {
        solve_band::<T, true>(nodes, before, after, right)
    } else {
        solve_band::<T, false>(nodes, before, after, right)
    }
}

#[inline]
fn solve_band<T: Real, const WIDE: bool>(
    nodes: &mut [Node<T>],
    before: [T; 2],
    after: T,
    right: impl Fn(&Node<T>) -> T,
) -> T {
    let mut largest = after.abs();
    let [_, inner @ .., end] = nodes else { return largest };
    // What the nodes before take: the nearest one, the one before it, and that from the next node.
    let ([mut near_before, mut far_next], mut far_before) = (before, T::ZERO);
    for node in &mut *inner {
        let [_, near, far] = node.factor;
        let v = if WIDE { right(node) - near_before - far_before } else { right(node) - near_before };
        node.delta = v;
        near_before = near * v;
        if WIDE {
            (far_before, far_next) = (far_next, far * v);
        }
    }
    end.delta = after;
    let (mut above, mut over) = (after, T::ZERO);
    for node in inner.iter_mut().rev() {
        let [inverse, near, far] = node.factor;
        let v = node.delta * inverse - near * above;
        let v = if WIDE { v - far * over } else { v };
        node.delta = v;
        largest = v.abs().max(largest);
        (over, above) = (above, v);
    }
    largest
}
