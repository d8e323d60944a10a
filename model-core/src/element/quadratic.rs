//! Quadratic elements (`simpson`): nodes at the ends and in the middle, the bend linear between them (12).

use super::node::strained;
use super::{Constants, Depth, Element, Node, Past, Pull, Strain};
use crate::contact::{Row, Sample};
use crate::real::Real;

/// A member of quadratic elements.
pub(crate) struct Quadratic;

impl<T: Real> Element<T> for Quadratic {
    // Second derivatives come with the rest: between passes that are this short nothing is spared by leaving them out.
    fn walk<D: Depth, P: Past<T>>(
        of: Constants<'_, T>,
        past: P,
        angle: &[T],
        rows: &[Row<T>],
        nodes: &mut [Node<T>],
        out: &mut Strain<T>,
    ) {
        if of.member.stiffening != T::ZERO {
            shorten(of, angle, nodes);
        }
        if of.member.compliance == [T::ZERO; 2] {
            walk::<T, P, true>(of, past, rows, nodes, out);
        } else {
            walk::<T, P, false>(of, past, rows, nodes, out);
        }
    }

    fn bend(of: Constants<'_, T>, angle: &[T], nodes: &mut [Node<T>], out: &mut Strain<T>) {
        if of.member.stiffening == T::ZERO {
            moments(of, angle, nodes);
        } else {
            stretched(of, angle, nodes);
        }
        out.steepest = match &*nodes {
            [_, interior @ .., _] => interior.iter().fold(T::ZERO, |most, node| most.max(node.gradient.abs())),
            _ => T::ZERO,
        };
    }

    fn lever(of: Constants<'_, T>, first: usize, sample: &Sample<T>, nodes: &[Node<T>]) -> [[T; 2]; 3] {
        let mut own = [[T::ZERO; 2]; 3];
        let share = |k: usize| {
            let (part, all) = (sample.weights[k], of.weight.get(first + k).copied().unwrap_or(T::ZERO));
            if part == T::ZERO || all == T::ZERO { T::ZERO } else { part / all }
        };
        let stiffens = of.member.stiffening != T::ZERO;
        let slope = |node: usize| nodes.get(node).map_or(T::ZERO, |node| node.bent[0]);
        let (sa, sb) = (slope(first), slope(first + 1));
        let part = share(1);
        // What the levers hold of this element's shortening and of the one's below it.
        let mut full = [[T::ZERO; 2]; 3];
        let mut kept = [[T::ZERO; 2]; 3];
        if stiffens {
            let middle = nodes.get(first + 1).map_or([T::ZERO; 2], |node| node.e);
            for (k, s) in [sa, -(sa + sb), sb].into_iter().enumerate() {
                full[k] = [-s * middle[0], -s * middle[1]];
                kept[k] = [part * full[k][0], part * full[k][1]];
            }
            if let Some(below) = first.checked_sub(1).and_then(|node| nodes.get(node)).filter(|_| first >= 2) {
                let v = [-below.bent[0] * below.e[0], -below.bent[0] * below.e[1]];
                full[0] = [full[0][0] + v[0], full[0][1] + v[1]];
                kept[0] = [kept[0][0] + v[0], kept[0][1] + v[1]];
            }
            // The end's lever holds the next element's too.
            if let Some(next) = nodes.get(first + 3) {
                let s = slope(first + 2);
                full[2] = [full[2][0] - s * next.e[0], full[2][1] - s * next.e[1]];
            }
        }
        for k in 0..3 {
            let all = nodes.get(first + k).map_or([T::ZERO; 2], |node| node.lever);
            own[k] = [0, 1].map(|i| share(k) * (all[i] - full[k][i]) + kept[k][i]);
        }
        own
    }
}

impl Quadratic {
    /// Bending moments of the element that begins at a local node, on its three nodes in the gradient's sign, with the force f·e that its
    /// middle has: those that the gradient gets, apart from it.
    pub fn moments<T: Real>(of: Constants<'_, T>, angle: &[T], node: usize, pull: T) -> [T; 3] {
        let (Some(&[a, m, b]), Some(&[k, far])) =
            (angle.get(node..).and_then(<[T]>::first_chunk), of.coupling.get(node))
        else {
            return [T::ZERO; 3];
        };
        let part = T::one() - of.member.stiffening * pull;
        let (first, second, ends) = (part * (k * (m - a)), part * (k * (b - m)), part * (far * (b - a)));
        [first + ends, second - first, -(second + ends)]
    }
}

/// What bending alone, the angles being known, takes of the length: slopes t ∂(½q)/∂θ and shortening η.
fn shorten<T: Real>(of: Constants<'_, T>, angle: &[T], nodes: &mut [Node<T>]) {
    let (half, t) = (T::of(0.5), of.member.stiffening);
    let Some((first, angles)) = angle.split_first() else { return };
    // An element's middle and end come in pairs; its start is the end of the one before.
    let mut a = *first;
    let elements = angles.as_chunks::<2>().0.iter().zip(of.coupling.as_chunks::<2>().0);
    let slopes = of.weight.as_chunks::<2>().0.iter().zip(nodes.as_chunks_mut::<2>().0);
    for ((&[m, b], &[[k, far], _]), (&[_, w], [first, middle])) in elements.zip(slopes) {
        let across = far * (b - a);
        let (ka, kb) = (k * (m - a) + across, k * (m - b) - across);
        first.bent = [t * ka, T::ZERO];
        middle.bent = [t * kb, half * t * (ka * (a - m) + kb * (b - m)) / w];
        a = b;
    }
}

/// Strained directions, levers and the force's part of gradient and second derivatives, from end to start.
fn walk<T: Real, P: Past<T>, const RIGID: bool>(
    of: Constants<'_, T>,
    past: P,
    rows: &[Row<T>],
    nodes: &mut [Node<T>],
    out: &mut Strain<T>,
) {
    let member = of.member;
    let mut pull = Pull::new(rows, out.force);
    let mut chord = [T::ZERO; 2];
    // Σ w e eᵀ.
    let mut inertia = [T::ZERO; 3];
    let first = usize::from(member.first);
    for ((index, &w), node) in member.nodes().zip(of.weight).zip(nodes).rev() {
        let shorter = if RIGID { T::ZERO } else { node.bent[1] };
        let e = node.e;
        let prior = if P::IS_ANY && !RIGID { past.forces(index - first) } else { [T::ZERO; 2] };
        let strained = strained::<T, P, RIGID>(e, w, pull.force(index, w), member.compliance, shorter, prior);
        node.strained = strained.direction;
        chord = [chord[0] + w * strained.direction[0], chord[1] + w * strained.direction[1]];
        node.lever = strained.lever;
        node.gradient = if P::IS_ANY { strained.gradient + past.moment(index - first) } else { strained.gradient };
        node.curvature = strained.curvature;
        if !RIGID {
            node.set_pull(strained.pull);
            let (wx, wy) = (w * e[0], w * e[1]);
            inertia = [inertia[0] + wx * e[0], inertia[1] + wx * e[1], inertia[2] + wy * e[1]];
        }
    }
    out.chord = chord;
    let ([stretch, shear], [xx, xy, yy]) = (member.compliance, inertia);
    out.compliance = [-(stretch * xx + shear * yy), (shear - stretch) * xy, -(stretch * yy + shear * xx)];
}

/// Adds the bending moments, and gives the nodes the model's second derivatives.
fn moments<T: Real>(of: Constants<'_, T>, angle: &[T], list: &mut [Node<T>]) {
    let (Some((&first, angles)), Some((start, list))) = (angle.split_first(), list.split_first_mut()) else {
        return;
    };
    // A rigid link has no elements, and couples nothing.
    start.set_coupling([T::ZERO; 2]);
    let (mut a, mut start) = (first, start);
    let elements = angles.as_chunks::<2>().0.iter().zip(of.coupling.as_chunks::<2>().0);
    for ((&[m, b], &[coupling, near]), [middle, end]) in elements.zip(list.as_chunks_mut::<2>().0) {
        let [k, far] = coupling;
        start.set_coupling(coupling);
        middle.set_coupling(near);
        // Both halves of an element are alike.
        let (first, second, across) = (k * (m - a), k * (b - m), far * (b - a));
        start.gradient += first + across;
        middle.gradient += second - first;
        end.gradient -= second + across;
        (a, start) = (b, end);
    }
}

/// As [`moments`] for a member whose stiffness follows the stretch under the carriers' pulls f·e and f·e′: its moments, its second
/// derivatives (the off-diagonal ones are the nodes' coupling, the diagonal ones go to the curvature), and what the shortening adds to
/// the levers.
fn stretched<T: Real>(of: Constants<'_, T>, angle: &[T], list: &mut [Node<T>]) {
    let (t, stiffness) = (of.member.stiffening, of.coupling);
    let shift = |node: &mut Node<T>, slope: T, e: [T; 2]| {
        node.lever = [node.lever[0] - slope * e[0], node.lever[1] - slope * e[1]];
    };
    let two = T::of(2.0);
    // An element's middle and end come in pairs; its start is the end of the one before.
    let (Some((&first, angles)), Some((start, list))) = (angle.split_first(), list.split_first_mut()) else {
        return;
    };
    let (mut a, mut start) = (first, start);
    let elements = angles.as_chunks::<2>().0.iter().zip(stiffness.as_chunks::<2>().0);
    for ((&[m, b], &[[k, far], _]), [middle, end]) in elements.zip(list.as_chunks_mut::<2>().0) {
        let ([pull, across], e) = (middle.pull(), middle.e);
        let (sa, sb) = (start.bent[0], middle.bent[0]);
        let softer = t * pull;
        let (near, far_now) = (k - softer * k, far - softer * far);
        let (first, second, ends) = (near * (m - a), near * (b - m), far_now * (b - a));
        start.gradient += first + ends;
        middle.gradient += second - first;
        end.gradient -= second + ends;
        let sm = -(sa + sb);
        start.set_coupling([near - across * sa, far_now]);
        middle.set_coupling([near - across * sb, T::ZERO]);
        // K's diagonal: −(k + far) at both ends, −2k in the middle.
        let more = near + far_now - k - far;
        start.curvature += more;
        end.curvature += more;
        middle.curvature += two * (near - k + across * sm);
        shift(start, sa, e);
        shift(middle, sm, e);
        shift(end, sb, e);
        (a, start) = (b, end);
    }
}
