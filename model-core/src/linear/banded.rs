//! L D Lᵀ of a symmetric banded matrix, without interchanges.
//!
//! The half-bandwidth is [`BAND`]. A row holds its lower band, farthest entry first, the diagonal last. The signs in D are the matrix's
//! inertia. A pivot that nearly vanishes is bounded ([`super::pivot`]).

use super::pivot::{bounded, pivot_bound};
use crate::real::Real;

/// Half-bandwidth.
pub(crate) const BAND: usize = 6;

/// Factorises in place; the diagonal becomes the inverse pivots. `scale` is the magnitude of each diagonal entry that bounds its pivot,
/// 0 for 1. Returns the number of negative pivots.
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

/// y = L⁻¹ x in place, where the entries before `from`, a multiple of the bandwidth, are substituted.
#[inline]
pub(crate) fn forward<T: Real>(band: &[[T; BAND + 1]], x: &mut [T], from: usize) {
    let (mut last, x) = last_values(x, from);
    let (rows, rows_left) = band.get(from..).unwrap_or(&[]).as_chunks::<BAND>();
    let (blocks, left) = x.as_chunks_mut::<BAND>();
    for (rows, block) in rows.iter().zip(blocks) {
        for at in 0..BAND {
            block[at] = next(&mut last, at, &rows[at], block[at]);
        }
    }
    for (at, (row, x)) in rows_left.iter().zip(left).enumerate() {
        *x = next(&mut last, at % BAND, row, *x);
    }
}

/// As [`forward`] for two at once, which share what is loaded of L.
#[inline(never)]
pub(crate) fn forward_both<T: Real>(band: &[[T; BAND + 1]], x: &mut [T], y: &mut [T], from: usize) {
    let ((mut last_x, x), (mut last_y, y)) = (last_values(x, from), last_values(y, from));
    let (rows, rows_left) = band.get(from..).unwrap_or(&[]).as_chunks::<BAND>();
    let ((x_blocks, x_left), (y_blocks, y_left)) = (x.as_chunks_mut::<BAND>(), y.as_chunks_mut::<BAND>());
    for ((rows, x), y) in rows.iter().zip(x_blocks).zip(y_blocks) {
        for at in 0..BAND {
            x[at] = next(&mut last_x, at, &rows[at], x[at]);
            y[at] = next(&mut last_y, at, &rows[at], y[at]);
        }
    }
    for (at, ((row, x), y)) in rows_left.iter().zip(x_left).zip(y_left).enumerate() {
        *x = next(&mut last_x, at % BAND, row, *x);
        *y = next(&mut last_y, at % BAND, row, *y);
    }
}

/// The last substituted values before an unknown, each in the place of its unknown modulo the bandwidth: registers instead of indices;
/// and those that are not substituted yet.
#[inline(always)]
fn last_values<T: Real>(x: &mut [T], from: usize) -> ([T; BAND], &mut [T]) {
    debug_assert!(from.is_multiple_of(BAND) && from <= x.len(), "{from} of {}", x.len());
    let (done, rest) = x.split_at_mut_checked(from).unwrap_or_default();
    (done.last_chunk().copied().unwrap_or([T::ZERO; BAND]), rest)
}

/// The value of an unknown, whose place modulo the bandwidth is `at`, from the last ones.
#[inline(always)]
fn next<T: Real>(last: &mut [T; BAND], at: usize, row: &[T; BAND + 1], mut value: T) -> T {
    for k in 0..BAND {
        value -= row[BAND - 1 - k] * last[(at + BAND - 1 - k) % BAND];
    }
    last[at] = value;
    value
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random_designs::Random;
    use nalgebra::{DMatrix, DVector};
    use std::vec::Vec;

    /// A random matrix with pivots of both signs, its band beside it.
    fn matrix(random: &mut Random, n: usize) -> (DMatrix<f64>, Vec<[f64; BAND + 1]>) {
        let mut dense = DMatrix::zeros(n, n);
        let mut band = vec![[0.0; BAND + 1]; n];
        for i in 0..n {
            for j in i.saturating_sub(BAND)..=i {
                let own = if i % 3 == 0 { -4.0 } else { 4.0 };
                let value = if i == j { own + random.signed() } else { random.signed() };
                (dense[(i, j)], dense[(j, i)]) = (value, value);
                band[i][BAND + j - i] = value;
            }
        }
        (dense, band)
    }

    #[test]
    fn solves_and_counts_as_dense_algebra_does() {
        let mut random = Random::new(1);
        for n in [1, 2, 5, 6, 7, 13, 38, 63] {
            let (dense, mut band) = matrix(&mut random, n);
            let right: Vec<f64> = (0..n).map(|_| random.signed()).collect();
            let negative = factorise(&mut band, &[]);
            assert_eq!(negative, dense.symmetric_eigenvalues().iter().filter(|value| **value < 0.0).count());
            let mut found = right.clone();
            let (mut twin, mut double) = (found.clone(), found.iter().map(|x| 2.0 * x).collect::<Vec<_>>());
            forward_both(&band, &mut twin, &mut double, 0);
            forward(&band, &mut found, 0);
            assert_eq!(twin, found);
            assert!(double.iter().zip(&found).all(|(double, one)| *double == 2.0 * one));
            // A substitution goes on where it ended.
            for from in (0..=n).step_by(BAND) {
                let (mut one, mut other) = (right.clone(), right.clone());
                forward(&band[..from], &mut one[..from], 0);
                forward_both(&band[..from], &mut other[..from], &mut right.clone()[..from], 0);
                forward(&band, &mut one, from);
                forward_both(&band, &mut other, &mut one.clone(), from);
                assert_eq!((&one, &other), (&found, &found), "{n} from {from}");
            }
            backward(&band, &mut found);
            let exact = dense.lu().solve(&DVector::from_vec(right)).expect("a regular matrix");
            for (found, exact) in found.iter().zip(&exact) {
                assert!((found - exact).abs() < 1e-11 * exact.abs().max(1.0), "{n}: {found} against {exact}");
            }
        }
    }

    /// Of a singular matrix the factors stay finite, and the vanishing pivot is as small as its scale says.
    #[test]
    fn a_pivot_that_vanishes_is_bounded_by_its_scale() {
        let mut band = [[0.0; BAND + 1]; 3];
        for row in &mut band {
            row[BAND] = 1.0;
        }
        // The second row equals the first.
        band[1][BAND - 1] = 1.0;
        assert_eq!(factorise(&mut band, &[1.0, 50.0, 1.0]), 0);
        assert_eq!(band[1][BAND], 1.0 / (50.0 * pivot_bound::<f64>()));
        assert_eq!(band[2][BAND], 1.0);
    }
}
