//! The banded KKT system in joint angles and closure multipliers, in the order that the topology has numbered them.
//!
//! The multipliers of a closure come before the angles they bind, where their pivots are the members' flexibility:
//! [`crate::linear::banded`] needs no interchanges.

use super::condensed::{Condensed, Corrections};
use super::residual::Residual;
use crate::access::Access;
use crate::linear::banded::BAND;
use crate::model::Model;
use crate::real::Real;
use crate::size::Size;
use crate::topology::{CLAMPED, Member};

/// Puts the closures' errors into the residual.
pub(super) fn put_closures<T: Real, S: Size>(model: &Model<T, S>, residual: &Residual<T, S>, right: &mut [T]) {
    for (closure, &error) in model.topology.closures().iter().zip(residual.closure.as_ref()) {
        for (at, error) in (usize::from(closure.unknown)..).zip(error) {
            right.put(at, error);
        }
    }
}

/// Adds a condensed member to the matrix: its joints, and the closures that its force enters.
#[inline(always)]
pub(super) fn add_member<T: Real>(band: &mut [[T; BAND + 1]], member: &Member<T>, c: &Condensed<T>) {
    // Row by row, the diagonal last; nothing lies further from it than the band.
    let band = band.as_flattened_mut();
    let place = |row: usize, column: usize| BAND * row + BAND + column;
    let one = |band: &mut [T], at: usize, value: T| {
        if let Some(entry) = band.get_mut(at) {
            *entry += value;
        }
    };
    // Neighbours in a row.
    let beside = |band: &mut [T], at: usize, [x, y]: [T; 2]| {
        if let Some(entries) = band.get_mut(at..).and_then(|rest| rest.first_chunk_mut::<2>()) {
            entries[0] += x;
            entries[1] += y;
        }
    };
    // Neighbours in a column.
    let below = |band: &mut [T], at: usize, [x, y]: [T; 2]| {
        if let Some(entries) = band.get_mut(at..).and_then(|rest| rest.first_chunk_mut::<{ BAND + 1 }>()) {
            entries[0] += x;
            entries[BAND] += y;
        }
    };
    let force = |band: &mut [T], x: usize| {
        one(band, place(x, x), c.xx);
        beside(band, place(x + 1, x), [c.xy, c.yy]);
    };
    let joint = |band: &mut [T], joint: usize, x: usize, entries: [T; 2]| {
        if joint > x {
            beside(band, place(joint, x), entries);
        } else {
            below(band, place(x, joint), entries);
        }
    };
    let (a, b) = (usize::from(member.start), usize::from(member.end));
    let is_clamped = member.start == CLAMPED;
    one(band, place(b, b), c.bb);
    if !is_clamped {
        one(band, place(a, a), c.aa);
        // The end joint is a later one, or the same.
        one(band, place(b, a), if a == b { c.ab + c.ab } else { c.ab });
    }
    for term in member.terms() {
        let x = usize::from(term.unknown);
        let signed = |force: [T; 2]| [term.sign * force[0], term.sign * force[1]];
        joint(band, b, x, signed(c.bx));
        if !is_clamped {
            joint(band, a, x, signed(c.ax));
        }
        force(band, x);
    }
    if let [first, second] = member.terms() {
        let sign = first.sign * second.sign;
        let (x, y) = (usize::from(second.unknown), usize::from(first.unknown));
        beside(band, place(x, y), [sign * c.xx, sign * c.xy]);
        beside(band, place(x + 1, y), [sign * c.xy, sign * c.yy]);
    }
}

/// Adds what a member's interior takes from the residual.
pub(super) fn add_corrections<T: Real>(right: &mut [T], member: &Member<T>, c: &Corrections<T>) {
    right.add(usize::from(member.end), c.rb);
    for term in member.terms() {
        let x = usize::from(term.unknown);
        right.add(x, term.sign * c.rx[0]);
        right.add(x + 1, term.sign * c.rx[1]);
    }
    if member.start != CLAMPED {
        right.add(usize::from(member.start), c.ra);
    }
}
