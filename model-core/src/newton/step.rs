//! One step: residual, condensation, banded KKT, border, active set, increments.

use super::assembly;
use super::border;
use super::condense::{self, Diagonal, solve_interior};
use super::gaps::{self, Sweep};
use super::residual::{self, Residual};
use super::settings::NewtonSettings;
use super::{Hessian, Workspace, kinematics, lagged, turning};
use crate::access::Access;
use crate::contact::ContactState;
use crate::contact::frictionless::{self, Problem, Settled};
use crate::element::{Depth, Node, Places, Residuals, Tangents};
use crate::linear::banded;
use crate::model::Model;
use crate::object::Object;
use crate::real::Real;
use crate::size::Size;
use crate::state::State;
use crate::topology::{CLAMPED, Kind};

/// Largest change of an angle in one step, rad.
pub(crate) const CLIP: f64 = 0.4;

/// What a factorisation says about the state it was made at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Inertia {
    /// Negative pivots of the condensation and of the banded KKT, less the 2(K+1) that the closures give.
    pub excess: isize,
    /// Negative eigenvalues of D on the active set, less those that the turning of the contact force has by itself.
    pub border: isize,
    /// The active set settled.
    pub settled: bool,
}

impl Inertia {
    /// The energy's Hessian is positive definite on the closures' and contacts' tangent space: a stable equilibrium.
    pub(crate) fn is_stable(&self) -> bool {
        self.settled && self.excess == self.border
    }

    /// There is a direction in which the energy falls. (Fewer than none there cannot be: a border with more negative eigenvalues than the
    /// rest has in excess is an effect of rounding.)
    pub(crate) fn is_unstable(&self) -> bool {
        self.settled && self.excess > self.border
    }
}

/// Increment of an angle below which the normals of a step leave nothing to replace, as a rule, rad.
const NOTHING_TO_REPOSITION: f64 = 1e-6;

/// Kinematics, gaps, forces, gradient and second derivatives at the present state.
pub(crate) fn evaluate<T: Real, S: Size, O: Object<T>>(
    model: &Model<T, S>,
    state: &State<T, S>,
    work: &mut Workspace<T, S>,
    object: &O,
    margin: T,
) -> (Residual<T>, Sweep<T>) {
    kinematics::directions(model, state, work);
    evaluate_to::<T, S, O, Tangents>(model, state, work, object, margin)
}

/// As [`evaluate`] after a whole step, but without the second derivatives: they stay those of an earlier state where that spares
/// something.
pub(crate) fn residuals<T: Real, S: Size, O: Object<T>>(
    model: &Model<T, S>,
    state: &State<T, S>,
    work: &mut Workspace<T, S>,
    object: &O,
    margin: T,
) -> (Residual<T>, Sweep<T>) {
    if work.largest_turn <= T::of(kinematics::SMALL) {
        kinematics::turn(model, work);
    } else {
        kinematics::directions(model, state, work);
    }
    evaluate_to::<T, S, O, Residuals>(model, state, work, object, margin)
}

fn evaluate_to<T: Real, S: Size, O: Object<T>, D: Depth>(
    model: &Model<T, S>,
    state: &State<T, S>,
    work: &mut Workspace<T, S>,
    object: &O,
    margin: T,
) -> (Residual<T>, Sweep<T>) {
    work.effort.evaluates();
    work.shape.lacks_tangent = !D::TANGENT && !model.quadratic;
    gaps::recall(model, state, work);
    // After a small step the normals are those of the object up to second order: nothing is left to replace, as a rule.
    let NewtonSettings { repositions, tolerance, .. } = NewtonSettings::<T>::of_precision();
    let at_once = !repositions || !D::TANGENT && work.largest_turn <= T::of(NOTHING_TO_REPOSITION);
    if at_once {
        kinematics::place_front::<T, S, D>(model, state, work);
    } else {
        kinematics::place_front::<T, S, Places>(model, state, work);
    }
    let mut sweep = gaps::sweep(model, state, work, object, margin);
    // Too many near samples: only those that penetrate need rows.
    if sweep.near_overflow {
        sweep = gaps::sweep(model, state, work, object, T::ZERO);
    }
    if repositions && !(at_once && residual::misdirected(model, work) <= T::of(0.01) * tolerance.gradient) {
        gaps::reposition::<T, S, O, D>(model, state, work, object);
    }
    (residual::gradient::<T, S, D>(model, state, work, &sweep), sweep)
}

/// Condenses, factorises and borders at the evaluated state; returns the number of negative pivots.
pub(crate) fn factorise<T: Real, S: Size>(
    model: &Model<T, S>,
    work: &mut Workspace<T, S>,
    diagonal: Diagonal<T>,
) -> usize {
    let n = model.unknowns();
    let mut negative = 0;
    work.factorisation.curved = diagonal.curvature != T::ZERO;
    assembly::begin(model, work);
    for index in 0..model.topology.member_count() {
        let (condensed, below_zero) = condense::condense(model, work, index, diagonal);
        negative += below_zero;
        let Some(member) = model.member(index) else { continue };
        assembly::add_corrections(work.rhs.as_mut(), member, &condensed.corrections);
        assembly::add_member(work.factorisation.band.as_mut(), member, &condensed);
        if index < model.cells() {
            work.factorisation.fronts.as_mut().put(index, condensed);
        }
    }
    // The right-hand side is the negative residual.
    for value in work.rhs.as_mut().run_mut(0..n) {
        *value = -*value;
    }
    border::assemble(model, work);
    negative += banded::factorise(work.factorisation.band.as_mut().run_mut(0..n), model.topology.scale.as_ref());
    banded::forward(work.factorisation.band.as_ref().run(0..n), work.rhs.as_mut().run_mut(0..n));
    border::complete(model, work);
    negative
}

/// Factorises at the evaluated state, settles the active set and finds the increments (kept in the workspace).
pub(crate) fn solve<T: Real, S: Size>(
    model: &Model<T, S>,
    work: &mut Workspace<T, S>,
    hessian: Hessian,
    shift: T,
) -> Inertia {
    work.effort.solves();
    let curvature = if hessian == Hessian::Newton { T::one() } else { T::ZERO };
    if hessian == Hessian::Newton {
        turning::add(work, S::CONTACTS);
    }
    let negative = factorise(model, work, Diagonal { curvature, shift });
    lagged::note(work, negative as isize - 2 * model.cells() as isize);
    let settled = settle(work);
    increments(model, work);
    inertia(work, settled)
}

/// What the last factorisation, and the active set settled on it, say.
pub(crate) fn inertia<T: Real, S: Size>(work: &Workspace<T, S>, settled: Settled) -> Inertia {
    Inertia {
        excess: work.factorisation.excess,
        border: settled.negative as isize - turning::negative(work),
        settled: settled.settled,
    }
}

/// Settles the active set, from the rows that touch, and finds the rows' increments.
pub(crate) fn settle<T: Real, S: Size>(work: &mut Workspace<T, S>) -> Settled {
    let count = work.contacts.row_count;
    let settled = frictionless::settle(
        &mut Problem {
            flexibility: work.border.flexibility.as_ref(),
            stride: S::CONTACTS,
            rhs: work.border.row_rhs.as_ref(),
            rows: work.contacts.rows.as_ref(),
            tolerance: T::TOLERANCE.length * T::of(0.1),
            factored: work.solution.factored.as_mut(),
            order: work.solution.order.as_mut(),
            listed: work.solution.listed.as_mut(),
            factorised: work.solution.factorised,
            scratch: work.solution.scratch.as_mut(),
            spare: work.solution.spare.as_mut(),
        },
        count,
        work.solution.states.as_mut(),
        work.solution.row_delta.as_mut(),
    );
    work.solution.factorised = settled.factorised;
    settled
}

/// Increments of all unknowns from those of the contact rows.
pub(crate) fn increments<T: Real, S: Size>(model: &Model<T, S>, work: &mut Workspace<T, S>) {
    let n = model.unknowns();
    let rhs = work.rhs.as_mut().run_mut(0..n);
    let columns = work.border.columns.as_ref().chunks_exact(n.max(1));
    for (&delta, column) in work.solution.row_delta.as_ref().iter().zip(columns).take(work.contacts.row_count) {
        if delta != T::ZERO {
            for (value, &entry) in rhs.iter_mut().zip(column) {
                *value -= entry * delta;
            }
        }
    }
    banded::backward(work.factorisation.band.as_ref().run(0..n), rhs);
    recover(model, work);
}

/// Increments of the stretches and of all interior angles from those of joints, λ and μ.
fn recover<T: Real, S: Size>(model: &Model<T, S>, work: &mut Workspace<T, S>) {
    let mut above = [T::ZERO; 2];
    work.largest_turn = T::ZERO;
    let mut end = work.contacts.row_count;
    for index in model.cells()..model.topology.member_count() {
        recover_member(model, work, index, [T::ZERO; 2], 0..0);
    }
    for cell in (0..model.cells()).rev() {
        let rows = work.contacts.rows.as_ref().run(0..end);
        let own = rows.iter().rev().take_while(|row| kinematics::cell_of(row) == cell).count();
        let rows = end - own..end;
        end = rows.start;
        let mut own_force = [T::ZERO; 2];
        let deltas = work.solution.row_delta.as_ref().run(rows.clone()).iter();
        for (row, &delta) in work.contacts.rows.as_ref().run(rows.clone()).iter().zip(deltas) {
            for i in 0..2 {
                own_force[i] += delta * row.normal[i];
            }
        }
        recover_member(model, work, cell, above, rows);
        above = [above[0] + own_force[0], above[1] + own_force[1]];
    }
}

fn recover_member<T: Real, S: Size>(
    model: &Model<T, S>,
    work: &mut Workspace<T, S>,
    index: usize,
    above: [T; 2],
    rows: core::ops::Range<usize>,
) {
    let Some(member) = model.member(index) else { return };
    let nodes = member.nodes();
    let joints = work.rhs.as_ref();
    let da = if member.start == CLAMPED { T::ZERO } else { joints.at(usize::from(member.start)) };
    let db = joints.at(usize::from(member.end));
    let mut carried = [-above[0], -above[1]];
    for term in member.terms() {
        let x = usize::from(term.unknown);
        carried = [carried[0] + term.sign * joints.at(x), carried[1] + term.sign * joints.at(x + 1)];
    }
    let from_start = if work.factorisation.curved {
        work.shape.nodes.as_ref().at(nodes.start).coupling
    } else {
        model.coupling.as_ref().at(nodes.start)
    };
    let Some(list) = work.shape.nodes.as_mut().get_mut(nodes.clone()) else { return };
    let pulled = |node: &Node<T>, [x, y]: [T; 2]| -node.gradient - (x * node.lever[0] + y * node.lever[1]);
    let (before, wide) = (from_start.map(|entry| entry * da), member.kind == Kind::Quadratic);
    // Start joints are other members' end joints, or do not move.
    let largest = if rows.is_empty() {
        solve_interior(list, before, db, wide, |node| pulled(node, carried))
    } else {
        let own = work
            .contacts
            .rows
            .as_ref()
            .run(rows.clone())
            .iter()
            .zip(work.solution.row_delta.as_ref().run(rows.clone()));
        let mut beyond = own.clone().rev().peekable();
        for (i, node) in list.iter_mut().enumerate().skip(1).rev() {
            // Contacts beyond this node pull the whole of it.
            while let Some((row, &delta)) = beyond.next_if(|(row, _)| usize::from(row.place.node) > nodes.start + i) {
                carried = [carried[0] - delta * row.normal[0], carried[1] - delta * row.normal[1]];
            }
            node.delta = pulled(node, carried);
        }
        for ((row, &delta), own) in own.zip(work.border.own.as_ref().run(rows)) {
            if delta == T::ZERO {
                continue;
            }
            let first = usize::from(row.place.node).wrapping_sub(nodes.start);
            for (k, &[x, y]) in own.lever.iter().enumerate() {
                if let Some(node) = list.get_mut(first.wrapping_add(k)) {
                    node.delta += delta * (row.normal[0] * x + row.normal[1] * y);
                }
            }
        }
        solve_interior(list, before, db, wide, |node| node.delta)
    };
    if let Some(start) = list.first_mut() {
        start.delta = da;
    }
    work.largest_turn = work.largest_turn.max(largest);
}

/// Factor that keeps the largest change of an angle within the clip.
pub(crate) fn clip<T: Real, S: Size>(work: &Workspace<T, S>) -> T {
    let clip = T::of(CLIP);
    if work.largest_turn > clip { clip / work.largest_turn } else { T::one() }
}

/// Adds `part` of the increments to the state; multipliers that fall to zero leave the touching samples.
pub(crate) fn apply<T: Real, S: Size>(model: &Model<T, S>, state: &mut State<T, S>, work: &Workspace<T, S>, part: T) {
    let angles = state.angle.as_mut().run_mut(0..model.node_count).iter_mut();
    for (angle, node) in angles.zip(work.shape.nodes.as_ref().run(0..model.node_count)) {
        *angle += part * node.delta;
    }
    let steps = work.rhs.as_ref();
    for (lambda, closure) in state.lambda.as_mut().iter_mut().zip(model.topology.closures()) {
        let x = usize::from(closure.unknown);
        *lambda = [lambda[0] + part * steps.at(x), lambda[1] + part * steps.at(x + 1)];
    }
    let slide = turning::slide(work);
    let mut touching = state.touching.as_mut().iter_mut().zip(state.multiplier.as_mut()).zip(state.normal.as_mut());
    let rows =
        work.contacts.rows.as_ref().iter().zip(work.solution.row_delta.as_ref()).zip(work.solution.states.as_ref());
    state.touching_count = 0;
    for ((row, &delta), &found) in rows.take(work.contacts.row_count) {
        let multiplier = row.multiplier + part * delta;
        let keeps = part != T::one() || found == ContactState::Closed;
        if row.only_pushes()
            && keeps
            && multiplier > T::ZERO
            && let Some(((sample, slot), normal)) = touching.next()
        {
            (*sample, *slot) = (row.sample, multiplier);
            *normal = gaps::turned_by(row.normal, part * (row.tilt + slide * row.curvature));
            state.touching_count += 1;
        }
    }
}

/// Gives the rows the multipliers and normals that the last whole step has given the state, so that the contacts can be read
/// without another evaluation.
pub(crate) fn settle_rows<T: Real, S: Size>(state: &State<T, S>, work: &mut Workspace<T, S>) {
    let touching = state.touching.as_ref().iter().take(state.touching_count);
    let forces = state.multiplier.as_ref().iter().zip(state.normal.as_ref());
    let mut settled = touching.zip(forces).peekable();
    for row in work.contacts.rows.as_mut().iter_mut().take(work.contacts.row_count).filter(|row| row.only_pushes()) {
        (row.multiplier, row.state) = (T::ZERO, ContactState::Open);
        if let Some((_, (&multiplier, &normal))) = settled.next_if(|(sample, _)| **sample == row.sample) {
            (row.multiplier, row.normal, row.state) = (multiplier, normal, ContactState::Closed);
        }
    }
}

/// Makes the joint angles that members repeat agree again: that of the member which ends at the joint counts.
pub(crate) fn share_joints<T: Real, S: Size>(model: &Model<T, S>, state: &mut State<T, S>) {
    let angle = state.angle.as_mut();
    for owner in model.members() {
        let (joint, value) = (owner.end, angle.at(owner.nodes().end - 1));
        for member in model.members() {
            if member.start == joint {
                angle.put(usize::from(member.first), value);
            }
            if member.end == joint {
                angle.put(member.nodes().end - 1, value);
            }
        }
    }
    for member in model.members().iter().filter(|member| member.start == CLAMPED) {
        angle.put(usize::from(member.first), T::ZERO);
    }
}
