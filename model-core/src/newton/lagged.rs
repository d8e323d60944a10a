//! Steps with a lagged stiffness: the residuals of the present state, the factorisation of an earlier one.
//!
//! A chord step instead of Newton's: with the stiffness of a state that is e away from the solution, an error shrinks by a factor
//! of the order of e. It needs no second derivatives, no condensation, no factorisation and no border: a third of the cost.
//! *Measured* at 170/20 in `f64` (one servo count): the steps shrink the residuals by three to four orders of magnitude whether the
//! stiffness is the present one or that of the tick's first iteration.

use super::condense::solve_interior;
use super::condensed::Corrections;
use super::settings::NewtonSettings;
use super::step::{self, Inertia};
use super::{Workspace, assembly, border, kinematics};
use crate::access::Access;
use crate::contact::{ContactState, Direction, Row};
use crate::linear::banded;
use crate::model::Model;
use crate::real::Real;
use crate::size::{Blank, Size};
use crate::topology::Kind;

/// Gap of a row that is no longer one: nothing presses it shut, mm.
const ABSENT: f64 = 1e9;

/// Notes which rows the factorisation has been made with.
pub(crate) fn note<T: Real, S: Size>(work: &mut Workspace<T, S>, excess: isize) {
    (work.factorisation.excess, work.solution.factorised) = (excess, 0);
    if !NewtonSettings::<T>::of_precision().keeps_factors() {
        return;
    }
    let count = work.contacts.row_count;
    for (kept, row) in work.factorisation.kept.as_mut().iter_mut().zip(work.contacts.rows.as_ref()).take(count) {
        *kept = row.sample;
    }
    let turning =
        work.contacts.turning.map(|index| (index, work.contacts.rows.as_ref().at(usize::from(index)).softness));
    (work.factorisation.kept_count, work.factorisation.kept_turning) = (count, turning);
}

/// Brings the rows of the last evaluation to the places they have in the factorisation; false if it lacks one of them. Those that
/// it has besides are as good as gone.
pub(crate) fn align<T: Real, S: Size>(model: &Model<T, S>, work: &mut Workspace<T, S>) -> bool {
    let (count, kept_count) = (work.contacts.row_count, work.factorisation.kept_count);
    let turning = work.factorisation.kept_turning.map(|(index, softness)| (usize::from(index), softness));
    let is_turning = |j: usize| turning.is_some_and(|(index, _)| index == j);
    let (kept, rows) = (work.factorisation.kept.as_ref().run(0..kept_count), work.contacts.rows.as_mut());
    let mut present = rows.iter().take(count).map(|row| row.sample).peekable();
    for (j, &sample) in kept.iter().enumerate() {
        if !is_turning(j) {
            present.next_if_eq(&sample);
        }
    }
    if present.next().is_some() {
        return false;
    }
    let tilted = rows.iter().take(count).fold(T::ZERO, |sum, row| sum + row.multiplier * row.tilt);
    // From the last one, so that no row is overwritten before it has moved.
    let mut from = count;
    for (j, &sample) in kept.iter().enumerate().rev() {
        let last = from.checked_sub(1).and_then(|last| rows.get(last)).filter(|row| row.sample == sample);
        let row = match last {
            Some(&row) if !is_turning(j) => {
                from -= 1;
                row
            }
            _ => Row {
                sample,
                place: model.place(sample),
                gap: T::of(ABSENT),
                softness: model.contact_softness(),
                ..Row::BLANK
            },
        };
        rows.put(j, row);
    }
    work.contacts.row_count = kept_count;
    work.contacts.turning = work.factorisation.kept_turning.map(|(index, _)| index);
    let Some((index, softness)) = turning else { return true };
    // The row at the middle of the force, which the turning belongs to.
    let Some(&middle) = index.checked_sub(1).and_then(|below| rows.get(below)) else { return false };
    let normal = [-middle.normal[1], middle.normal[0]];
    let turning = Row {
        direction: Direction::Turning,
        state: ContactState::Closed,
        gap: -(softness * tilted),
        normal,
        softness,
        multiplier: T::ZERO,
        ..middle
    };
    rows.put(index, turning);
    middle.touches()
}

/// Finds the increments at the evaluated state with the last factorisation; the rows are aligned.
pub(crate) fn solve<T: Real, S: Size>(model: &Model<T, S>, work: &mut Workspace<T, S>) -> Inertia {
    work.effort.solves();
    let n = model.unknowns();
    assembly::put_closures(model, work);
    let (mut below, mut from) = ([T::ZERO; 2], 0);
    for index in 0..model.topology.member_count() {
        let (Some(corrections), Some(member)) = (condense(model, work, index), model.member(index)) else { continue };
        assembly::add_corrections(work.rhs.as_mut(), member, &corrections);
        if index < model.cells() {
            from = border_rows(model, work, index, from, below);
            below = [below[0] + corrections.rx[0], below[1] + corrections.rx[1]];
        }
    }
    for value in work.rhs.as_mut().run_mut(0..n) {
        *value = -*value;
    }
    banded::forward(work.factorisation.band.as_ref().run(0..n), work.rhs.as_mut().run_mut(0..n));
    border::complete_residuals(model, work);
    let settled = step::settle(work);
    step::increments(model, work);
    step::inertia(work, settled)
}

/// Condenses a member's gradient alone; what its interior takes from it stays in the nodes' `delta`.
fn condense<T: Real, S: Size>(model: &Model<T, S>, work: &mut Workspace<T, S>, index: usize) -> Option<Corrections<T>> {
    let member = model.member(index)?;
    let nodes = member.nodes();
    let constant = model.coupling.as_ref().get(nodes.clone())?;
    let list = work.shape.nodes.as_mut().get_mut(nodes)?;
    solve_interior(list, [T::ZERO; 2], T::ZERO, member.kind == Kind::Quadratic, |node| node.gradient);
    let curved = work.factorisation.curved;
    let coupling = |at: usize| match (curved, list.get(at)) {
        (true, Some(node)) => node.coupling,
        _ => constant.at(at),
    };
    let [_, inner @ .., _] = &*list else { return None };
    let count = inner.len();
    let mut rx = [T::ZERO; 2];
    for node in inner {
        rx = [rx[0] - node.lever[0] * node.delta, rx[1] - node.lever[1] * node.delta];
    }
    let (mut ra, mut rb) = (T::ZERO, T::ZERO);
    if let ([first, ..], [.., last]) = (inner, inner) {
        (ra, rb) = (ra - coupling(0)[0] * first.delta, rb - coupling(count)[0] * last.delta);
    }
    if let ([_, second, ..], [.., second_last, _]) = (inner, inner) {
        (ra, rb) = (ra - coupling(0)[1] * second.delta, rb - coupling(count - 1)[1] * second_last.delta);
    }
    Some(Corrections { ra, rb, rx })
}

/// Right-hand sides of the rows on a front span, but for what the joints and closures take; returns the first row beyond it.
/// `below` is the sum of what the spans below have found for their forces.
fn border_rows<T: Real, S: Size>(
    model: &Model<T, S>,
    work: &mut Workspace<T, S>,
    index: usize,
    from: usize,
    below: [T; 2],
) -> usize {
    let own = kinematics::own_rows(work.contacts.rows.as_ref().run(0..work.contacts.row_count), index, from);
    let Some(nodes) = model.member(index).map(|member| member.nodes()) else { return own.end };
    let Some([_, inner @ .., _]) = work.shape.nodes.as_ref().get(nodes.clone()) else { return own.end };
    let (mut at, mut swept) = (0, [T::ZERO; 2]);
    let rows = work.contacts.rows.as_ref().run(own.clone()).iter().zip(work.border.own.as_ref().run(own.clone()));
    for ((row, lever), right) in rows.zip(work.border.row_rhs.as_mut().run_mut(own.clone())) {
        let first = usize::from(row.place.node).saturating_sub(nodes.start);
        // The interior nodes below the sample's element, whose levers are whole.
        while at + 1 < first
            && let Some(node) = inner.get(at)
        {
            swept = [swept[0] + node.lever[0] * node.delta, swept[1] + node.lever[1] * node.delta];
            at += 1;
        }
        let mut moved = [swept[0] - below[0], swept[1] - below[1]];
        for (k, &[x, y]) in lever.lever.iter().enumerate() {
            if let Some(node) = (first + k).checked_sub(1).and_then(|node| inner.get(node)) {
                moved = [moved[0] + x * node.delta, moved[1] + y * node.delta];
            }
        }
        *right = row.normal[0] * moved[0] + row.normal[1] * moved[1] - row.gap - row.softness * row.multiplier;
    }
    own.end
}
