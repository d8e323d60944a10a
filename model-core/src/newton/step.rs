//! One step: residual, condensation, banded KKT, border, active set, increments.

use super::active_set::{self, Problem};
use super::banded::{self, force_terms};
use super::border;
use super::condense::{self, Diagonal, solve_interior};
use super::gaps::{self, Sweep};
use super::residual::{self, Residual};
use super::{Hessian, Workspace, bend, strain, turning};
use crate::ladder::{CLAMPED, Ladder, PER_CELL, State};
use crate::object::Object;
use crate::real::Real;
use crate::size::Size;

/// Largest change of an angle in one step, rad.
const CLIP: f64 = 0.4;

/// Tolerance of a length below which it matters that the front beam is strained with the object's present normals, mm.
const REPLACED: f64 = 1e-6;

/// What a factorisation says about the state it was made at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Inertia {
    /// Negative pivots of the condensation and of the banded KKT, less the 2(K+1) that the closures give.
    pub excess: isize,
    /// Negative eigenvalues of D on the active set, less the one that the turning of the contact force has by itself.
    pub border: isize,
    /// The active set settled.
    pub settled: bool,
}

impl Inertia {
    /// The energy's Hessian is positive definite on the closures' and contacts' tangent space: a stable equilibrium.
    pub(crate) fn is_stable(&self) -> bool {
        self.settled && self.excess == self.border
    }
}

/// Kinematics, gaps, forces and gradient at the present state.
pub(crate) fn evaluate<T: Real, S: Size, O: Object<T>>(
    ladder: &Ladder<T, S>,
    state: &State<T, S>,
    work: &mut Workspace<T, S>,
    object: &O,
    margin: T,
) -> (Residual<T>, Sweep<T>) {
    strain::directions(ladder, state, work);
    bend::shorten(ladder, state, work);
    gaps::recall(state, work);
    strain::place_front(ladder, state, work);
    let mut sweep = gaps::sweep(ladder, state, work, object, margin);
    // Too many near samples: only those that penetrate need rows.
    if sweep.crowded {
        sweep = gaps::sweep(ladder, state, work, object, T::ZERO);
    }
    if T::TOLERANCE.length < T::of(REPLACED) {
        gaps::replace(ladder, state, work, object);
    }
    (residual::gradient(ladder, state, work, &sweep), sweep)
}

/// Condenses, factorises and borders at the evaluated state; returns the number of negative pivots.
pub(crate) fn factorise<T: Real, S: Size>(
    ladder: &Ladder<T, S>,
    work: &mut Workspace<T, S>,
    diagonal: Diagonal<T>,
) -> usize {
    let n = ladder.unknowns();
    let mut negative = 0;
    work.curved = diagonal.curvature != T::ZERO;
    banded::begin(ladder, work);
    for index in 0..ladder.member_count() {
        let (condensed, below_zero) = condense::condense(ladder, work, index, diagonal);
        negative += below_zero;
        banded::add_member(ladder, work, index, &condensed);
        if index % 4 == 0 {
            work.fronts.as_mut()[index / 4] = condensed;
        }
    }
    // The right-hand side is the negative residual.
    for value in &mut work.rhs.as_mut()[..n] {
        *value = -*value;
    }
    border::assemble(ladder, work);
    negative += banded::factorise(&mut work.band.as_mut()[..n], &ladder.scale.as_ref()[..n]);
    banded::forward(&work.band.as_ref()[..n], &mut work.rhs.as_mut()[..n]);
    border::complete(ladder, work);
    negative
}

/// Factorises at the evaluated state, settles the active set and finds the increments (kept in the workspace).
pub(crate) fn solve<T: Real, S: Size>(
    ladder: &Ladder<T, S>,
    work: &mut Workspace<T, S>,
    hessian: Hessian,
    shift: T,
) -> Inertia {
    let curvature = if hessian == Hessian::Newton { T::one() } else { T::ZERO };
    if hessian == Hessian::Newton {
        turning::add(work, S::CONTACTS);
    }
    let negative = factorise(ladder, work, Diagonal { curvature, shift });
    let count = work.row_count;
    let rows = work.rows.as_ref();
    for j in 0..count {
        work.active.as_mut()[j] = rows[j].multiplier > T::ZERO || work.turning == Some(j as u16);
    }
    let multiplier = |j: usize| rows[j].multiplier;
    let settled = active_set::settle(
        &mut Problem {
            flexibility: work.flexibility.as_ref(),
            stride: S::CONTACTS,
            rhs: work.row_rhs.as_ref(),
            multiplier: &multiplier,
            free: work.turning.map(usize::from),
            tolerance: T::TOLERANCE.length * T::of(0.1),
            factored: work.factored.as_mut(),
            order: work.order.as_mut(),
            scratch: work.scratch.as_mut(),
            spare: work.spare.as_mut(),
        },
        count,
        work.active.as_mut(),
        work.row_delta.as_mut(),
    );
    increments(ladder, work);
    Inertia {
        excess: negative as isize - 2 * ladder.cells as isize,
        border: settled.negative as isize - isize::from(work.turning.is_some()),
        settled: settled.settled,
    }
}

/// Increments of all unknowns from those of the contact rows.
pub(crate) fn increments<T: Real, S: Size>(ladder: &Ladder<T, S>, work: &mut Workspace<T, S>) {
    let n = ladder.unknowns();
    for j in 0..work.row_count {
        let delta = work.row_delta.as_ref()[j];
        if delta != T::ZERO {
            let column = &work.columns.as_ref()[j * n..(j + 1) * n];
            for (value, &entry) in work.rhs.as_mut()[..n].iter_mut().zip(column) {
                *value -= entry * delta;
            }
        }
    }
    banded::backward(&work.band.as_ref()[..n], &mut work.rhs.as_mut()[..n]);
    recover(ladder, work);
}

/// Increments of the stretches and of all interior angles from those of joints, λ and μ.
fn recover<T: Real, S: Size>(ladder: &Ladder<T, S>, work: &mut Workspace<T, S>) {
    let samples = ladder.samples.as_ref();
    let mut above = [T::ZERO; 2];
    let mut row = work.row_count;
    for cell in (0..ladder.cells).rev() {
        let mut own_force = [T::ZERO; 2];
        let row_end = row;
        while row > 0 && usize::from(samples[usize::from(work.rows.as_ref()[row - 1].sample)].cell) == cell {
            row -= 1;
            for i in 0..2 {
                own_force[i] += work.row_delta.as_ref()[row] * work.rows.as_ref()[row].normal[i];
            }
        }
        for kind in 0..if cell + 1 == ladder.cells { 2 } else { 4 } {
            let rows = if kind == 0 { row..row_end } else { 0..0 };
            recover_member(ladder, work, 4 * cell + kind, if kind == 0 { above } else { [T::ZERO; 2] }, rows);
        }
        above[0] += own_force[0];
        above[1] += own_force[1];
    }
}

fn recover_member<T: Real, S: Size>(
    ladder: &Ladder<T, S>,
    work: &mut Workspace<T, S>,
    index: usize,
    above: [T; 2],
    rows: core::ops::Range<usize>,
) {
    let member = &ladder.members.as_ref()[index];
    let samples = ladder.samples.as_ref();
    let nodes = member.nodes();
    let interior = usize::from(member.interior);
    let joints = work.rhs.as_ref();
    let da = if member.start == CLAMPED { T::ZERO } else { joints[usize::from(member.start)] };
    let db = joints[usize::from(member.end)];
    let (terms, count) = force_terms::<T>(index);
    let mut force = [-above[0], -above[1]];
    for &(u, sign) in &terms[..count] {
        force[0] += sign * joints[u];
        force[1] += sign * joints[u + 1];
    }
    let lever = work.lever.as_ref();
    let coupling = super::coupling(ladder, work.coupling.as_ref(), work.curved, index);
    let gradient = work.gradient.as_ref();
    let z = &mut work.delta.as_mut()[nodes.clone()];
    let mut carried = force;
    let mut next = rows.end;
    for i in (1..=interior).rev() {
        let node = nodes.start + i;
        while next > rows.start {
            let row = &work.rows.as_ref()[next - 1];
            if usize::from(samples[usize::from(row.sample)].node) <= node {
                break;
            }
            next -= 1;
            let delta = work.row_delta.as_ref()[next];
            carried[0] -= delta * row.normal[0];
            carried[1] -= delta * row.normal[1];
        }
        let [x, y] = lever[node];
        z[i] = -gradient[node] - (carried[0] * x + carried[1] * y);
    }
    for j in rows {
        let row = &work.rows.as_ref()[j];
        let sample = &samples[usize::from(row.sample)];
        let delta = work.row_delta.as_ref()[j];
        if delta == T::ZERO {
            continue;
        }
        for (k, &[x, y]) in work.own.as_ref()[j].lever.iter().enumerate() {
            let local = (usize::from(sample.node) + k).wrapping_sub(nodes.start);
            if local >= 1 && local <= interior {
                z[local] += delta * (row.normal[0] * x + row.normal[1] * y);
            }
        }
    }
    if interior >= 1 {
        z[1] -= coupling[0][0] * da;
    }
    if interior >= 2 {
        z[2] -= coupling[0][1] * da;
    }
    z[0] = da;
    solve_interior(&work.factor.as_ref()[nodes], z, interior, db);
}

/// Largest change of an angle that the increments ask for, rad.
pub(crate) fn pace<T: Real, S: Size>(ladder: &Ladder<T, S>, work: &Workspace<T, S>) -> T {
    work.delta.as_ref()[..ladder.node_count].iter().fold(T::ZERO, |most, &delta| most.max(delta.abs()))
}

/// Factor that keeps the largest change of an angle within the clip.
pub(crate) fn clip<T: Real, S: Size>(ladder: &Ladder<T, S>, work: &Workspace<T, S>) -> T {
    let (largest, clip) = (pace(ladder, work), T::of(CLIP));
    if largest > clip { clip / largest } else { T::one() }
}

/// Adds `part` of the increments to the state; multipliers that fall to zero leave the touching samples.
pub(crate) fn apply<T: Real, S: Size>(ladder: &Ladder<T, S>, state: &mut State<T, S>, work: &Workspace<T, S>, part: T) {
    let angles = &mut state.angle.as_mut()[..ladder.node_count];
    for (angle, &delta) in angles.iter_mut().zip(work.delta.as_ref()) {
        *angle += part * delta;
    }
    for (cell, lambda) in state.lambda.as_mut()[..ladder.cells].iter_mut().enumerate() {
        lambda[0] += part * work.rhs.as_ref()[PER_CELL * cell];
        lambda[1] += part * work.rhs.as_ref()[PER_CELL * cell + 1];
    }
    let slide = turning::slide(work);
    let mut count = 0;
    for j in (0..work.row_count).filter(|&j| work.turning != Some(j as u16)) {
        let row = &work.rows.as_ref()[j];
        let multiplier = row.multiplier + part * work.row_delta.as_ref()[j];
        let keeps = part != T::one() || work.active.as_ref()[j];
        if keeps && multiplier > T::ZERO {
            state.touching.as_mut()[count] = row.sample;
            state.multiplier.as_mut()[count] = multiplier;
            state.normal.as_mut()[count] = gaps::turned_by(row.normal, part * (row.tilt + slide * row.curvature));
            count += 1;
        }
    }
    state.touching_count = count;
}

/// Gives the rows the multipliers and normals that the last whole step has given the state, so that the contacts can be read
/// without another evaluation.
pub(crate) fn settle_rows<T: Real, S: Size>(state: &State<T, S>, work: &mut Workspace<T, S>) {
    let touching = state.touching.as_ref()[..state.touching_count].iter();
    let forces = state.multiplier.as_ref().iter().zip(state.normal.as_ref());
    let mut settled = touching.zip(forces).peekable();
    let turning = work.turning.map(usize::from);
    let count = work.row_count;
    for (j, row) in work.rows.as_mut()[..count].iter_mut().enumerate() {
        row.multiplier = T::ZERO;
        if turning != Some(j)
            && let Some((_, (&multiplier, &normal))) = settled.next_if(|(sample, _)| **sample == row.sample)
        {
            (row.multiplier, row.normal) = (multiplier, normal);
        }
    }
}

/// Makes the joint angles that members repeat agree again: that of the member which ends at the joint counts.
pub(crate) fn share_joints<T: Real, S: Size>(ladder: &Ladder<T, S>, state: &mut State<T, S>) {
    let members = &ladder.members.as_ref()[..ladder.member_count()];
    let angle = state.angle.as_mut();
    for owner in 0..members.len() {
        let (joint, value) = (members[owner].end, angle[members[owner].nodes().end - 1]);
        for member in members {
            if member.start == joint {
                angle[usize::from(member.first)] = value;
            }
            if member.end == joint {
                angle[member.nodes().end - 1] = value;
            }
        }
    }
    for member in members.iter().filter(|m| m.start == CLAMPED) {
        angle[usize::from(member.first)] = T::ZERO;
    }
}
