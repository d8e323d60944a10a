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

use super::Workspace;
use crate::contact::Sample;
use crate::ladder::{Ladder, State};
use crate::real::Real;
use crate::size::Size;

/// Carrier of the spring that begins at a local node.
#[inline]
fn carrier<T: Real>(weight: &[T], node: usize) -> usize {
    if weight.get(node + 1).is_some_and(|&w| w != T::ZERO) { node + 1 } else { node }
}

/// Slopes t ∂(½q)/∂θ and shortening η of all members whose stiffness follows the stretch, from the angles alone.
pub(crate) fn shorten<T: Real, S: Size>(ladder: &Ladder<T, S>, state: &State<T, S>, work: &mut Workspace<T, S>) {
    let half = T::of(0.5);
    for member in ladder.members() {
        let t = member.stiffening;
        if t == T::ZERO {
            continue;
        }
        let nodes = member.nodes();
        let (Some(angle), Some(coupling), Some(weight), Some(bent)) = (
            state.angle.as_ref().get(nodes.clone()),
            ladder.coupling.as_ref().get(nodes.clone()),
            ladder.weight.as_ref().get(nodes.clone()),
            work.bent.as_mut().get_mut(nodes),
        ) else {
            return;
        };
        if ladder.quadratic {
            // An element's middle and end come in pairs; its start is the end of the one before.
            let Some((&first, angles)) = angle.split_first() else { return };
            let mut a = first;
            let elements = angles.as_chunks::<2>().0.iter().zip(coupling.as_chunks::<2>().0);
            let slopes = weight.as_chunks::<2>().0.iter().zip(bent.as_chunks_mut::<2>().0);
            for ((&[m, b], &[[k, far], _]), (&[_, w], [first, middle])) in elements.zip(slopes) {
                let across = far * (b - a);
                let (ka, kb) = (k * (m - a) + across, k * (m - b) - across);
                *first = [t * ka, T::ZERO];
                *middle = [t * kb, half * t * (ka * (a - m) + kb * (b - m)) / w];
                a = b;
            }
            continue;
        }
        bent.fill([T::ZERO; 2]);
        for (node, pair) in angle.windows(2).enumerate() {
            let &[a, b] = pair else { continue };
            let Some(&[k, _]) = coupling.get(node) else { continue };
            let moment = k * (b - a);
            if let Some(slot) = bent.get_mut(node) {
                slot[0] = t * moment;
            }
            let carrier = carrier(weight, node);
            if let (Some(slot), Some(&w)) = (bent.get_mut(carrier), weight.get(carrier)) {
                slot[1] += half * t * moment * (a - b) / w;
            }
        }
    }
}

/// Adds a member's bending moments to its gradient.
pub(crate) fn moments<T: Real>(angle: &[T], coupling: &[[T; 2]], gradient: &mut [T], quadratic: bool) {
    if quadratic && angle.len() > 2 {
        // Elements of three nodes: start, middle, end.
        for element in 0..angle.len() / 2 {
            let at = 2 * element;
            let (Some(&[a, m, b]), Some(&[[k, far], _, _]), Some([ga, gm, gb])) = (
                angle.get(at..).and_then(|x| x.first_chunk::<3>()),
                coupling.get(at..).and_then(|x| x.first_chunk::<3>()),
                gradient.get_mut(at..).and_then(|x| x.first_chunk_mut::<3>()),
            ) else {
                return;
            };
            // Both halves of an element are alike.
            let (first, second, across) = (k * (m - a), k * (b - m), far * (b - a));
            *ga += first + across;
            *gm += second - first;
            *gb -= second + across;
        }
        return;
    }
    let pairs = angle.windows(2).zip(coupling);
    for (at, (pair, &[k, _])) in pairs.enumerate() {
        let (Some([g, h]), &[a, b]) = (gradient.get_mut(at..).and_then(|x| x.first_chunk_mut::<2>()), pair) else {
            return;
        };
        let moment = k * (b - a);
        *g += moment;
        *h -= moment;
    }
}

/// As [`moments`] for a member whose stiffness follows the stretch: its moments, its second derivatives (the off-diagonal ones
/// take the place of the carriers' pulls f·e and f·e′ that `strain` left in `work.coupling`, the diagonal ones go to the
/// curvature), and what the shortening adds to the levers.
pub(crate) fn stretched<T: Real, S: Size>(
    ladder: &Ladder<T, S>,
    state: &State<T, S>,
    work: &mut Workspace<T, S>,
    index: usize,
) {
    let Some(member) = ladder.members.as_ref().get(index) else { return };
    let (t, nodes) = (member.stiffening, member.nodes());
    let (Some(angle), Some(stiffness), Some(weight), Some(e), Some(bent)) = (
        state.angle.as_ref().get(nodes.clone()),
        ladder.coupling.as_ref().get(nodes.clone()),
        ladder.weight.as_ref().get(nodes.clone()),
        work.e.as_ref().get(nodes.clone()),
        work.bent.as_ref().get(nodes.clone()),
    ) else {
        return;
    };
    let (Some(lever), Some(coupling), Some(gradient), Some(curvature)) = (
        work.lever.as_mut().get_mut(nodes.clone()),
        work.coupling.as_mut().get_mut(nodes.clone()),
        work.gradient.as_mut().get_mut(nodes.clone()),
        work.curvature.as_mut().get_mut(nodes),
    ) else {
        return;
    };
    let shift = |lever: &mut [T; 2], slope: T, e: [T; 2]| *lever = [lever[0] - slope * e[0], lever[1] - slope * e[1]];
    let two = T::of(2.0);
    if ladder.quadratic {
        // An element's middle and end come in pairs; its start is the end of the one before.
        let (Some((&first, angles)), Some((la, levers)), Some((ga, gradients)), Some((da, curvatures))) =
            (angle.split_first(), lever.split_first_mut(), gradient.split_first_mut(), curvature.split_first_mut())
        else {
            return;
        };
        let (mut a, mut la, mut ga, mut da) = (first, la, ga, da);
        let rest = angles.as_chunks::<2>().0.iter().zip(stiffness.as_chunks::<2>().0);
        let strained = e.as_chunks::<2>().0.iter().zip(bent.as_chunks::<2>().0);
        let ends = levers.as_chunks_mut::<2>().0.iter_mut().zip(gradients.as_chunks_mut::<2>().0);
        let seconds = curvatures.as_chunks_mut::<2>().0.iter_mut().zip(coupling.as_chunks_mut::<2>().0);
        for (
            ((&[m, b], &[[k, far], _]), (&[_, e], &[[sa, _], [sb, _]])),
            (([lm, lb], [gm, gb]), ([dm, db], [ca, cm])),
        ) in rest.zip(strained).zip(ends.zip(seconds))
        {
            let [pull, across] = *cm;
            let softer = t * pull;
            let (near, far_now) = (k - softer * k, far - softer * far);
            let (first, second, ends) = (near * (m - a), near * (b - m), far_now * (b - a));
            *ga += first + ends;
            *gm += second - first;
            *gb -= second + ends;
            let sm = -(sa + sb);
            *ca = [near - across * sa, far_now];
            *cm = [near - across * sb, T::ZERO];
            // K's diagonal: −(k + far) at both ends, −2k in the middle.
            let end = near + far_now - k - far;
            *da += end;
            *db += end;
            *dm += two * (near - k + across * sm);
            shift(la, sa, e);
            shift(lm, sm, e);
            shift(lb, sb, e);
            (a, la, ga, da) = (b, lb, gb, db);
        }
        return;
    }
    for (at, pair) in angle.windows(2).enumerate() {
        let carrier = carrier(weight, at);
        let above = carrier != at;
        let (&[a, b], Some(&[k, _]), Some(&[s, _]), Some(&e), Some(&[pull, across])) =
            (pair, stiffness.get(at), bent.get(at), e.get(carrier), coupling.get(carrier))
        else {
            return;
        };
        let (Some([la, lb]), Some(c), Some([ga, gb]), Some([da, db])) = (
            lever.get_mut(at..).and_then(|x| x.first_chunk_mut::<2>()),
            coupling.get_mut(at),
            gradient.get_mut(at..).and_then(|x| x.first_chunk_mut::<2>()),
            curvature.get_mut(at..).and_then(|x| x.first_chunk_mut::<2>()),
        ) else {
            return;
        };
        let near = k - t * pull * k;
        let moment = near * (b - a);
        *ga += moment;
        *gb -= moment;
        let cross = if above { -across * s } else { across * s };
        *c = [near + cross, T::ZERO];
        *da += near - k;
        *db += near - k;
        *(if above { db } else { da }) += two * cross;
        shift(la, s, e);
        shift(lb, -s, e);
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
    let Some(member) = ladder.members.as_ref().get(index) else { return own };
    let nodes = member.nodes();
    // The wedge's samples lie beyond the last node.
    let Some(first) = usize::from(sample.node).checked_sub(nodes.start).filter(|&node| node < nodes.len()) else {
        return own;
    };
    let (Some(weight), Some(lever), Some(e), Some(bent)) = (
        ladder.weight.as_ref().get(nodes.clone()),
        work.lever.as_ref().get(nodes.clone()),
        work.e.as_ref().get(nodes.clone()),
        work.bent.as_ref().get(nodes),
    ) else {
        return own;
    };
    let share = |k: usize| {
        let (part, all) = (sample.weights[k], weight.get(first + k).copied().unwrap_or(T::ZERO));
        if part == T::ZERO || all == T::ZERO { T::ZERO } else { part / all }
    };
    let stiffens = member.stiffening != T::ZERO;
    if ladder.quadratic {
        let slope = |node: usize| bent.get(node).map_or(T::ZERO, |b| b[0]);
        let (sa, sb) = (slope(first), slope(first + 1));
        let part = share(1);
        // What the levers hold of this element's shortening and of the one's below it.
        let mut full = [[T::ZERO; 2]; 3];
        let mut kept = [[T::ZERO; 2]; 3];
        if stiffens {
            let middle = e.get(first + 1).copied().unwrap_or([T::ZERO; 2]);
            for (k, s) in [sa, -(sa + sb), sb].into_iter().enumerate() {
                full[k] = [-s * middle[0], -s * middle[1]];
                kept[k] = [part * full[k][0], part * full[k][1]];
            }
            if first >= 2 {
                let below = slope(first - 1);
                let v = [-below * e[first - 1][0], -below * e[first - 1][1]];
                full[0] = [full[0][0] + v[0], full[0][1] + v[1]];
                kept[0] = [kept[0][0] + v[0], kept[0][1] + v[1]];
            }
            // The end's lever holds the next element's too.
            if let Some(&next) = e.get(first + 3) {
                let s = slope(first + 2);
                full[2] = [full[2][0] - s * next[0], full[2][1] - s * next[1]];
            }
        }
        for k in 0..3 {
            let all = lever.get(first + k).copied().unwrap_or([T::ZERO; 2]);
            own[k] = [0, 1].map(|i| share(k) * (all[i] - full[k][i]) + kept[k][i]);
        }
        return own;
    }
    own[0] = lever[first];
    if stiffens && let (Some(&[s, _]), Some(&e)) = (bent.get(first), e.get(carrier(weight, first))) {
        // The spring above the link shortens the next link, which lies beyond the sample, or this one.
        let v = [s * e[0], s * e[1]];
        own[if carrier(weight, first) == first { 1 } else { 0 }] =
            if carrier(weight, first) == first { v } else { [own[0][0] + v[0], own[0][1] + v[1]] };
    }
    own
}
