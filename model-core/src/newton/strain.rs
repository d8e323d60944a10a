//! Kinematics: directions of the links, the forces through them, and what those do to them.

use super::{MemberWork, Workspace};
use crate::contact::Row;
use crate::ladder::{CLAMPED, Ladder, State, turned};
use crate::real::Real;
use crate::size::Size;

/// End-to-end vector Σ l d + rigid parts of a member, mm.
#[inline]
pub(crate) fn end_to_end<T: Real>(work: &MemberWork<T>) -> [T; 2] {
    [work.chord[0] + work.rigid_start[0] + work.rigid_end[0], work.chord[1] + work.rigid_start[1] + work.rigid_end[1]]
}

/// Directions of all links and turned rigid parts.
pub(crate) fn directions<T: Real, S: Size>(ladder: &Ladder<T, S>, state: &State<T, S>, work: &mut Workspace<T, S>) {
    let angle = state.angle.as_ref();
    let members = &ladder.members.as_ref()[..ladder.member_count()];
    let turn = work.turn.as_mut();
    for (index, member) in members.iter().enumerate() {
        // Each joint ends one of these; the back spans' ends are needed where the back beam has an angle of its own.
        if index % 4 != 1 || index + 1 < members.len() {
            let (s, c) = angle[member.nodes().end - 1].sin_cos();
            turn[usize::from(member.end)] = [c, s];
        }
    }
    let (e, direction) = (work.e.as_mut(), ladder.direction.as_ref());
    for (member, out) in members.iter().zip(work.members.as_mut()) {
        let nodes = member.nodes();
        let start = if member.start == CLAMPED { [T::one(), T::ZERO] } else { turn[usize::from(member.start)] };
        let end = turn[usize::from(member.end)];
        e[nodes.start] = turned(direction[nodes.start], start[0], start[1]);
        for node in nodes.start + 1..nodes.end - 1 {
            let (s, c) = angle[node].sin_cos();
            e[node] = turned(direction[node], c, s);
        }
        e[nodes.end - 1] = turned(direction[nodes.end - 1], end[0], end[1]);
        out.rigid_start = turned(member.rigid_start, start[0], start[1]);
        out.rigid_end = turned(member.rigid_end, end[0], end[1]);
    }
}

/// Starts of the front spans from their end-to-end vectors.
pub(crate) fn starts<T: Real, S: Size>(ladder: &Ladder<T, S>, work: &mut Workspace<T, S>) {
    let mut position = ladder.base;
    for cell in 0..ladder.cells {
        work.start.as_mut()[cell] = position;
        let d = end_to_end(&work.members.as_ref()[4 * cell]);
        position = [position[0] + d[0], position[1] + d[1]];
    }
}

/// Closure errors from the members' end-to-end vectors.
pub(crate) fn closures<T: Real, S: Size>(ladder: &Ladder<T, S>, work: &mut Workspace<T, S>) {
    let mut rung = ladder.base_rung;
    let members = work.members.as_ref();
    for cell in 0..ladder.cells {
        let (front, back) = (end_to_end(&members[4 * cell]), end_to_end(&members[4 * cell + 1]));
        let next = if cell + 1 < ladder.cells {
            let (f, b) = (end_to_end(&members[4 * cell + 2]), end_to_end(&members[4 * cell + 3]));
            [f[0] + b[0], f[1] + b[1]]
        } else {
            [T::ZERO; 2]
        };
        let rest = ladder.rest.as_ref()[cell];
        for i in 0..2 {
            work.closure.as_mut()[cell][i] = front[i] - back[i] + (next[i] - rung[i]) - rest[i];
        }
        rung = next;
    }
}

/// The rows that touch a front span, in order; `from` is where to begin to look.
#[inline]
pub(crate) fn own_rows<T: Real, S: Size>(
    ladder: &Ladder<T, S>,
    rows: &[Row<T>],
    index: usize,
    from: usize,
) -> core::ops::Range<usize> {
    let mut end = from;
    if index.is_multiple_of(4) {
        let samples = ladder.samples.as_ref();
        while end < rows.len() && usize::from(samples[usize::from(rows[end].sample)].cell) == index / 4 {
            end += 1;
        }
    }
    from..end
}

/// What a force does to a link or node of weight w and direction e that bending shortens by η.
///
/// With f the force per weight, a = f·e, b = f·e′, k = 1/EA − 1/κGA: ψ = (1 − η) a − ½(a²/EA + b²/κGA), d = ∂ψ/∂f, and the node
/// adds w ψ to the Lagrangian.
struct Strained<T> {
    /// Strained direction d, and w times its derivative with respect to the angle.
    direction: [T; 2],
    lever: [T; 2],
    /// First derivative of w ψ with respect to the angle, and the second with its sign changed, N·mm.
    gradient: T,
    curvature: T,
    /// The energy of stretch and shear, twice.
    energy: T,
    /// f·e and f·e′.
    pull: [T; 2],
}

#[inline(always)]
fn strained<T: Real, const RIGID: bool>(
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
        let energy = T::ZERO;
        let lever = [-(w * y), w * x];
        return Strained { direction: e, lever, gradient: w * b, curvature: w * a, energy, pull: [a, b] };
    }
    let k = stretch - shear;
    let whole = T::one() - shorter;
    let (p, q) = (whole - stretch * a, shear * b);
    let (r, t) = (whole - k * a, k * b);
    Strained {
        direction: [x * p + q * y, y * p - q * x],
        lever: [-(w * (y * r + t * x)), w * (x * r - t * y)],
        gradient: w * b * r,
        curvature: w * (a * r + b * t),
        energy: w * (stretch * a * a + shear * b * b),
        pull: [a, b],
    }
}

/// Strains a member: directions, their derivatives, the force's part of the gradient and of its diagonal, the chord and the
/// compliance of the force with itself.
pub(crate) fn strain<T: Real, S: Size>(
    ladder: &Ladder<T, S>,
    work: &mut Workspace<T, S>,
    index: usize,
    own: core::ops::Range<usize>,
) {
    if ladder.members.as_ref()[index].compliance == [T::ZERO; 2] {
        strain_all::<T, S, true>(ladder, work, index, own);
    } else {
        strain_all::<T, S, false>(ladder, work, index, own);
    }
}

fn strain_all<T: Real, S: Size, const RIGID: bool>(
    ladder: &Ladder<T, S>,
    work: &mut Workspace<T, S>,
    index: usize,
    own: core::ops::Range<usize>,
) {
    let member = &ladder.members.as_ref()[index];
    let nodes = member.nodes();
    let samples = ladder.samples.as_ref();
    let out = &mut work.members.as_mut()[index];
    let rows = &work.rows.as_ref()[..work.row_count];
    let mut carried = out.force;
    let mut next = own.end;
    let mut chord = [T::ZERO; 2];
    // Σ w e eᵀ.
    let mut inertia = [T::ZERO; 3];
    let mut energy = T::ZERO;
    let input = ladder.weight.as_ref()[nodes.clone()].iter().zip(&work.e.as_ref()[nodes.clone()]);
    let directions = work.strained.as_mut()[nodes.clone()].iter_mut().zip(&mut work.lever.as_mut()[nodes.clone()]);
    let slopes = work.gradient.as_mut()[nodes.clone()].iter_mut().zip(&mut work.curvature.as_mut()[nodes.clone()]);
    let pulls = work.bent.as_ref()[nodes.clone()].iter().zip(&mut work.coupling.as_mut()[nodes.clone()]);
    let all = nodes.zip(input).zip(directions.zip(slopes)).zip(pulls);
    for (((node, (&w, &e)), ((direction, lever), (gradient, curvature))), (bent, pull)) in all.rev() {
        let mut force = carried;
        if next > own.start {
            // Contacts beyond this node pull the whole of it, those at it a part.
            while next > own.start && usize::from(samples[usize::from(rows[next - 1].sample)].node) > node {
                next -= 1;
                let row = &rows[next];
                carried = [carried[0] - row.multiplier * row.normal[0], carried[1] - row.multiplier * row.normal[1]];
            }
            force = carried;
            if w != T::ZERO {
                for row in &rows[own.start..next] {
                    let sample = &samples[usize::from(row.sample)];
                    if let Some(&part) = sample.weights.get(node - usize::from(sample.node)) {
                        let share = row.multiplier * part / w;
                        force = [force[0] - share * row.normal[0], force[1] - share * row.normal[1]];
                    }
                }
            }
        }
        let shorter = if RIGID { T::ZERO } else { bent[1] };
        let node = strained::<T, RIGID>(e, w, force, member.compliance, shorter);
        *direction = node.direction;
        chord = [chord[0] + w * node.direction[0], chord[1] + w * node.direction[1]];
        *lever = node.lever;
        if !RIGID {
            *pull = node.pull;
        }
        *gradient = node.gradient;
        *curvature = node.curvature;
        if !RIGID {
            let (wx, wy) = (w * e[0], w * e[1]);
            inertia = [inertia[0] + wx * e[0], inertia[1] + wx * e[1], inertia[2] + wy * e[1]];
            energy += node.energy;
        }
    }
    out.chord = chord;
    let ([stretch, shear], [xx, xy, yy]) = (member.compliance, inertia);
    out.give = [-(stretch * xx + shear * yy), (shear - stretch) * xy, -(stretch * yy + shear * xx)];
    out.strain_energy = T::of(0.5) * energy;
}

/// Forces, and the front spans strained and placed, so that gaps can be measured.
pub(crate) fn place_front<T: Real, S: Size>(ladder: &Ladder<T, S>, state: &State<T, S>, work: &mut Workspace<T, S>) {
    forces(ladder, state, work);
    let mut from = 0;
    for cell in 0..ladder.cells {
        let own = own_rows(ladder, &work.rows.as_ref()[..work.row_count], 4 * cell, from);
        from = own.end;
        strain(ladder, work, 4 * cell, own);
    }
    starts(ladder, work);
}

/// Forces through the members: front λ_k − load − Σ μ n above, back −λ_k, rung λ_k − λ_{k+1}.
pub(crate) fn forces<T: Real, S: Size>(ladder: &Ladder<T, S>, state: &State<T, S>, work: &mut Workspace<T, S>) {
    let samples = ladder.samples.as_ref();
    let mut sum = [T::ZERO; 2];
    let mut row = work.row_count;
    let lambda = state.lambda.as_ref();
    for cell in (0..ladder.cells).rev() {
        if cell == state.load_cell {
            // A dead load acts like a contact just above this span.
            sum = [sum[0] + state.load[0], sum[1] + state.load[1]];
        }
        work.above.as_mut()[cell] = sum;
        let (l, members) = (lambda[cell], work.members.as_mut());
        let front = [l[0] - sum[0], l[1] - sum[1]];
        (members[4 * cell].force, members[4 * cell].end_force) = (front, front);
        let back = [-l[0], -l[1]];
        (members[4 * cell + 1].force, members[4 * cell + 1].end_force) = (back, back);
        if cell + 1 < ladder.cells {
            let next = lambda[cell + 1];
            let rung = [l[0] - next[0], l[1] - next[1]];
            for hinge in 2..4 {
                (members[4 * cell + hinge].force, members[4 * cell + hinge].end_force) = (rung, rung);
            }
        }
        while row > 0 && usize::from(samples[usize::from(work.rows.as_ref()[row - 1].sample)].cell) == cell {
            row -= 1;
            let touching = &work.rows.as_ref()[row];
            let part = samples[usize::from(touching.sample)].rigid;
            for i in 0..2 {
                let f = touching.multiplier * touching.normal[i];
                sum[i] += f;
                members[4 * cell].end_force[i] -= part * f;
            }
        }
    }
}
