//! Bending of a member, and how it meets the force through it.
//!
//! A fibre at nominal strain u stores ½E(u² + c u³) per volume (see [`crate::design::MaterialLaw`]). Over a section of area A
//! and second moment I, bent by κ and stretched by ε, that is ½EA ε² + ½EI κ² (1 + 3c ε) up to third order: the bending
//! stiffness follows the stretch. With ε = −(f·e)/EA for the force f (in the Lagrangian's sign) an element of bending energy
//! ½q(θ) adds ½q (1 − t f·e), t = 3c/EA, with e the direction of the element's middle node, its carrier; for the schemes of
//! links the carrier is the link above the spring, or below it where there is none above.
//!
//! Being linear in f, the term is an end-to-end vector shorter by ½ t q along e: a bent element is shorter by η = ½ t q/w per
//! weight w of its carrier. Under compression the element is softer: what makes a back beam buckle as finite elements say.

use super::{Node, Workspace};
use crate::contact::Sample;
use crate::ladder::Ladder;
use crate::real::Real;
use crate::size::Size;
use crate::state::State;
use crate::topology::Member;

/// Carrier of the spring that begins at a local node.
#[inline]
fn carrier<T: Real>(weight: &[T], node: usize) -> usize {
    if weight.get(node + 1).is_some_and(|&w| w != T::ZERO) { node + 1 } else { node }
}

/// Slopes t ∂(½q)/∂θ and shortening η of all members whose stiffness follows the stretch, from the angles alone.
pub(crate) fn shorten<T: Real, S: Size>(ladder: &Ladder<T, S>, state: &State<T, S>, work: &mut Workspace<T, S>) {
    if !ladder.quadratic {
        return;
    }
    let half = T::of(0.5);
    for member in ladder.members() {
        let t = member.stiffening;
        if t == T::ZERO {
            continue;
        }
        let nodes = member.nodes();
        let (Some([first, angles @ ..]), Some(coupling), Some(weight), Some(list)) = (
            state.angle.as_ref().get(nodes.clone()),
            ladder.coupling.as_ref().get(nodes.clone()),
            ladder.weight.as_ref().get(nodes.clone()),
            work.nodes.as_mut().get_mut(nodes),
        ) else {
            return;
        };
        // An element's middle and end come in pairs; its start is the end of the one before.
        let mut a = *first;
        let elements = angles.as_chunks::<2>().0.iter().zip(coupling.as_chunks::<2>().0);
        let slopes = weight.as_chunks::<2>().0.iter().zip(list.as_chunks_mut::<2>().0);
        for ((&[m, b], &[[k, far], _]), (&[_, w], [first, middle])) in elements.zip(slopes) {
            let across = far * (b - a);
            let (ka, kb) = (k * (m - a) + across, k * (m - b) - across);
            first.bent = [t * ka, T::ZERO];
            middle.bent = [t * kb, half * t * (ka * (a - m) + kb * (b - m)) / w];
            a = b;
        }
    }
}

/// Adds a member's bending moments to its gradient, and gives its nodes the ladder's second derivatives.
pub(crate) fn moments<T: Real, S: Size>(
    ladder: &Ladder<T, S>,
    state: &State<T, S>,
    work: &mut Workspace<T, S>,
    member: &Member<T>,
) {
    let nodes = member.nodes();
    let (Some(angle), Some(coupling), Some(list)) = (
        state.angle.as_ref().get(nodes.clone()),
        ladder.coupling.as_ref().get(nodes.clone()),
        work.nodes.as_mut().get_mut(nodes),
    ) else {
        return;
    };
    for (node, &coupling) in list.iter_mut().zip(coupling) {
        node.coupling = coupling;
    }
    if ladder.quadratic && angle.len() > 2 {
        let (Some((&first, angles)), Some((start, list))) = (angle.split_first(), list.split_first_mut()) else {
            return;
        };
        let (mut a, mut start) = (first, start);
        let elements = angles.as_chunks::<2>().0.iter().zip(coupling.as_chunks::<2>().0);
        for ((&[m, b], &[[k, far], _]), [middle, end]) in elements.zip(list.as_chunks_mut::<2>().0) {
            // Both halves of an element are alike.
            let (first, second, across) = (k * (m - a), k * (b - m), far * (b - a));
            start.gradient += first + across;
            middle.gradient += second - first;
            end.gradient -= second + across;
            (a, start) = (b, end);
        }
        return;
    }
    for (at, (pair, &[k, _])) in angle.windows(2).zip(coupling).enumerate() {
        let (Some([node, next]), &[a, b]) = (list.get_mut(at..).and_then(|x| x.first_chunk_mut::<2>()), pair) else {
            return;
        };
        let moment = k * (b - a);
        node.gradient += moment;
        next.gradient -= moment;
    }
}

/// As [`moments`] for a member whose stiffness follows the stretch: its moments, its second derivatives (the off-diagonal ones
/// take the place of the carriers' pulls f·e and f·e′ that `strain` left in the nodes' coupling, the diagonal ones go to the
/// curvature), and what the shortening adds to the levers.
pub(crate) fn stretched<T: Real, S: Size>(
    ladder: &Ladder<T, S>,
    state: &State<T, S>,
    work: &mut Workspace<T, S>,
    member: &Member<T>,
) {
    let (t, nodes) = (member.stiffening, member.nodes());
    let (Some(angle), Some(stiffness), Some(list)) = (
        state.angle.as_ref().get(nodes.clone()),
        ladder.coupling.as_ref().get(nodes.clone()),
        work.nodes.as_mut().get_mut(nodes),
    ) else {
        return;
    };
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
        let ([pull, across], e) = (middle.coupling, middle.e);
        let (sa, sb) = (start.bent[0], middle.bent[0]);
        let softer = t * pull;
        let (near, far_now) = (k - softer * k, far - softer * far);
        let (first, second, ends) = (near * (m - a), near * (b - m), far_now * (b - a));
        start.gradient += first + ends;
        middle.gradient += second - first;
        end.gradient -= second + ends;
        let sm = -(sa + sb);
        start.coupling = [near - across * sa, far_now];
        middle.coupling = [near - across * sb, T::ZERO];
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

/// Derivatives of a sample's position with respect to the angles of three nodes, from the sample's own on, mm: its element's,
/// where it has weights of its own and its share of the shortening.
pub(crate) fn sample_lever<T: Real, S: Size>(
    ladder: &Ladder<T, S>,
    work: &Workspace<T, S>,
    index: usize,
    sample: &Sample<T>,
) -> [[T; 2]; 3] {
    let mut own = [[T::ZERO; 2]; 3];
    let Some(member) = ladder.member(index) else { return own };
    let nodes = member.nodes();
    // The wedge's samples lie beyond the last node.
    let Some(first) = usize::from(sample.node).checked_sub(nodes.start).filter(|&node| node < nodes.len()) else {
        return own;
    };
    let (Some(weight), Some(list)) = (ladder.weight.as_ref().get(nodes.clone()), work.nodes.as_ref().get(nodes)) else {
        return own;
    };
    let share = |k: usize| {
        let (part, all) = (sample.weights[k], weight.get(first + k).copied().unwrap_or(T::ZERO));
        if part == T::ZERO || all == T::ZERO { T::ZERO } else { part / all }
    };
    let stiffens = member.stiffening != T::ZERO;
    let slope = |node: usize| list.get(node).map_or(T::ZERO, |node| node.bent[0]);
    if ladder.quadratic {
        let (sa, sb) = (slope(first), slope(first + 1));
        let part = share(1);
        // What the levers hold of this element's shortening and of the one's below it.
        let mut full = [[T::ZERO; 2]; 3];
        let mut kept = [[T::ZERO; 2]; 3];
        if stiffens {
            let middle = list.get(first + 1).map_or([T::ZERO; 2], |node| node.e);
            for (k, s) in [sa, -(sa + sb), sb].into_iter().enumerate() {
                full[k] = [-s * middle[0], -s * middle[1]];
                kept[k] = [part * full[k][0], part * full[k][1]];
            }
            if let Some(below) = first.checked_sub(1).and_then(|node| list.get(node)).filter(|_| first >= 2) {
                let v = [-below.bent[0] * below.e[0], -below.bent[0] * below.e[1]];
                full[0] = [full[0][0] + v[0], full[0][1] + v[1]];
                kept[0] = [kept[0][0] + v[0], kept[0][1] + v[1]];
            }
            // The end's lever holds the next element's too.
            if let Some(next) = list.get(first + 3) {
                let s = slope(first + 2);
                full[2] = [full[2][0] - s * next.e[0], full[2][1] - s * next.e[1]];
            }
        }
        for k in 0..3 {
            let all = list.get(first + k).map_or([T::ZERO; 2], |node| node.lever);
            own[k] = [0, 1].map(|i| share(k) * (all[i] - full[k][i]) + kept[k][i]);
        }
        return own;
    }
    let lever = |node: usize| list.get(node).map_or([T::ZERO; 2], |node| node.lever);
    // A place short of a link's end: a part of that link, and the whole of the one below it.
    let (link, part) = if sample.weights[1] == T::ZERO { (first, T::one()) } else { (first + 1, share(1)) };
    let [x, y] = lever(link);
    let mut this = [part * x, part * y];
    let mut end = [T::ZERO; 2];
    let carrier = carrier(weight, link);
    if let Some(carrying) = list.get(carrier).filter(|_| stiffens) {
        // The spring above the link shortens the next link, which lies beyond the place, or this one.
        let s = part * slope(link);
        let v = [s * carrying.e[0], s * carrying.e[1]];
        if carrier == link {
            end = v;
        } else {
            this = [this[0] + v[0], this[1] + v[1]];
        }
    }
    if link == first {
        return [this, end, own[2]];
    }
    own = [lever(first), this, end];
    if let Some(partial) = list.get(link).filter(|_| stiffens) {
        // The spring below it shortens the whole of it.
        let s = (T::one() - part) * slope(first);
        own[0] = [own[0][0] + s * partial.e[0], own[0][1] + s * partial.e[1]];
    }
    own
}
