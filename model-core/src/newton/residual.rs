//! Kinematics, gaps, forces and the gradient of the Lagrangian
//! L = V(θ, s) + Σ λ_k·h_k − Σ μ_j g_j − ½ ε_c Σ μ_j².

use super::{MemberWork, Workspace};
use crate::contact::{Row, sample_gap};
use crate::ladder::{CLAMPED, Ladder, State, turned, vec2_of};
use crate::object::Object;
use crate::real::{Real, Vec2};
use crate::size::Size;

/// Largest components of what must vanish at an equilibrium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Residual<T> {
    /// Gradient with respect to angles and stretches, N·mm.
    pub gradient: T,
    /// Closure errors, errors g + ε_c μ of touching samples, penetration of the others, mm.
    pub length: T,
}

/// What a sweep over the samples found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sweep<T> {
    /// Smallest gap of all samples, mm.
    pub nearest: T,
    /// Normal there, out of the object.
    pub normal: [T; 2],
    /// Smallest gap of the samples that did not touch before, mm.
    pub nearest_free: T,
    /// Some sample that penetrates found no room among the rows.
    pub overflow: bool,
    /// Some sample that is only near found no room.
    pub crowded: bool,
}

/// End-to-end vector σ·S + rigid parts of a member, mm.
#[inline]
pub(crate) fn end_to_end<T: Real>(work: &MemberWork<T>, stretch: T) -> [T; 2] {
    let sigma = T::one() + stretch;
    [
        sigma * work.chord[0] + work.rigid_start[0] + work.rigid_end[0],
        sigma * work.chord[1] + work.rigid_start[1] + work.rigid_end[1],
    ]
}

/// Directions, chords, closures and the starts of the front spans.
pub(crate) fn kinematics<T: Real, S: Size>(ladder: &Ladder<T, S>, state: &State<T, S>, work: &mut Workspace<T, S>) {
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
    let (e, weight, direction) = (work.e.as_mut(), ladder.weight.as_ref(), ladder.direction.as_ref());
    for (member, out) in members.iter().zip(work.members.as_mut()) {
        let nodes = member.nodes();
        let (first, last) = (nodes.start, nodes.end - 1);
        let start = if member.start == CLAMPED { [T::one(), T::ZERO] } else { turn[usize::from(member.start)] };
        let end = turn[usize::from(member.end)];
        let mut chord = [T::ZERO; 2];
        for node in nodes {
            let [c, s] = if node == first {
                start
            } else if node == last {
                end
            } else {
                let (s, c) = angle[node].sin_cos();
                [c, s]
            };
            let v = turned(direction[node], c, s);
            e[node] = v;
            chord[0] += weight[node] * v[0];
            chord[1] += weight[node] * v[1];
        }
        out.chord = chord;
        out.rigid_start = turned(member.rigid_start, start[0], start[1]);
        out.rigid_end = turned(member.rigid_end, end[0], end[1]);
    }
    let mut position = ladder.base;
    let mut rung = ladder.base_rung;
    let vector = |index: usize| end_to_end(&work.members.as_ref()[index], state.stretch.as_ref()[index]);
    for cell in 0..ladder.cells {
        work.start.as_mut()[cell] = position;
        let (front, back) = (vector(4 * cell), vector(4 * cell + 1));
        let next = if cell + 1 < ladder.cells {
            let (f, b) = (vector(4 * cell + 2), vector(4 * cell + 3));
            [f[0] + b[0], f[1] + b[1]]
        } else {
            [T::ZERO; 2]
        };
        let rest = ladder.rest.as_ref()[cell];
        for i in 0..2 {
            work.closure.as_mut()[cell][i] = front[i] - back[i] + (next[i] - rung[i]) - rest[i];
            position[i] += front[i];
        }
        rung = next;
    }
}

/// Finds the gaps of all samples and makes the contact rows: samples that touched before and those nearer than `margin`.
///
/// A sample that is only near gives way when there is no room; one that touches or penetrates never does silently.
pub(crate) fn sweep<T: Real, S: Size, O: Object<T>>(
    ladder: &Ladder<T, S>,
    state: &State<T, S>,
    work: &mut Workspace<T, S>,
    object: &O,
    margin: T,
) -> Sweep<T> {
    let samples = &ladder.samples.as_ref()[..ladder.sample_count];
    let (e, weight) = (work.e.as_ref(), ladder.weight.as_ref());
    let (starts, members) = (work.start.as_ref(), work.members.as_ref());
    let rows = work.rows.as_mut();
    let mut count = 0;
    let far = T::of(1e9);
    let mut found = Sweep { nearest: far, normal: [T::ZERO; 2], nearest_free: far, overflow: false, crowded: false };
    let mut touching = 0;
    let mut cell = usize::MAX;
    let mut node = 0;
    let mut prefix = Vec2::new(T::ZERO, T::ZERO);
    for (index, sample) in samples.iter().enumerate() {
        if cell != usize::from(sample.cell) {
            cell = usize::from(sample.cell);
            node = usize::from(ladder.members.as_ref()[4 * cell].first);
            prefix = Vec2::new(T::ZERO, T::ZERO);
        }
        while node < usize::from(sample.node) {
            prefix += vec2_of(e[node]) * weight[node];
            node += 1;
        }
        let mut local = prefix;
        for (k, &w) in sample.weights.iter().enumerate() {
            if w != T::ZERO {
                local += vec2_of(e[node + k]) * w;
            }
        }
        let sigma = T::one() + state.stretch.as_ref()[4 * cell];
        let position = vec2_of(starts[cell]) + local * sigma + vec2_of(members[4 * cell].rigid_end) * sample.rigid;
        let gap = sample_gap(object, sample, position);
        if gap.distance < found.nearest {
            found.nearest = gap.distance;
            found.normal = [gap.normal.x, gap.normal.y];
        }
        let multiplier = if touching < state.touching_count && usize::from(state.touching.as_ref()[touching]) == index {
            touching += 1;
            Some(state.multiplier.as_ref()[touching - 1])
        } else {
            found.nearest_free = found.nearest_free.min(gap.distance);
            None
        };
        if multiplier.is_none() && gap.distance > margin {
            continue;
        }
        // Room is kept for the samples that touch further up the beam.
        let reserved = state.touching_count - touching;
        if multiplier.is_none() && count + reserved >= S::CONTACTS {
            found.overflow |= gap.distance < T::ZERO;
            found.crowded = true;
            continue;
        }
        rows[count] = Row {
            sample: index as u16,
            gap: gap.distance,
            normal: [gap.normal.x, gap.normal.y],
            curvature: gap.curvature,
            softness: ladder.softness,
            multiplier: multiplier.unwrap_or(T::ZERO),
        };
        count += 1;
    }
    work.row_count = count;
    found
}

/// Forces through the members: front λ_k − load − Σ μ n above, back −λ_k, rung λ_k − λ_{k+1}.
fn forces<T: Real, S: Size>(ladder: &Ladder<T, S>, state: &State<T, S>, work: &mut Workspace<T, S>) {
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

/// Gradient and geometric softening at every node; returns the largest residuals.
pub(crate) fn gradient<T: Real, S: Size>(
    ladder: &Ladder<T, S>,
    state: &State<T, S>,
    work: &mut Workspace<T, S>,
    sweep: &Sweep<T>,
) -> Residual<T> {
    forces(ladder, state, work);
    let rows = &work.rows.as_ref()[..work.row_count];
    let samples = ladder.samples.as_ref();
    let angle = state.angle.as_ref();
    let (e, weight, coupling) = (work.e.as_ref(), ladder.weight.as_ref(), ladder.coupling.as_ref());
    let (push, gradient, curvature) = (work.push.as_mut(), work.gradient.as_mut(), work.curvature.as_mut());
    let mut worst = Residual { gradient: T::ZERO, length: T::ZERO };
    let joints = work.rhs.as_mut();
    joints[..ladder.unknowns()].fill(T::ZERO);
    let mut row_start = 0;
    for (index, member) in ladder.members.as_ref()[..ladder.member_count()].iter().enumerate() {
        let out = &mut work.members.as_mut()[index];
        let nodes = member.nodes();
        let stretch = state.stretch.as_ref()[index];
        let sigma = T::one() + stretch;
        let mut row_end = row_start;
        if index % 4 == 0 {
            while row_end < rows.len() && usize::from(samples[usize::from(rows[row_end].sample)].cell) == index / 4 {
                row_end += 1;
            }
        }
        let own = &rows[row_start..row_end];
        row_start = row_end;
        let mut force = out.force;
        let mut next = own.len();
        for node in nodes.clone().rev() {
            // Contacts beyond this node pull the whole of it.
            while next > 0 && usize::from(samples[usize::from(own[next - 1].sample)].node) > node {
                next -= 1;
                force[0] -= own[next].multiplier * own[next].normal[0];
                force[1] -= own[next].multiplier * own[next].normal[1];
            }
            let ([x, y], w) = (e[node], weight[node]);
            push[node] = w * (force[1] * x - force[0] * y);
            curvature[node] = w * (force[0] * x + force[1] * y);
        }
        let mut stretch_gradient = T::ZERO;
        for row in own {
            let sample = &samples[usize::from(row.sample)];
            let node = usize::from(sample.node);
            let f = [row.multiplier * row.normal[0], row.multiplier * row.normal[1]];
            for (k, &w) in sample.weights.iter().enumerate() {
                if w != T::ZERO {
                    let [x, y] = e[node + k];
                    push[node + k] -= w * (f[1] * x - f[0] * y);
                    curvature[node + k] -= w * (f[0] * x + f[1] * y);
                }
            }
        }
        for node in nodes.clone() {
            gradient[node] = sigma * push[node];
            // d(σ v·e)/dσ: what the force does along the member.
            stretch_gradient += curvature[node];
        }
        for node in nodes.start..nodes.end - 1 {
            let [near, far] = coupling[node];
            let bend = near * (angle[node + 1] - angle[node]);
            gradient[node] += bend;
            gradient[node + 1] -= bend;
            if far != T::ZERO {
                let bend = far * (angle[node + 2] - angle[node]);
                gradient[node] += bend;
                gradient[node + 2] -= bend;
            }
        }
        out.stretch_gradient = T::ZERO;
        if member.axial > T::ZERO {
            out.stretch_gradient = member.axial * stretch + stretch_gradient;
            worst.gradient = worst.gradient.max(out.stretch_gradient.abs());
        }
        for node in nodes.start + 1..nodes.end - 1 {
            worst.gradient = worst.gradient.max(gradient[node].abs());
        }
        let (first, last) = (nodes.start, nodes.end - 1);
        if member.start != CLAMPED {
            joints[usize::from(member.start)] +=
                gradient[first] + out.force[1] * out.rigid_start[0] - out.force[0] * out.rigid_start[1];
        }
        joints[usize::from(member.end)] +=
            gradient[last] + out.end_force[1] * out.rigid_end[0] - out.end_force[0] * out.rigid_end[1];
    }
    // NaN anywhere reaches a closure or a joint; the comparisons alone would drop it.
    let mut total = T::ZERO;
    for cell in 0..ladder.cells {
        for i in 0..2 {
            total += work.closure.as_ref()[cell][i];
            worst.length = worst.length.max(work.closure.as_ref()[cell][i].abs());
        }
        let angles = if cell + 1 == ladder.cells { 2..3 } else { 2..5 };
        for slot in angles {
            total += joints[5 * cell + slot];
            worst.gradient = worst.gradient.max(joints[5 * cell + slot].abs());
        }
    }
    for row in rows {
        if row.multiplier != T::ZERO {
            worst.length = worst.length.max((row.gap + ladder.softness * row.multiplier).abs());
        }
    }
    if !total.is_finite() {
        worst.gradient = T::of(1e30);
    }
    worst.length = worst.length.max(-sweep.nearest_free);
    worst
}

/// Position of a sample, finger frame, mm.
pub(crate) fn sample_position<T: Real, S: Size>(
    ladder: &Ladder<T, S>,
    state: &State<T, S>,
    work: &Workspace<T, S>,
    sample: &crate::contact::Sample<T>,
) -> Vec2<T> {
    let index = 4 * usize::from(sample.cell);
    let (e, weight) = (work.e.as_ref(), ladder.weight.as_ref());
    let first = usize::from(sample.node);
    let mut local = Vec2::new(T::ZERO, T::ZERO);
    for node in usize::from(ladder.members.as_ref()[index].first)..first {
        local += vec2_of(e[node]) * weight[node];
    }
    for (k, &w) in sample.weights.iter().enumerate() {
        if w != T::ZERO {
            local += vec2_of(e[first + k]) * w;
        }
    }
    let sigma = T::one() + state.stretch.as_ref()[index];
    let rigid = vec2_of(work.members.as_ref()[index].rigid_end) * sample.rigid;
    vec2_of(work.start.as_ref()[usize::from(sample.cell)]) + local * sigma + rigid
}

/// Penalty energy of all penetrating samples, N·mm: g²/(2ε_c) with softness, else `penalty`·|g|.
pub(crate) fn penetration<T: Real, S: Size, O: Object<T>>(
    ladder: &Ladder<T, S>,
    state: &State<T, S>,
    work: &Workspace<T, S>,
    object: &O,
    penalty: T,
) -> T {
    let mut energy = T::ZERO;
    for sample in &ladder.samples.as_ref()[..ladder.sample_count] {
        let gap = sample_gap(object, sample, sample_position(ladder, state, work, sample)).distance;
        if gap < T::ZERO {
            energy += if ladder.softness > T::ZERO {
                gap * gap / (ladder.softness + ladder.softness)
            } else {
                -penalty * gap
            };
        }
    }
    energy
}
