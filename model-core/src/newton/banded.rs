//! The banded KKT system in joint angles and closure multipliers.
//!
//! Unknowns per cell: λx, λy, φ_front, φ_lamella, φ_back; the tip cell has λx, λy, φ_tip. Half-bandwidth 6. The factorisation
//! is L D Lᵀ without interchanges: symmetric, so the signs of D are the inertia, and the multipliers of a closure come
//! before the angles they bind, where their pivots are the members' flexibility. A pivot that nearly vanishes is bounded,
//! as in `condense`.

use super::Workspace;
use super::condense::{Condensed, bounded, pivot_bound};
use crate::ladder::{CLAMPED, Ladder, PER_CELL};
use crate::real::Real;
use crate::size::Size;

/// Half-bandwidth.
pub(crate) const BAND: usize = 6;

/// Adds to the entry of a row and a column that is not beyond the diagonal.
#[inline(always)]
fn add<T: Real>(band: &mut [[T; BAND + 1]], row: usize, column: usize, value: T) {
    if let Some(entry) = band.get_mut(row).and_then(|entries| entries.get_mut((BAND + column).wrapping_sub(row))) {
        *entry += value;
    }
}

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
    let n = ladder.unknowns();
    let (band, rhs) = (work.band.as_mut(), work.rhs.as_mut());
    band[..n].fill([T::ZERO; BAND + 1]);
    for cell in 0..ladder.cells {
        let closure = work.closure.as_ref()[cell];
        rhs[PER_CELL * cell] = closure[0];
        rhs[PER_CELL * cell + 1] = closure[1];
        if ladder.welded && cell + 1 < ladder.cells {
            band[PER_CELL * cell + 2][BAND] = T::one();
            band[PER_CELL * cell + 3][BAND] = T::one();
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
    let member = &ladder.members.as_ref()[index];
    let (band, rhs) = (work.band.as_mut(), work.rhs.as_mut());
    let own = PER_CELL * (index / 4);
    let b = usize::from(member.end);
    // Own closure before the end joint, and its start joint before that (a span's) or between the two (a hinge's).
    let side = if index % 4 == 1 { -T::one() } else { T::one() };
    add(band, b, b, c.bb);
    add(band, b, own, side * c.bx[0]);
    add(band, b, own + 1, side * c.bx[1]);
    add(band, own, own, c.xx);
    add(band, own + 1, own, c.xy);
    add(band, own + 1, own + 1, c.yy);
    rhs[b] += c.rb;
    rhs[own] += side * c.rx[0];
    rhs[own + 1] += side * c.rx[1];
    let clamped = member.start == CLAMPED;
    let a = usize::from(member.start);
    if !clamped {
        add(band, a, a, c.aa);
        // A weld joins both ends in one unknown.
        add(band, b, a, if a == b { c.ab + c.ab } else { c.ab });
        rhs[a] += c.ra;
    }
    if index % 4 < 2 {
        if !clamped {
            add(band, own, a, side * c.ax[0]);
            add(band, own + 1, a, side * c.ax[1]);
        }
        return;
    }
    let next = own + PER_CELL;
    add(band, a, own, c.ax[0]);
    add(band, a, own + 1, c.ax[1]);
    for (at, joint) in [(a, c.ax), (b, c.bx)] {
        add(band, next, at, -joint[0]);
        add(band, next + 1, at, -joint[1]);
    }
    for (row, entries) in [(next, [c.xx, c.xy]), (next + 1, [c.xy, c.yy])] {
        add(band, row, own, -entries[0]);
        add(band, row, own + 1, -entries[1]);
    }
    add(band, next, next, c.xx);
    add(band, next + 1, next, c.xy);
    add(band, next + 1, next + 1, c.yy);
    rhs[next] -= c.rx[0];
    rhs[next + 1] -= c.rx[1];
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
            let count = below.len();
            padded[..count].copy_from_slice(below);
            eliminate(&mut padded, &mut column, inverse);
            below.copy_from_slice(&padded[..count]);
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
    for (y, row) in y.iter_mut().zip(band) {
        *y *= row[BAND];
    }
    let mut rest = y;
    let mut rows = band.iter().rev();
    while let (Some((value, above)), Some(row)) = (rest.split_last_mut(), rows.next()) {
        // A row's multipliers belong to the unknowns just above it; before the first there are none.
        for (x, &multiplier) in above.iter_mut().rev().zip(row[..BAND].iter().rev()) {
            *x -= multiplier * *value;
        }
        rest = above;
    }
}
