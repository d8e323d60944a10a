//! Rigid links between springs (`paper`, `trapezoid`), in one walk from a member's end to its start (13).
//!
//! Each spring has one carrier, the link above it (below it at a `trapezoid`'s end), so that a link needs nothing but what the one above
//! has left it.

use super::node::strained;
use super::{Constants, Depth, Element, Node, Past, Strain};
use crate::access::Access;
use crate::contact::{Row, Sample};
use crate::real::Real;

/// A member of rigid links.
pub(crate) struct Link;

impl<T: Real> Element<T> for Link {
    const SPARES_TANGENT: bool = true;

    fn walk<D: Depth, P: Past<T>>(
        of: Constants<'_, T>,
        past: P,
        angle: &[T],
        rows: &[Row<T>],
        nodes: &mut [Node<T>],
        out: &mut Strain<T>,
    ) {
        if of.member.compliance == [T::ZERO; 2] && of.member.stiffening == T::ZERO {
            walk::<T, D, P, true>(of, past, angle, rows, nodes, out);
        } else {
            walk::<T, D, P, false>(of, past, angle, rows, nodes, out);
        }
    }

    /// The links' moments come with their walk.
    fn bend(_: Constants<'_, T>, _: &[T], _: &mut [Node<T>], _: &mut Strain<T>) {}

    fn lever(of: Constants<'_, T>, first: usize, sample: &Sample<T>, nodes: &[Node<T>]) -> [[T; 2]; 3] {
        let mut own = [[T::ZERO; 2]; 3];
        let share = |k: usize| {
            let (part, all) = (sample.weights[k], of.weight.get(first + k).copied().unwrap_or(T::ZERO));
            if part == T::ZERO || all == T::ZERO { T::ZERO } else { part / all }
        };
        let stiffens = of.member.stiffening != T::ZERO;
        let slope = |node: usize| nodes.get(node).map_or(T::ZERO, |node| node.bent[0]);
        let lever = |node: usize| nodes.get(node).map_or([T::ZERO; 2], |node| node.lever);
        // A place short of a link's end: a part of that link, and the whole of the one below it.
        let (link, part) = if sample.weights[1] == T::ZERO { (first, T::one()) } else { (first + 1, share(1)) };
        let [x, y] = lever(link);
        let mut this = [part * x, part * y];
        let mut end = [T::ZERO; 2];
        let carrier = carrier(of.weight, link);
        if let Some(carrying) = nodes.get(carrier).filter(|_| stiffens) {
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
        if let Some(partial) = nodes.get(link).filter(|_| stiffens) {
            // The spring below it shortens the whole of it.
            let s = (T::one() - part) * slope(first);
            own[0] = [own[0][0] + s * partial.e[0], own[0][1] + s * partial.e[1]];
        }
        own
    }

    /// A part of this link, and the one below it, which may be another member's joint.
    fn between(weight: &[T], _: u16, sample: &Sample<T>, xi: T) -> (u16, [T; 3]) {
        let node = sample.node.saturating_sub(1);
        (node, [weight.at(usize::from(node)), xi * sample.weights[0], T::ZERO])
    }

    fn turns(place: &Sample<T>, _: T) -> (usize, [T; 3]) {
        (usize::from(place.weights[1] != T::ZERO), [T::one(), T::ZERO, T::ZERO])
    }

    fn section(angle: &[T], stretch: impl Fn(usize) -> T, section: usize) -> (T, T) {
        let mean = T::of(0.5) * (stretch(section) + stretch(section + 1));
        (mean, angle.at(section + 1) - angle.at(section))
    }

    fn arc(weight: &[T], section: usize) -> T {
        weight.iter().skip(1).take(section).fold(T::ZERO, |sum, &link| sum + link)
    }

    fn point(weight: &[T], strained: impl Fn(usize) -> [T; 2], node: usize, at: &mut [T; 2]) -> Option<[T; 2]> {
        let (w, e) = (weight.at(node), strained(node));
        *at = [at[0] + w * e[0], at[1] + w * e[1]];
        (w > T::ZERO).then_some(*at)
    }

    fn point_back(weight: &[T], strained: impl Fn(usize) -> [T; 2], node: usize, at: &mut [T; 2]) -> Option<[T; 2]> {
        let mut ahead = [T::ZERO; 2];
        let found = Self::point(weight, strained, node, &mut ahead);
        *at = [at[0] - ahead[0], at[1] - ahead[1]];
        found.map(|_| *at)
    }
}

impl Link {
    /// Local node of the link that carries the spring which begins at a local node.
    pub fn carrier<T: Real>(of: Constants<'_, T>, node: usize) -> usize {
        carrier(of.weight, node)
    }

    /// Moment of that spring as the gradient gets it, with the force f·e that its carrier has.
    pub fn moment<T: Real>(of: Constants<'_, T>, angle: &[T], node: usize, pull: T) -> T {
        let (Some(&[below, above]), Some(&[k, _])) =
            (angle.get(node..).and_then(<[T]>::first_chunk), of.coupling.get(node))
        else {
            return T::ZERO;
        };
        (T::one() - of.member.stiffening * pull) * (k * (above - below))
    }
}

/// Carrier of the spring that begins at a local node.
#[inline]
fn carrier<T: Real>(weight: &[T], node: usize) -> usize {
    if weight.get(node + 1).is_some_and(|&w| w != T::ZERO) { node + 1 } else { node }
}

/// What a link leaves to the next one below.
struct Above<T> {
    /// Moment of the spring between them, N·mm, and how much the stretch has softened that spring, N·mm.
    moment: T,
    softer: T,
    /// Second derivative of the spring with both angles, N·mm; slope t ∂(½q)/∂θ at its start, mm.
    coupling: T,
    slope: T,
    /// What the spring's shortening adds to the lower link's lever, mm.
    lever: [T; 2],
}

/// A member on the way from its end to its start.
struct Walk<'a, T> {
    /// The rows that touch the links still to come, and the next node at which they change the force.
    rows: &'a [Row<T>],
    touching: usize,
    /// What rows that touch a link short of its end pull at those below it only, N; the inverse length of a link.
    owed: [T; 2],
    inverse: T,
    /// Force through the present link, N.
    force: [T; 2],
    compliance: [T; 2],
    stiffening: T,
    /// Half the inverse length of a link, 1/mm.
    share: T,
    above: Above<T>,
    /// Σ d and Σ e eₓ: the chord and the inertia per link's length.
    chord: [T; 2],
    inertia: [T; 2],
}

impl<T: Real> Walk<'_, T> {
    /// Takes the rows off that touch a link or one above it: contacts pull at the whole of their link and of those below it.
    #[inline(always)]
    fn pass(&mut self, node: usize) {
        if self.touching >= node {
            self.meet(node);
        }
    }

    #[inline(always)]
    fn meet(&mut self, node: usize) {
        let [x, y] = core::mem::replace(&mut self.owed, [T::ZERO; 2]);
        self.force = [self.force[0] - x, self.force[1] - y];
        let mut is_owed = false;
        while self.topmost() >= node
            && let Some((row, rest)) = self.rows.split_last()
        {
            let pull = row.normal.map(|n| row.multiplier * n);
            let part = row.place.weights[1] * self.inverse;
            if part == T::ZERO {
                self.force = [self.force[0] - pull[0], self.force[1] - pull[1]];
            } else {
                let [x, y] = self.owed;
                let left = T::one() - part;
                self.force = [self.force[0] - part * pull[0], self.force[1] - part * pull[1]];
                self.owed = [x + left * pull[0], y + left * pull[1]];
                is_owed = true;
            }
            self.rows = rest;
        }
        // What is owed is due at the next link.
        self.touching = if is_owed { node - 1 } else { self.topmost() };
    }

    fn topmost(&self) -> usize {
        self.rows.last().map_or(0, |row| {
            // A place short of a link's end has the link below it whole.
            usize::from(row.place.node) + usize::from(row.place.weights[1] != T::ZERO)
        })
    }

    /// Strained direction of an end, which has no length.
    #[inline(always)]
    fn end<P: Past<T>, const RIGID: bool>(&self, e: [T; 2], prior: [T; 2]) -> [T; 2] {
        strained::<T, P, RIGID>(e, T::ZERO, self.force, self.compliance, T::ZERO, prior).direction
    }

    /// One link of length w and the spring of stiffness k below it, over which the angle grows by `bend`; returns the gradient.
    /// `end` is an end without a weight above it, and what belongs to the spring that leads there; `prior` what the past adds, to the
    /// moments of both springs and to the forces along and across.
    #[inline(always)]
    fn link<D: Depth, P: Past<T>, const RIGID: bool>(
        &mut self,
        node: &mut Node<T>,
        w: T,
        k: T,
        bend: T,
        end: Option<(&mut Node<T>, T, T)>,
        [prior, above, along, across]: [T; 4],
    ) -> T {
        let (zero, two, t) = (T::ZERO, T::of(2.0), self.stiffening);
        let e = node.e;
        // The moment that bends it, and what the stretch adds to it per f·e.
        let moment = k * bend;
        let slope = if RIGID { zero } else { t * moment };
        let mut shorter = if RIGID { zero } else { self.share * (slope * bend) };
        if let Some((_, k, bend)) = &end
            && !RIGID
        {
            shorter += self.share * (t * (*k * *bend) * *bend);
        }
        let on = strained::<T, P, RIGID>(e, w, self.force, self.compliance, -shorter, [along, across]);
        node.strained = on.direction;
        for i in 0..2 {
            self.chord[i] += on.direction[i];
        }
        if !D::GRADIENT {
            return zero;
        }
        let [pull, across] = on.pull;
        if let Some((end, k, bend)) = end {
            let slope = t * (k * bend);
            let (softer, cross) = (-(t * pull * k), across * slope);
            let shift = [slope * e[0], slope * e[1]];
            self.above = Above {
                moment: if P::IS_ANY { (k + softer) * bend + above } else { (k + softer) * bend },
                softer: softer + two * cross,
                coupling: k + softer + cross,
                slope,
                lever: [-shift[0], -shift[1]],
            };
            end.gradient = -self.above.moment;
            if D::TANGENT {
                (end.curvature, end.lever) = (softer, shift);
            }
        }
        let moment = if RIGID { moment } else { moment - slope * pull };
        let moment = if P::IS_ANY { moment + prior } else { moment };
        let gradient = on.gradient + self.above.moment - moment;
        node.gradient = gradient;
        if D::TANGENT {
            let above = &self.above;
            node.set_next_coupling(above.coupling);
            node.bent[0] = above.slope;
            if RIGID {
                (node.lever, node.curvature) = (on.lever, on.curvature);
                self.above.coupling = k;
            } else {
                let softer = -(t * pull * k);
                let cross = across * slope;
                let shift = [slope * e[0], slope * e[1]];
                node.lever = [on.lever[0] + shift[0] + above.lever[0], on.lever[1] + shift[1] + above.lever[1]];
                node.curvature = on.curvature + above.softer + (softer - two * cross);
                let coupling = k + softer - cross;
                self.above = Above { moment, softer, coupling, slope, lever: [-shift[0], -shift[1]] };
                self.inertia = [self.inertia[0] + e[0] * e[0], self.inertia[1] + e[0] * e[1]];
            }
        }
        self.above.moment = moment;
        gradient
    }
}

fn walk<T: Real, D: Depth, P: Past<T>, const RIGID: bool>(
    of: Constants<'_, T>,
    past: P,
    angle: &[T],
    rows: &[Row<T>],
    nodes: &mut [Node<T>],
    out: &mut Strain<T>,
) {
    let (member, spring) = (of.member, of.coupling);
    let first = member.nodes().start;
    let (Some((_, weight)), Some((start, list))) = (of.weight.split_first(), nodes.split_first_mut()) else { return };
    let zero = T::ZERO;
    // All links of a member are of one length; where there is none, it is a pin or what stands for a weld.
    let length = weight.first().copied().unwrap_or(zero);
    let mut walk = Walk {
        rows,
        touching: 0,
        owed: [zero; 2],
        inverse: if length == zero { zero } else { T::one() / length },
        force: out.force,
        compliance: member.compliance,
        stiffening: member.stiffening,
        share: if RIGID || length == zero { zero } else { T::of(0.5) / length },
        above: Above { moment: zero, softer: zero, coupling: zero, slope: zero, lever: [zero; 2] },
        chord: [zero; 2],
        inertia: [zero; 2],
    };
    walk.touching = walk.topmost();

    // An end without a weight has an angle only; its spring is carried by the link below it.
    let weightless = weight.last() == Some(&zero);
    let links = list.len() - usize::from(weightless);
    let (Some(lower), Some(upper), Some(stiffness), Some(weight), Some((list, beyond))) = (
        angle.get(..links),
        angle.get(1..=links),
        spring.get(..links),
        weight.get(..links),
        list.split_at_mut_checked(links),
    ) else {
        return;
    };
    let mut end = None;
    if let (Some(top), Some(&[below, theta])) = (beyond.first_mut(), angle.last_chunk::<2>()) {
        walk.pass(first + links + 1);
        top.strained = walk.end::<P, RIGID>(top.e, past.forces(links + 1));
        let (k, bend) = (spring.at(links)[0], theta - below);
        if D::TANGENT {
            top.set_coupling([zero; 2]);
            top.bent = [zero; 2];
        }
        if links == 0 && D::GRADIENT {
            // No link at all.
            let moment = if P::IS_ANY { k * bend + past.moment(0) } else { k * bend };
            (walk.above.moment, walk.above.coupling) = (moment, k);
            (top.gradient, top.curvature, top.lever) = (-moment, zero, [zero; 2]);
        }
        end = Some((top, k, bend));
    }
    let mut steepest = zero;
    // Of a link: the spring below it, the one above it, the link itself.
    let prior = |j: usize| {
        let [along, across] = past.forces(j + 1);
        [past.moment(j), past.moment(j + 1), along, across]
    };
    let angles = lower.iter().zip(upper);
    let mut each = list.iter_mut().zip(weight).zip(stiffness).zip(angles).enumerate().rev();
    if let Some((j, (((node, &w), &[k, _]), (&below, &theta)))) = each.next() {
        walk.pass(first + j + 1);
        let gradient = walk.link::<D, P, RIGID>(node, w, k, theta - below, end, prior(j));
        // Of the nodes at the end, only one with another above it is an interior one.
        if weightless {
            steepest = gradient.abs();
        }
    }
    for (j, (((node, &w), &[k, _]), (&below, &theta))) in each {
        walk.pass(first + j + 1);
        let gradient = walk.link::<D, P, RIGID>(node, w, k, theta - below, None, prior(j));
        steepest = gradient.abs().max(steepest);
    }
    start.strained = walk.end::<P, RIGID>(start.e, past.forces(0));
    out.chord = walk.chord.map(|sum| length * sum);
    if !D::GRADIENT {
        return;
    }
    let above = walk.above;
    start.gradient = above.moment;
    out.steepest = steepest;
    if D::TANGENT {
        (start.lever, start.curvature) = (above.lever, above.softer);
        start.set_next_coupling(above.coupling);
        start.bent[0] = above.slope;
        let ([stretch, shear], [xx, xy]) = (member.compliance, walk.inertia.map(|sum| length * sum));
        let yy = length * T::of(links as f64) - xx;
        out.compliance = if RIGID {
            [zero; 3]
        } else {
            [-(stretch * xx + shear * yy), (shear - stretch) * xy, -(stretch * yy + shear * xx)]
        };
    }
}
