//! Kinematics, gaps, forces and the gradient of the Lagrangian
//! L = V(θ) + Σ λ_k·h_k(θ, λ, μ) − Σ μ_j g_j − ½ ε_c Σ μ_j², stretch and shear eliminated (see [`crate::ladder`]).

use super::{MemberWork, Workspace};
use crate::contact::{Row, sample_gap};
use crate::ladder::{CLAMPED, Ladder, State, turned, vec2_of};
use crate::object::Object;
use crate::real::{Real, Vec2};
use crate::size::{Blank, Size};

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

/// Makes rows of the samples that touched last, with the normals they had: what strains the front beam while its gaps are
/// not known yet.
pub(crate) fn recall<T: Real, S: Size>(state: &State<T, S>, work: &mut Workspace<T, S>) {
    work.row_count = state.touching_count;
    for (j, row) in work.rows.as_mut()[..state.touching_count].iter_mut().enumerate() {
        *row = Row {
            sample: state.touching.as_ref()[j],
            normal: state.normal.as_ref()[j],
            multiplier: state.multiplier.as_ref()[j],
            ..Row::BLANK
        };
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

/// What a force does to a link or node of weight w and direction e.
///
/// With f the force per weight, a = f·e, b = f·e′, k = 1/EA − 1/κGA: ψ = a − ½(a²/EA + b²/κGA), d = ∂ψ/∂f, and the node adds
/// w ψ to the Lagrangian.
struct Strained<T> {
    /// Strained direction d and its derivative with respect to the angle.
    direction: [T; 2],
    turned: [T; 2],
    /// First derivative of w ψ with respect to the angle, and the second with its sign changed, N·mm.
    gradient: T,
    curvature: T,
    /// −w C and the energy of stretch and shear, twice.
    give: [T; 3],
    energy: T,
}

#[inline(always)]
fn strained<T: Real, const RIGID: bool>(e: [T; 2], w: T, force: [T; 2], [stretch, shear]: [T; 2]) -> Strained<T> {
    let [x, y] = e;
    let a = force[0] * x + force[1] * y;
    let b = force[1] * x - force[0] * y;
    if RIGID {
        let (give, energy) = ([T::ZERO; 3], T::ZERO);
        return Strained { direction: e, turned: [-y, x], gradient: w * b, curvature: w * a, give, energy };
    }
    let k = stretch - shear;
    let (p, q) = (T::one() - stretch * a, shear * b);
    let (r, t) = (T::one() - k * a, k * b);
    let (xx, yy) = (x * x, y * y);
    Strained {
        direction: [x * p + q * y, y * p - q * x],
        turned: [-y * r - t * x, x * r - t * y],
        gradient: w * b * r,
        curvature: w * (a * r + b * t),
        give: [w * (stretch * xx + shear * yy), w * k * x * y, w * (stretch * yy + shear * xx)],
        energy: w * (stretch * a * a + shear * b * b),
    }
}

/// Strains a member: directions, their derivatives, the force's part of the gradient and of its diagonal, the chord and the
/// compliance of the force with itself.
fn strain<T: Real, S: Size>(
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
    let mut give = [T::ZERO; 3];
    let mut energy = T::ZERO;
    let input = ladder.weight.as_ref()[nodes.clone()].iter().zip(&work.e.as_ref()[nodes.clone()]);
    let directions = work.strained.as_mut()[nodes.clone()].iter_mut().zip(&mut work.turned.as_mut()[nodes.clone()]);
    let slopes = work.gradient.as_mut()[nodes.clone()].iter_mut().zip(&mut work.curvature.as_mut()[nodes.clone()]);
    let all = nodes.zip(input).zip(directions.zip(slopes));
    for ((node, (&w, &e)), ((direction, turned), (gradient, curvature))) in all.rev() {
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
        let node = strained::<T, RIGID>(e, w, force, member.compliance);
        *direction = node.direction;
        *turned = node.turned;
        *gradient = node.gradient;
        *curvature = node.curvature;
        chord = [chord[0] + w * node.direction[0], chord[1] + w * node.direction[1]];
        if !RIGID {
            for i in 0..3 {
                give[i] -= node.give[i];
            }
            energy += node.energy;
        }
    }
    out.chord = chord;
    out.give = give;
    out.strain_energy = T::of(0.5) * energy;
}

/// Forces and strained positions of the front spans, so that gaps can be measured.
pub(crate) fn place_front<T: Real, S: Size>(ladder: &Ladder<T, S>, state: &State<T, S>, work: &mut Workspace<T, S>) {
    forces(ladder, state, work);
    let mut from = 0;
    for cell in 0..ladder.cells {
        let member = &ladder.members.as_ref()[4 * cell];
        if member.compliance == [T::ZERO; 2] {
            let (e, strained, weight) = (work.e.as_ref(), work.strained.as_mut(), ladder.weight.as_ref());
            let mut chord = [T::ZERO; 2];
            for node in member.nodes() {
                strained[node] = e[node];
                chord = [chord[0] + weight[node] * e[node][0], chord[1] + weight[node] * e[node][1]];
            }
            work.members.as_mut()[4 * cell].chord = chord;
        } else {
            let own = own_rows(ladder, &work.rows.as_ref()[..work.row_count], 4 * cell, from);
            from = own.end;
            strain(ladder, work, 4 * cell, own);
        }
    }
    starts(ladder, work);
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
    let (strained, weight) = (work.strained.as_ref(), ladder.weight.as_ref());
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
            prefix += vec2_of(strained[node]) * weight[node];
            node += 1;
        }
        let mut local = prefix;
        for (k, &w) in sample.weights.iter().enumerate() {
            if w != T::ZERO {
                local += vec2_of(strained[node + k]) * w;
            }
        }
        let position = vec2_of(starts[cell]) + local + vec2_of(members[4 * cell].rigid_end) * sample.rigid;
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

/// Adds K θ of a member to its gradient, as differences: K's rows sum to zero.
fn bend<T: Real>(angle: &[T], coupling: &[[T; 2]], gradient: &mut [T], quadratic: bool) {
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

/// Strains all members, and returns the largest residuals of gradient, closures and gaps.
pub(crate) fn gradient<T: Real, S: Size>(
    ladder: &Ladder<T, S>,
    state: &State<T, S>,
    work: &mut Workspace<T, S>,
    sweep: &Sweep<T>,
) -> Residual<T> {
    forces(ladder, state, work);
    let mut worst = Residual { gradient: T::ZERO, length: T::ZERO };
    work.rhs.as_mut()[..ladder.unknowns()].fill(T::ZERO);
    let mut from = 0;
    for (index, member) in ladder.members.as_ref()[..ladder.member_count()].iter().enumerate() {
        let own = own_rows(ladder, &work.rows.as_ref()[..work.row_count], index, from);
        from = own.end;
        strain(ladder, work, index, own);
        let (angle, coupling) = (state.angle.as_ref(), ladder.coupling.as_ref());
        let gradient = work.gradient.as_mut();
        let nodes = member.nodes();
        bend(&angle[nodes.clone()], &coupling[nodes.clone()], &mut gradient[nodes.clone()], ladder.quadratic);
        for slope in &gradient[nodes.start + 1..nodes.end - 1] {
            worst.gradient = worst.gradient.max(slope.abs());
        }
        let out = &work.members.as_ref()[index];
        let joints = work.rhs.as_mut();
        let (first, last) = (nodes.start, nodes.end - 1);
        if member.start != CLAMPED {
            joints[usize::from(member.start)] +=
                gradient[first] + out.force[1] * out.rigid_start[0] - out.force[0] * out.rigid_start[1];
        }
        joints[usize::from(member.end)] +=
            gradient[last] + out.end_force[1] * out.rigid_end[0] - out.end_force[0] * out.rigid_end[1];
    }
    closures(ladder, work);
    let joints = work.rhs.as_ref();
    let rows = &work.rows.as_ref()[..work.row_count];
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
    work: &Workspace<T, S>,
    sample: &crate::contact::Sample<T>,
) -> Vec2<T> {
    let index = 4 * usize::from(sample.cell);
    let (strained, weight) = (work.strained.as_ref(), ladder.weight.as_ref());
    let first = usize::from(sample.node);
    let mut local = Vec2::new(T::ZERO, T::ZERO);
    for node in usize::from(ladder.members.as_ref()[index].first)..first {
        local += vec2_of(strained[node]) * weight[node];
    }
    for (k, &w) in sample.weights.iter().enumerate() {
        if w != T::ZERO {
            local += vec2_of(strained[first + k]) * w;
        }
    }
    let rigid = vec2_of(work.members.as_ref()[index].rigid_end) * sample.rigid;
    vec2_of(work.start.as_ref()[usize::from(sample.cell)]) + local + rigid
}

/// Penalty energy of all penetrating samples, N·mm: g²/(2ε_c) with softness, else `penalty`·|g|.
pub(crate) fn penetration<T: Real, S: Size, O: Object<T>>(
    ladder: &Ladder<T, S>,
    work: &Workspace<T, S>,
    object: &O,
    penalty: T,
) -> T {
    let mut energy = T::ZERO;
    for sample in &ladder.samples.as_ref()[..ladder.sample_count] {
        let gap = sample_gap(object, sample, sample_position(ladder, work, sample)).distance;
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

/// Elastic energy at a state whose rows are those of the last evaluation, N·mm; leaves closures and positions behind.
pub(crate) fn potential<T: Real, S: Size>(ladder: &Ladder<T, S>, state: &State<T, S>, work: &mut Workspace<T, S>) -> T {
    directions(ladder, state, work);
    forces(ladder, state, work);
    let mut energy = state.bending_energy(ladder);
    let mut from = 0;
    for index in 0..ladder.member_count() {
        let own = own_rows(ladder, &work.rows.as_ref()[..work.row_count], index, from);
        from = own.end;
        strain(ladder, work, index, own);
        energy += work.members.as_ref()[index].strain_energy;
    }
    closures(ladder, work);
    starts(ladder, work);
    energy
}
