//! The banded KKT system in joint angles and closure multipliers.
//!
//! Unknowns per cell: λx, λy, φ_front, φ_lamella, φ_back; the tip cell has λx, λy, φ_tip. Half-bandwidth 6. The factorisation
//! is L D Lᵀ without interchanges: symmetric, so the signs of D are the inertia, and the multipliers of a closure come
//! before the angles they bind, where their pivots are the members' flexibility. A pivot that nearly vanishes is bounded,
//! as in `condense`.

use super::Workspace;
use super::condense::{Condensed, Corrections, bounded, pivot_bound};
use crate::access::Access;
use crate::ladder::{CLAMPED, Ladder, PER_CELL};
use crate::real::Real;
use crate::size::Size;

/// Half-bandwidth.
pub(crate) const BAND: usize = 6;

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

/// Factorises in place; the diagonal becomes the inverse pivots. Returns the number of negative pivots.
pub(crate) fn factorise<T: Real>(band: &mut [[T; BAND + 1]], scale: &[T]) -> usize {
    let bound = pivot_bound::<T>();
    let mut negative = 0;
    let mut rest = band;
    let mut scale = scale.iter();
    while let Some((row, below)) = rest.split_first_mut() {
        let least = scale.next().map_or(T::one(), |&s| if s > T::ZERO { s } else { T::one() });
        let (pivot, is_negative) = bounded(row[BAND], bound * least);
        negative += usize::from(is_negative);
        let inverse = T::one() / pivot;
        row[BAND] = inverse;
        // The column below the pivot, zero beyond the last row.
        let mut column = [T::ZERO; BAND];
        if let Some(full) = below.first_chunk_mut::<BAND>() {
            eliminate(full, &mut column, inverse);
        } else {
            // The last rows: padded with zeros.
            let mut padded = [[T::ZERO; BAND + 1]; BAND];
            padded.iter_mut().zip(&*below).for_each(|(into, from)| *into = *from);
            eliminate(&mut padded, &mut column, inverse);
            below.iter_mut().zip(&padded).for_each(|(into, from)| *into = *from);
        }
        rest = below;
    }
    negative
}

/// Takes a pivot out of the rows below it; their entries in its column become the multipliers.
#[inline]
fn eliminate<T: Real>(rows: &mut [[T; BAND + 1]; BAND], column: &mut [T; BAND], inverse: T) {
    for k in 0..BAND {
        column[k] = rows[k][BAND - 1 - k];
    }
    for k in 0..BAND {
        let multiplier = column[k] * inverse;
        // Row k+1 below the pivot meets the columns of the rows from the first below it to itself.
        for m in 0..=k {
            rows[k][BAND - k + m] -= multiplier * column[m];
        }
        rows[k][BAND - 1 - k] = multiplier;
    }
}

/// y = L⁻¹ x in place.
#[inline]
pub(crate) fn forward<T: Real>(band: &[[T; BAND + 1]], x: &mut [T]) {
    // The last values, each in the place of its unknown modulo the bandwidth: registers instead of indices.
    let mut last = [T::ZERO; BAND];
    let (rows, rows_left) = band.as_chunks::<BAND>();
    let (blocks, left) = x.as_chunks_mut::<BAND>();
    let mut one = |at: usize, row: &[T; BAND + 1], x: &mut T| {
        let mut value = *x;
        for k in 0..BAND {
            value -= row[BAND - 1 - k] * last[(at + BAND - 1 - k) % BAND];
        }
        *x = value;
        last[at] = value;
    };
    for (rows, block) in rows.iter().zip(blocks) {
        for at in 0..BAND {
            one(at, &rows[at], &mut block[at]);
        }
    }
    for (at, (row, x)) in rows_left.iter().zip(left).enumerate() {
        one(at % BAND, row, x);
    }
}

/// x = L⁻ᵀ D⁻¹ y in place.
#[inline]
pub(crate) fn backward<T: Real>(band: &[[T; BAND + 1]], y: &mut [T]) {
    // What the unknowns above have taken from the next ones below, each in its place modulo the bandwidth.
    let mut taken = [T::ZERO; BAND];
    let (rows, rows_left) = band.as_chunks::<BAND>();
    let (blocks, left) = y.as_chunks_mut::<BAND>();
    let mut one = |at: usize, row: &[T; BAND + 1], y: &mut T| {
        let value = *y * row[BAND] - taken[at];
        *y = value;
        for k in 1..BAND {
            taken[(at + BAND - k) % BAND] += row[BAND - k] * value;
        }
        // The farthest one, for which this is the first.
        taken[at] = row[0] * value;
    };
    for (at, (row, y)) in rows_left.iter().zip(left).enumerate().rev() {
        one(at % BAND, row, y);
    }
    for (rows, block) in rows.iter().zip(blocks).rev() {
        for at in (0..BAND).rev() {
            one(at, &rows[at], &mut block[at]);
        }
    }
}
