//! Kinematics: directions of the links, the forces through them, and what those do to them.

use super::{MemberWork, Node, Workspace, chain};
use crate::access::Access;
use crate::contact::Row;
use crate::ladder::{Ladder, turned};
use crate::real::Real;
use crate::size::Size;
use crate::state::State;

/// End-to-end vector Σ l d + rigid parts of a member, mm.
#[inline]
pub(crate) fn end_to_end<T: Real>(work: &MemberWork<T>) -> [T; 2] {
    [work.chord[0] + work.rigid_start[0] + work.rigid_end[0], work.chord[1] + work.rigid_start[1] + work.rigid_end[1]]
}

/// Increment of an angle up to which [`turn`] is exact, rad.
pub(crate) const SMALL: f64 = 1e-3;

/// Directions of all links and turned rigid parts.
pub(crate) fn directions<T: Real, S: Size>(ladder: &Ladder<T, S>, state: &State<T, S>, work: &mut Workspace<T, S>) {
    let (nodes, rest) = (work.nodes.as_mut(), ladder.direction.as_ref());
    // Joint angles come once per member that meets there: that is cheaper than to look for them.
    let count = ladder.node_count;
    let (angles, nodes) = (state.angle.as_ref().run(0..count), nodes.run_mut(0..count));
    T::turn_each(angles, nodes, rest.run(0..count), |node, &rest, sin, cos| node.e = turned(rest, cos, sin));
    rigid_parts(ladder, work);
}

/// Directions after an increment of the angles (the nodes' `delta`, none larger than [`SMALL`]): turned by it, at half the cost
/// of [`directions`].
pub(crate) fn turn<T: Real, S: Size>(ladder: &Ladder<T, S>, work: &mut Workspace<T, S>) {
    let (half, third) = (T::of(0.5), T::of(1.0 / 3.0));
    for node in work.nodes.as_mut().run_mut(0..ladder.node_count) {
        let [x, y] = node.e;
        let delta = node.delta;
        // 1 − cos δ to δ⁴ and sin δ to δ³, both within 1e-17 of the true ones.
        let z = half * (delta * delta);
        let (back, side) = (z - z * z * (half * third), delta - delta * (z * third));
        node.e = [x - (x * back + y * side), y + (x * side - y * back)];
    }
    rigid_parts(ladder, work);
}

/// Turned rigid parts of all members.
fn rigid_parts<T: Real, S: Size>(ladder: &Ladder<T, S>, work: &mut Workspace<T, S>) {
    let (nodes, rest) = (work.nodes.as_ref(), ladder.direction.as_ref());
    // A rigid part turns as the node at its end.
    let like = |part: [T; 2], node: usize| match (rest.get(node), nodes.get(node)) {
        (Some(&[x, y]), Some(&Node { e: [u, v], .. })) if part != [T::ZERO; 2] => {
            turned(part, x * u + y * v, x * v - y * u)
        }
        _ => [T::ZERO; 2],
    };
    for (member, out) in ladder.members().iter().zip(work.members.as_mut()) {
        out.rigid_start = like(member.rigid_start, usize::from(member.first));
        out.rigid_end = like(member.rigid_end, usize::from(member.first + member.interior) + 1);
    }
}

/// Starts of the front spans from their end-to-end vectors.
pub(crate) fn starts<T: Real, S: Size>(ladder: &Ladder<T, S>, work: &mut Workspace<T, S>) {
    let mut position = ladder.base;
    let fronts = work.members.as_ref().iter();
    for (start, front) in work.start.as_mut().iter_mut().zip(fronts).take(ladder.cells()) {
        *start = position;
        let d = end_to_end(front);
        position = [position[0] + d[0], position[1] + d[1]];
    }
}

/// Cell whose front span a row touches.
#[inline]
pub(crate) fn cell_of<T: Real>(row: &Row<T>) -> usize {
    usize::from(row.place.cell)
}

/// The rows that touch a member, in order: none but for the front spans; `from` is where to begin to look.
#[inline]
pub(crate) fn own_rows<T: Real>(rows: &[Row<T>], index: usize, from: usize) -> core::ops::Range<usize> {
    let above = rows.get(from..).unwrap_or(&[]);
    from..from + above.iter().take_while(|row| cell_of(row) == index).count()
}

/// What a force does to a link or node of weight w and direction e that bending shortens by η.
///
/// With f the force per weight, a = f·e, b = f·e′, k = 1/EA − 1/κGA: ψ = (1 − η) a − ½(a²/EA + b²/κGA), d = ∂ψ/∂f, and the node
/// adds w ψ to the Lagrangian.
pub(super) struct Strained<T> {
    /// Strained direction d, and w times its derivative with respect to the angle.
    pub direction: [T; 2],
    pub lever: [T; 2],
    /// First derivative of w ψ with respect to the angle, and the second with its sign changed, N·mm.
    pub gradient: T,
    pub curvature: T,
    /// f·e and f·e′.
    pub pull: [T; 2],
}

#[inline(always)]
pub(super) fn strained<T: Real, const RIGID: bool>(
    e: [T; 2],
    w: T,
    force: [T; 2],
    [stretch, shear]: [T; 2],
    shorter: T,
) -> Strained<T> {
    let [x, y] = e;
    let a = force[0] * x + force[1] * y;
    let b = force[1] * x - force[0] * y;
    if RIGID {
        let lever = [-(w * y), w * x];
        return Strained { direction: e, lever, gradient: w * b, curvature: w * a, pull: [a, b] };
    }
    let k = stretch - shear;
    let whole = T::one() - shorter;
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

/// Strains a member: directions, their derivatives, the force's part of the gradient and of its diagonal, the chord and the
/// compliance of the force with itself; a chain of links gets its bending moments as well.
///
/// Of chains of links no more than `DEPTH` says (see [`chain::DEEP`]).
// Long and called once per member: a copy at every call would cost flash and spare nothing.
#[inline(never)]
pub(crate) fn strain<T: Real, S: Size, const DEPTH: u8>(
    ladder: &Ladder<T, S>,
    state: &State<T, S>,
    work: &mut Workspace<T, S>,
    index: usize,
    own: core::ops::Range<usize>,
) {
    let Some(member) = ladder.member(index) else { return };
    if !ladder.quadratic {
        chain::strain::<T, S, DEPTH>(ladder, state, work, index, own);
    } else if member.compliance == [T::ZERO; 2] {
        strain_all::<T, S, true>(ladder, work, index, own);
    } else {
        strain_all::<T, S, false>(ladder, work, index, own);
    }
}

/// Forces through a member's nodes, from its end to its start.
struct Walk<'a, T> {
    /// Touching samples on the member, base to tip; those beyond the present node are taken off.
    own: &'a [Row<T>],
    carried: [T; 2],
}

impl<T: Real> Walk<'_, T> {
    /// Force per weight through a node of weight w: contacts beyond the node pull the whole of it, those at it a part.
    #[inline(always)]
    fn force(&mut self, node: usize, w: T) -> [T; 2] {
        let mut force = self.carried;
        if self.own.is_empty() {
            return force;
        }
        while let Some((row, below)) = self.own.split_last()
            && usize::from(row.place.node) > node
        {
            self.own = below;
            force = [force[0] - row.multiplier * row.normal[0], force[1] - row.multiplier * row.normal[1]];
        }
        self.carried = force;
        if w != T::ZERO {
            for row in self.own {
                let part = row.place.weights.get(node.wrapping_sub(usize::from(row.place.node)));
                if let Some(&part) = part {
                    let share = row.multiplier * part / w;
                    force = [force[0] - share * row.normal[0], force[1] - share * row.normal[1]];
                }
            }
        }
        force
    }
}

/// A member's walk; `own` are its rows.
fn walk<T: Real>(rows: &[Row<T>], force: [T; 2], own: core::ops::Range<usize>) -> Walk<'_, T> {
    Walk { own: rows.get(own).unwrap_or(&[]), carried: force }
}

fn strain_all<T: Real, S: Size, const RIGID: bool>(
    ladder: &Ladder<T, S>,
    work: &mut Workspace<T, S>,
    index: usize,
    own: core::ops::Range<usize>,
) {
    let (Some(member), Some(out)) = (ladder.member(index), work.members.as_mut().get_mut(index)) else {
        return;
    };
    let nodes = member.nodes();
    let mut walk = walk(work.rows.as_ref(), out.force, own);
    let mut chord = [T::ZERO; 2];
    // Σ w e eᵀ.
    let mut inertia = [T::ZERO; 3];
    let (Some(weight), Some(list)) =
        (ladder.weight.as_ref().get(nodes.clone()), work.nodes.as_mut().get_mut(nodes.clone()))
    else {
        return;
    };
    for ((index, &w), node) in nodes.zip(weight).zip(list).rev() {
        let shorter = if RIGID { T::ZERO } else { node.bent[1] };
        let e = node.e;
        let strained = strained::<T, RIGID>(e, w, walk.force(index, w), member.compliance, shorter);
        node.strained = strained.direction;
        chord = [chord[0] + w * strained.direction[0], chord[1] + w * strained.direction[1]];
        node.lever = strained.lever;
        node.gradient = strained.gradient;
        node.curvature = strained.curvature;
        if !RIGID {
            node.coupling = strained.pull;
            let (wx, wy) = (w * e[0], w * e[1]);
            inertia = [inertia[0] + wx * e[0], inertia[1] + wx * e[1], inertia[2] + wy * e[1]];
        }
    }
    out.chord = chord;
    let ([stretch, shear], [xx, xy, yy]) = (member.compliance, inertia);
    out.give = [-(stretch * xx + shear * yy), (shear - stretch) * xy, -(stretch * yy + shear * xx)];
}

/// Energy of stretch and shear of a strained ladder, N·mm.
pub(crate) fn energy<T: Real, S: Size>(ladder: &Ladder<T, S>, work: &Workspace<T, S>) -> T {
    let rows = work.rows.as_ref().run(0..work.row_count);
    let (mut from, mut twice) = (0, T::ZERO);
    for (index, (member, out)) in ladder.members().iter().zip(work.members.as_ref()).enumerate() {
        let own = own_rows(rows, index, from);
        from = own.end;
        let mut walk = walk(rows, out.force, own);
        let [stretch, shear] = member.compliance;
        for node in member.nodes().rev() {
            let (Some(&w), Some(&[x, y])) =
                (ladder.weight.as_ref().get(node), work.nodes.as_ref().get(node).map(|node| &node.e))
            else {
                continue;
            };
            let force = walk.force(node, w);
            let (a, b) = (force[0] * x + force[1] * y, force[1] * x - force[0] * y);
            twice += w * (stretch * a * a + shear * b * b);
        }
    }
    T::of(0.5) * twice
}

/// Forces, and the front spans strained and placed, so that gaps can be measured.
pub(crate) fn place_front<T: Real, S: Size, const DEPTH: u8>(
    ladder: &Ladder<T, S>,
    state: &State<T, S>,
    work: &mut Workspace<T, S>,
) {
    forces(ladder, state, work);
    let mut from = 0;
    for cell in 0..ladder.cells() {
        let own = own_rows(work.rows.as_ref().run(0..work.row_count), cell, from);
        from = own.end;
        strain::<T, S, DEPTH>(ladder, state, work, cell, own);
    }
    starts(ladder, work);
}

/// Forces through the members (15): the multipliers of the closures that a member's vector enters, and in a front span less the load and
/// Σ μ n of the contacts above.
pub(crate) fn forces<T: Real, S: Size>(ladder: &Ladder<T, S>, state: &State<T, S>, work: &mut Workspace<T, S>) {
    let lambda = state.lambda.as_ref();
    let members = work.members.as_mut();
    for (member, out) in ladder.members().iter().zip(&mut *members) {
        let mut force = [T::ZERO; 2];
        for term in member.terms() {
            let [x, y] = lambda.at(usize::from(term.closure));
            force = [force[0] + term.sign * x, force[1] + term.sign * y];
        }
        (out.force, out.end_force) = (force, force);
    }
    let mut sum = [T::ZERO; 2];
    let mut rows = work.rows.as_ref().run(0..work.row_count);
    let fronts = members.iter_mut().zip(work.above.as_mut()).take(ladder.cells()).enumerate();
    for (cell, (front, above)) in fronts.rev() {
        if cell == state.load_cell {
            // A dead load acts like a contact just above this span.
            sum = [sum[0] + state.load[0], sum[1] + state.load[1]];
        }
        *above = sum;
        front.force = [front.force[0] - sum[0], front.force[1] - sum[1]];
        front.end_force = front.force;
        while let Some((touching, below)) = rows.split_last()
            && cell_of(touching) == cell
        {
            rows = below;
            let part = touching.place.rigid;
            for i in 0..2 {
                let f = touching.multiplier * touching.normal[i];
                sum[i] += f;
                front.end_force[i] -= part * f;
            }
        }
    }
}
