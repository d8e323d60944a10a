//! The banded KKT system in joint angles and closure multipliers.
//!
//! Unknowns per cell: λx, λy, φ_front, φ_lamella, φ_back; the tip cell has λx, λy, φ_tip. The multipliers of a closure come before the
//! angles they bind, where their pivots are the members' flexibility: [`crate::linear::banded`] needs no interchanges.

use super::Workspace;
use super::condense::{Condensed, Corrections};
use crate::access::Access;
use crate::ladder::{CLAMPED, Ladder, PER_CELL};
use crate::linear::banded::BAND;
use crate::real::Real;
use crate::size::Size;

/// The closures a member's force is made of, with signs: unknown of λx and ±1.
#[inline]
pub(crate) fn force_terms<T: Real>(index: usize) -> ([(usize, T); 2], usize) {
    let own = PER_CELL * (index / 4);
    let one = T::one();
    match index % 4 {
        0 => ([(own, one), (own, T::ZERO)], 1),
        1 => ([(own, -one), (own, T::ZERO)], 1),
        _ => ([(own, one), (own + PER_CELL, -one)], 2),
    }
}

/// Begins the matrix, and the residual of the closures; on entry `rhs` holds the joints' gradients.
pub(crate) fn begin<T: Real, S: Size>(ladder: &Ladder<T, S>, work: &mut Workspace<T, S>) {
    let band = work.band.as_mut().run_mut(0..ladder.unknowns());
    band.fill([T::ZERO; BAND + 1]);
    if ladder.welded {
        // The angles that a weld leaves without a use; the tip cell has none.
        for cell in band.chunks_exact_mut(PER_CELL) {
            if let [_, _, front, lamella, _] = cell {
                (front[BAND], lamella[BAND]) = (T::one(), T::one());
            }
        }
    }
    put_closures(ladder, work);
}

/// Puts the closures' errors into the residual.
pub(crate) fn put_closures<T: Real, S: Size>(ladder: &Ladder<T, S>, work: &mut Workspace<T, S>) {
    let cells = work.rhs.as_mut().chunks_mut(PER_CELL).take(ladder.cells);
    for (rhs, &closure) in cells.zip(work.closure.as_ref()) {
        if let [x, y, ..] = rhs {
            [*x, *y] = closure;
        }
    }
}

/// Adds a condensed member to matrix and residual.
pub(crate) fn add_member<T: Real, S: Size>(
    ladder: &Ladder<T, S>,
    work: &mut Workspace<T, S>,
    index: usize,
    c: &Condensed<T>,
) {
    let Some(member) = ladder.members.as_ref().get(index) else { return };
    let own = PER_CELL * (index / 4);
    let (a, b) = (usize::from(member.start), usize::from(member.end));
    let spans = index % 4 < 2;
    let side = if index % 4 == 1 { -T::one() } else { T::one() };
    add_corrections(ladder, work, index, &c.corrections);
    // Where the joints lie beside the member's own closure decides where the entries go: known places, no look-ups.
    let band = work.band.as_mut();
    match (spans, member.start != CLAMPED, own.wrapping_sub(a), b.wrapping_sub(own)) {
        (true, false, _, 2) => add_span::<T, 0, 2>(band, own, side, c),
        (true, false, _, _) => add_span::<T, 0, 4>(band, own, side, c),
        (true, true, 3, _) => add_span::<T, 3, 2>(band, own, side, c),
        (true, true, _, 2) => add_span::<T, 1, 2>(band, own, side, c),
        (true, true, ..) => add_span::<T, 1, 4>(band, own, side, c),
        (false, _, _, 3) => add_hinge::<T, 2, 3>(band, own, c),
        (false, _, _, _) if a == b => add_hinge::<T, 4, 4>(band, own, c),
        (false, ..) => add_hinge::<T, 3, 4>(band, own, c),
    }
}

/// Adds what a member's interior takes from the residual.
pub(crate) fn add_corrections<T: Real, S: Size>(
    ladder: &Ladder<T, S>,
    work: &mut Workspace<T, S>,
    index: usize,
    c: &Corrections<T>,
) {
    let Some(member) = ladder.members.as_ref().get(index) else { return };
    let own = PER_CELL * (index / 4);
    let rhs = work.rhs.as_mut();
    let side = if index % 4 == 1 { -T::one() } else { T::one() };
    rhs.add(usize::from(member.end), c.rb);
    rhs.add(own, side * c.rx[0]);
    rhs.add(own + 1, side * c.rx[1]);
    if index % 4 >= 2 {
        rhs.add(own + PER_CELL, -c.rx[0]);
        rhs.add(own + PER_CELL + 1, -c.rx[1]);
    }
    if member.start != CLAMPED {
        rhs.add(usize::from(member.start), c.ra);
    }
}

/// Adds a span whose start joint is `A` unknowns before its closure (0: clamped) and its end joint `B` after.
#[inline(always)]
fn add_span<T: Real, const A: usize, const B: usize>(
    band: &mut [[T; BAND + 1]],
    own: usize,
    side: T,
    c: &Condensed<T>,
) {
    let Some(rows) = band.get_mut(own - A.min(own)..).and_then(|rows| rows.get_mut(..=A + B)) else { return };
    rows[A][BAND] += c.xx;
    rows[A + 1][BAND - 1] += c.xy;
    rows[A + 1][BAND] += c.yy;
    rows[A + B][BAND] += c.bb;
    rows[A + B][BAND - B] += side * c.bx[0];
    rows[A + B][BAND - B + 1] += side * c.bx[1];
    if A > 0 {
        rows[0][BAND] += c.aa;
        rows[A][BAND - A] += side * c.ax[0];
        rows[A + 1][BAND - A - 1] += side * c.ax[1];
        rows[A + B][BAND - A - B] += c.ab;
    }
}

/// Adds a hinge whose joints are `A` and `B` unknowns after its own closure; the next closure is a cell further on. A weld joins
/// both in one unknown.
#[inline(always)]
fn add_hinge<T: Real, const A: usize, const B: usize>(band: &mut [[T; BAND + 1]], own: usize, c: &Condensed<T>) {
    const NEXT: usize = PER_CELL;
    let Some(rows) = band.get_mut(own..).and_then(|rows| rows.first_chunk_mut::<{ PER_CELL + 2 }>()) else { return };
    rows[0][BAND] += c.xx;
    rows[1][BAND - 1] += c.xy;
    rows[1][BAND] += c.yy;
    rows[A][BAND] += c.aa;
    rows[B][BAND] += c.bb;
    rows[B][BAND + A - B] += if A == B { c.ab + c.ab } else { c.ab };
    for (joint, force) in [(A, c.ax), (B, c.bx)] {
        rows[joint][BAND - joint] += force[0];
        rows[joint][BAND - joint + 1] += force[1];
        rows[NEXT][BAND + joint - NEXT] -= force[0];
        rows[NEXT + 1][BAND + joint - NEXT - 1] -= force[1];
    }
    rows[NEXT][BAND - NEXT] -= c.xx;
    rows[NEXT][BAND - NEXT + 1] -= c.xy;
    rows[NEXT + 1][BAND - NEXT - 1] -= c.xy;
    rows[NEXT + 1][BAND - NEXT] -= c.yy;
    rows[NEXT][BAND] += c.xx;
    rows[NEXT + 1][BAND - 1] += c.xy;
    rows[NEXT + 1][BAND] += c.yy;
}
