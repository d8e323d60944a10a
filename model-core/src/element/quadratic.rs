//! Quadratic elements (`simpson`): nodes at the ends and in the middle, the bend linear between them (12).

use super::node::strained;
use super::{Constants, Depth, Element, Node, Past, Pull, Strain};
use crate::access::Access;
use crate::contact::{Row, Sample};
use crate::real::Real;

/// A member of quadratic elements.
pub(crate) struct Quadratic;

/// Weights of e(a), e(m), e(b) in P(ξ) − P₀ of an element of length h: the cubic Hermite curve through both ends, whose
/// chord is Simpson's rule h/6·(e(a) + 4 e(m) + e(b)) and whose end tangents are h·e(a) and h·e(b).
pub(crate) fn hermite_weights<T: Real>(xi: T, h: T) -> [T; 3] {
    let one = T::one();
    let h01 = xi * xi * (T::of(3.0) - xi - xi);
    let h10 = xi * (one - xi) * (one - xi);
    let h11 = xi * xi * (xi - one);
    let chord = h * h01;
    [chord * T::of(1.0 / 6.0) + h * h10, chord * T::of(4.0 / 6.0), chord * T::of(1.0 / 6.0) + h * h11]
}

impl<T: Real> Element<T> for Quadratic {
    const SPARES_TANGENT: bool = false;

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

    fn between(weight: &[T], first: u16, sample: &Sample<T>, xi: T) -> (u16, [T; 3]) {
        let h = Self::length(weight, usize::from(sample.node) + 1);
        let [a, m, b] = hermite_weights(xi, h);
        // Interior ends carry h/6 of the element below.
        let shared = if first == sample.node { T::ZERO } else { h * T::of(1.0 / 6.0) };
        (sample.node, [shared + a, m, b])
    }

    fn turns(_: &Sample<T>, xi: T) -> (usize, [T; 3]) {
        let (one, two) = (T::one(), T::of(2.0));
        (0, [(one - xi) * (one - two * xi), T::of(4.0) * xi * (one - xi), xi * (two * xi - one)])
    }

    /// Even sections are starts of elements, odd ones their ends.
    fn section(angle: &[T], stretch: impl Fn(usize) -> T, section: usize) -> (T, T) {
        let first = section - section % 2;
        // θ′h of the quadratic through the element's three angles.
        let (a, b) = (angle.at(first + 1) - angle.at(first), angle.at(first + 2) - angle.at(first + 1));
        let three = T::of(3.0);
        if section == first { (stretch(first), three * a - b) } else { (stretch(first + 2), three * b - a) }
    }

    fn arc(weight: &[T], section: usize) -> T {
        let middles = weight.iter().skip(1).step_by(2).take(section.div_ceil(2));
        T::of(1.5) * middles.fold(T::ZERO, |sum, &middle| sum + middle)
    }

    fn point(weight: &[T], strained: impl Fn(usize) -> [T; 2], node: usize, at: &mut [T; 2]) -> Option<[T; 2]> {
        let is_middle = node % 2 == 1;
        let middle = if is_middle { node } else { node.checked_sub(1)? };
        if middle + 1 >= weight.len() {
            // A pin or a weld.
            return None;
        }
        let h = Self::length(weight, middle);
        let (a, m, b) = (strained(middle - 1), strained(middle), strained(middle + 1));
        let sixth = h * T::of(1.0 / 6.0);
        let chord = [0, 1].map(|i| sixth * (a[i] + T::of(4.0) * m[i] + b[i]));
        if is_middle {
            // The cubic Hermite curve at ξ = 1/2.
            return Some([0, 1].map(|i| at[i] + T::of(0.5) * chord[i] + T::of(0.125) * h * (a[i] - b[i])));
        }
        *at = [at[0] + chord[0], at[1] + chord[1]];
        Some(*at)
    }

    /// An element's end comes first, and stands for its middle; its middle then for its start.
    fn point_back(weight: &[T], strained: impl Fn(usize) -> [T; 2], node: usize, at: &mut [T; 2]) -> Option<[T; 2]> {
        let is_middle = node % 2 == 1;
        let mut chord = [T::ZERO; 2];
        Self::point(weight, &strained, if is_middle { node + 1 } else { node }, &mut chord)?;
        let start = [at[0] - chord[0], at[1] - chord[1]];
        if is_middle {
            *at = start;
            return Some(start);
        }
        let mut from = start;
        Self::point(weight, strained, node.checked_sub(1)?, &mut from)
    }
}

impl Quadratic {
    /// Length of the element whose middle a node is: Simpson's weight of that is 4h/6.
    fn length<T: Real>(weight: &[T], middle: usize) -> T {
        weight.at(middle) * T::of(1.5)
    }

    /// Bending moments of an element of angles θ on its three nodes, in the gradient's sign: those that the gradient gets, apart from it.
    /// `part` is what the force that its middle has leaves of its stiffness.
    #[inline(always)]
    pub fn moments<T: Real>([a, m, b]: [T; 3], [k, far]: [T; 2], part: T) -> [T; 3] {
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
        let [moment, along, across] = past.stresses(index - first);
        let strained = strained::<T, P, RIGID>(e, w, pull.force(index, w), member.compliance, shorter, [along, across]);
        node.strained = strained.direction;
        chord = [chord[0] + w * strained.direction[0], chord[1] + w * strained.direction[1]];
        node.lever = strained.lever;
        node.gradient = if P::IS_ANY { strained.gradient + moment } else { strained.gradient };
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
