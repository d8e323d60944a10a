//! The banded KKT system in joint angles and closure multipliers.
//!
//! Unknowns per cell: λx, λy, φ_front, φ_lamella, φ_back; the tip cell has λx, λy, φ_tip. Half-bandwidth 6. The factorisation
//! is L D Lᵀ without interchanges: symmetric, so the signs of D are the inertia, and the multipliers of a closure come
//! before the angles they bind, where their pivots are the members' flexibility. A pivot that nearly vanishes is bounded,
//! as in [`super::condense`].

use super::Workspace;
use super::condense::{bounded, pivot_bound};
use crate::ladder::{CLAMPED, Ladder, PER_CELL};
use crate::real::Real;
use crate::size::Size;

/// Half-bandwidth.
pub(crate) const BAND: usize = 6;

#[inline]
fn add<T: Real>(band: &mut [[T; BAND + 1]], i: usize, j: usize, value: T) {
    let (row, column) = if i >= j { (i, j) } else { (j, i) };
    if let Some(entry) = band[row].get_mut(BAND + column - row) {
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

/// Assembles matrix and right-hand side (the negative residual) from the condensed members.
///
/// On entry `rhs` holds the joints' gradients.
pub(crate) fn assemble<T: Real, S: Size>(ladder: &Ladder<T, S>, work: &mut Workspace<T, S>) {
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
    for (index, member) in ladder.members.as_ref()[..ladder.member_count()].iter().enumerate() {
        let c = &work.members.as_ref()[index].condensed;
        let (terms, count) = force_terms::<T>(index);
        let b = usize::from(member.end);
        add(band, b, b, c.bb);
        rhs[b] += c.rb;
        if member.start != CLAMPED {
            let a = usize::from(member.start);
            add(band, a, a, c.aa);
            // A weld joins both ends in one unknown.
            add(band, a, b, if a == b { c.ab + c.ab } else { c.ab });
            rhs[a] += c.ra;
            for &(u, sign) in &terms[..count] {
                add(band, a, u, sign * c.ax[0]);
                add(band, a, u + 1, sign * c.ax[1]);
            }
        }
        for (k, &(u, sign)) in terms[..count].iter().enumerate() {
            add(band, b, u, sign * c.bx[0]);
            add(band, b, u + 1, sign * c.bx[1]);
            rhs[u] += sign * c.rx[0];
            rhs[u + 1] += sign * c.rx[1];
            add(band, u, u, c.xx);
            add(band, u + 1, u, c.xy);
            add(band, u + 1, u + 1, c.yy);
            if k == 1 {
                let (v, other) = terms[0];
                let s = sign * other;
                add(band, u, v, s * c.xx);
                add(band, u, v + 1, s * c.xy);
                add(band, u + 1, v, s * c.xy);
                add(band, u + 1, v + 1, s * c.yy);
            }
        }
    }
    for value in &mut rhs[..n] {
        *value = -*value;
    }
}

/// Factorises in place; the diagonal becomes the inverse pivots. Returns the number of negative pivots.
pub(crate) fn factorise<T: Real>(band: &mut [[T; BAND + 1]], scale: &[T]) -> usize {
    let n = band.len();
    let bound = pivot_bound::<T>();
    let mut negative = 0;
    for p in 0..n {
        let least = if scale[p] > T::ZERO { scale[p] } else { T::one() };
        let (pivot, is_negative) = bounded(band[p][BAND], bound * least);
        negative += usize::from(is_negative);
        let inverse = T::one() / pivot;
        band[p][BAND] = inverse;
        let reach = BAND.min(n - 1 - p);
        // Column p below the diagonal, and the same divided by the pivot.
        let mut column = [T::ZERO; BAND + 1];
        for k in 1..=reach {
            column[k] = band[p + k][BAND - k];
        }
        for k in 1..=reach {
            let multiplier = column[k] * inverse;
            let row = &mut band[p + k];
            for m in 1..=k {
                row[BAND - k + m] -= multiplier * column[m];
            }
            row[BAND - k] = multiplier;
        }
    }
    negative
}

/// y = L⁻¹ x in place.
#[inline]
pub(crate) fn forward<T: Real>(band: &[[T; BAND + 1]], x: &mut [T]) {
    // The last values, newest first: registers instead of indices.
    let mut last = [T::ZERO; BAND];
    for (row, x) in band.iter().zip(x) {
        let mut value = *x;
        for k in 0..BAND {
            value -= row[BAND - 1 - k] * last[k];
        }
        *x = value;
        last.copy_within(0..BAND - 1, 1);
        last[0] = value;
    }
}

/// x = L⁻ᵀ D⁻¹ y in place.
#[inline]
pub(crate) fn backward<T: Real>(band: &[[T; BAND + 1]], y: &mut [T]) {
    let n = band.len().min(y.len());
    for i in 0..n {
        y[i] *= band[i][BAND];
    }
    for i in (0..n).rev() {
        let value = y[i];
        let row = &band[i];
        for k in 1..=BAND.min(i) {
            y[i - k] -= row[BAND - k] * value;
        }
    }
}
