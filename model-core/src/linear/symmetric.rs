//! Dense symmetric indefinite matrices: L B Lᵀ with 1×1 and 2×2 pivots and complete pivoting (Bunch & Parlett, SIAM J. Numer. Anal. 8,
//! 1971), tried without interchanges first. The signs in B are the matrix's inertia.
//!
//! Matrices are in full storage, `stride` entries per row.

use crate::access::Access;
use crate::real::Real;

/// Bunch and Parlett's (1 + √17)/8: below this ratio of the largest diagonal to the largest entry a 2×2 pivot is taken.
const ALPHA: f64 = 0.640_388_203_202_208_4;
/// Marks the first of two rows of a 2×2 pivot in the pivot order.
const PAIR: u16 = 0x8000;

/// Entry in row i and column j. What lies outside of the matrix is zero.
#[inline(always)]
pub(crate) fn entry<T: Real>(a: &[T], stride: usize, i: usize, j: usize) -> T {
    a.at(i * stride + j)
}

/// Exchanges rows and columns i and j of a symmetric matrix in full storage.
fn exchange<T: Real>(a: &mut [T], n: usize, stride: usize, i: usize, j: usize) {
    let mut swap = |from: usize, to: usize| {
        let (x, y) = (a.at(from), a.at(to));
        a.put(from, y);
        a.put(to, x);
    };
    if i == j {
        return;
    }
    for k in 0..n {
        swap(i * stride + k, j * stride + k);
    }
    for k in 0..n {
        swap(k * stride + i, k * stride + j);
    }
}

/// Exchanges two places in the order of the pivots.
fn swap(order: &mut [u16], i: usize, j: usize) {
    let (x, y) = (order.at(i), order.at(j));
    order.put(i, y);
    order.put(j, x);
}

/// Goes on with the factorisation L D Lᵀ without interchanges of the lower triangle of the leading n×n block, the first `done`
/// rows being factorised already; false if a pivot falls so far below its diagonal entry that interchanges are called for.
///
/// Where D is positive definite but for the turning of the force, which is almost always, this is all it takes: a quarter of
/// the work of [`factorise`], and a row that comes last costs no more than its own.
pub(crate) fn factorise_in_order<T: Real>(
    a: &mut [T],
    done: usize,
    n: usize,
    stride: usize,
    order: &mut [u16],
) -> bool {
    let least = T::EPSILON.sqrt();
    for (i, place) in order.iter_mut().enumerate().take(n).skip(done) {
        *place = i as u16;
        let Some((above, row)) = a.split_at_mut_checked(i * stride) else { return false };
        let Some(row) = row.get_mut(..=i) else { return false };
        let diagonal = row[i];
        // Row i of L times D, then of L: each entry less what the columns before it have taken.
        let mut pivot = diagonal;
        for j in 0..i {
            let Some(other) = above.get(j * stride..j * stride + j) else { return false };
            row[j] -= product(&row[..j], other);
        }
        for j in 0..i {
            let Some(&divisor) = above.get(j * stride + j) else { return false };
            let value = row[j];
            let l = value / divisor;
            pivot -= value * l;
            row[j] = l;
        }
        if pivot.abs() <= least * diagonal.abs() {
            return false;
        }
        row[i] = pivot;
    }
    true
}

/// Σ aᵢ bᵢ over the shorter of both, in two sums: one would wait for itself.
#[inline(always)]
pub(crate) fn product<T: Real>(a: &[T], b: &[T]) -> T {
    let count = a.len().min(b.len());
    let ((a, a_left), (b, b_left)) = (a.run(0..count).as_chunks::<4>(), b.run(0..count).as_chunks::<4>());
    let mut sums = [T::ZERO; 2];
    for (a, b) in a.iter().zip(b) {
        sums = [sums[0] + a[0] * b[0] + a[2] * b[2], sums[1] + a[1] * b[1] + a[3] * b[3]];
    }
    let ((a, a_left), (b, b_left)) = (a_left.as_chunks::<2>(), b_left.as_chunks::<2>());
    for (a, b) in a.iter().zip(b) {
        sums = [sums[0] + a[0] * b[0], sums[1] + a[1] * b[1]];
    }
    match (a_left.first(), b_left.first()) {
        (Some(&a), Some(&b)) => sums[0] + a * b + sums[1],
        _ => sums[0] + sums[1],
    }
}

/// Factorises the leading n×n block in place; returns the number of negative eigenvalues.
///
/// A pivot that vanishes beside the largest entry met is replaced by a small positive one.
pub(crate) fn factorise<T: Real>(a: &mut [T], n: usize, stride: usize, order: &mut [u16]) -> usize {
    let mut negative = 0;
    let mut largest = T::ZERO;
    for i in 0..n {
        order.put(i, i as u16);
        for j in 0..n {
            largest = largest.max(entry(a, stride, i, j).abs());
        }
    }
    let least = (largest * T::EPSILON).max(T::of(1e-30));
    let mut k = 0;
    while k < n {
        let (mut r, mut diagonal) = (k, T::ZERO);
        let (mut p, mut q, mut off) = (k, k, T::ZERO);
        for i in k..n {
            let here = entry(a, stride, i, i).abs();
            if here > diagonal {
                (r, diagonal) = (i, here);
            }
            for j in k..i {
                let here = entry(a, stride, i, j).abs();
                if here > off {
                    (p, q, off) = (i, j, here);
                }
            }
        }
        if diagonal >= T::of(ALPHA) * off {
            exchange(a, n, stride, k, r);
            swap(order, k, r);
            let mut pivot = entry(a, stride, k, k);
            if pivot.abs() < least {
                pivot = least;
            }
            negative += usize::from(pivot < T::ZERO);
            a.put(k * stride + k, pivot);
            let inverse = T::one() / pivot;
            for i in k + 1..n {
                let l = entry(a, stride, i, k) * inverse;
                for j in k + 1..=i {
                    // The upper triangle still holds the undivided column.
                    let v = entry(a, stride, i, j) - l * entry(a, stride, k, j);
                    a.put(i * stride + j, v);
                    a.put(j * stride + i, v);
                }
                a.put(i * stride + k, l);
            }
            k += 1;
        } else {
            exchange(a, n, stride, k, q);
            swap(order, k, q);
            // The exchange may have moved row p.
            let p = if p == k { q } else { p };
            exchange(a, n, stride, k + 1, p);
            swap(order, k + 1, p);
            let (d, e, f) = pair(a, stride, k);
            // |e| is the largest entry and both diagonals are smaller than ALPHA |e|: the determinant is negative.
            let inverse = T::one() / (d * f - e * e);
            negative += 1;
            for i in k + 2..n {
                let (u, v) = (entry(a, stride, i, k), entry(a, stride, i, k + 1));
                let (l, m) = ((u * f - v * e) * inverse, (v * d - u * e) * inverse);
                for j in k + 2..=i {
                    let w = entry(a, stride, i, j) - l * entry(a, stride, k, j) - m * entry(a, stride, k + 1, j);
                    a.put(i * stride + j, w);
                    a.put(j * stride + i, w);
                }
                a.put(i * stride + k, l);
                a.put(i * stride + k + 1, m);
            }
            order.put(k, order.at(k) | PAIR);
            k += 2;
        }
    }
    negative
}

/// Diagonal, off-diagonal and second diagonal entry of the 2×2 block at k.
fn pair<T: Real>(a: &[T], stride: usize, k: usize) -> (T, T, T) {
    (entry(a, stride, k, k), entry(a, stride, k + 1, k), entry(a, stride, k + 1, k + 1))
}

/// Factorises the leading n×n block of `from` into `a`: in the order of the rows that `place` gives if that does without
/// interchanges.
pub(crate) fn factorise_from<T: Real>(
    from: &[T],
    a: &mut [T],
    n: usize,
    stride: usize,
    order: &mut [u16],
    place: impl Fn(usize) -> usize,
) {
    for i in 0..n {
        for j in 0..=i {
            a.put(i * stride + j, entry(from, stride, place(i), place(j)));
        }
    }
    if factorise_in_order(a, 0, n, stride, order) {
        for (i, order) in order.iter_mut().enumerate().take(n) {
            *order = place(i) as u16;
        }
        return;
    }
    for (into, &from) in a.iter_mut().zip(from).take(n * stride) {
        *into = from;
    }
    factorise(a, n, stride, order);
}

/// Solves with the factors; `x` is in and out, `y` is scratch.
pub(crate) fn solve<T: Real>(a: &[T], n: usize, stride: usize, order: &[u16], x: &mut [T], y: &mut [T]) {
    let (Some(y), Some(order)) = (y.get_mut(..n), order.get(..n)) else { return };
    for (y, &place) in y.iter_mut().zip(order) {
        *y = x.at(usize::from(place & !PAIR));
    }
    // Row by row: what the rows above it, but for the other of its own pair, have taken.
    let mut second = false;
    for i in 0..n {
        let (above, rest) = y.split_at_mut(i);
        let (Some(row), Some(value)) = (a.get(i * stride..), rest.first_mut()) else { return };
        *value -= product(row, above.get(..i - usize::from(second)).unwrap_or(&[]));
        second = !second && order.at(i) & PAIR != 0;
    }
    let mut k = 0;
    while k < n {
        if order.at(k) & PAIR != 0 {
            let (d, e, f) = pair(a, stride, k);
            let inverse = T::one() / (d * f - e * e);
            let (u, v) = (y.at(k), y.at(k + 1));
            y.put(k, (u * f - v * e) * inverse);
            y.put(k + 1, (v * d - u * e) * inverse);
            k += 2;
        } else {
            y.put(k, y.at(k) / entry(a, stride, k, k));
            k += 1;
        }
    }
    for k in (0..n).rev() {
        // Within a pair there is no multiplier: L's block is the identity.
        let second = k > 0 && order.at(k - 1) & PAIR != 0;
        let (above, rest) = y.split_at_mut(k);
        let (Some(row), Some(&value)) = (a.get(k * stride..), rest.first()) else { return };
        let above = above.get_mut(..k - usize::from(second)).unwrap_or(&mut []);
        let row = row.run(0..above.len());
        let ((fours, left), (above, above_left)) = (row.as_chunks::<4>(), above.as_chunks_mut::<4>());
        for (above, row) in above.iter_mut().zip(fours) {
            for i in 0..4 {
                above[i] -= row[i] * value;
            }
        }
        for (above, &l) in above_left.iter_mut().zip(left) {
            *above -= l * value;
        }
    }
    for (&y, &place) in y.iter().zip(order) {
        x.put(usize::from(place & !PAIR), y);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random_designs::Random;
    use nalgebra::{DMatrix, DVector};
    use std::vec::Vec;

    const STRIDE: usize = 14;

    /// A random indefinite matrix, every third with a diagonal of zeros, which no 1×1 pivot takes.
    fn matrix(random: &mut Random, n: usize, round: usize) -> (DMatrix<f64>, Vec<f64>) {
        let mut dense = DMatrix::from_fn(n, n, |_, _| random.signed());
        dense = &dense + dense.transpose();
        if round.is_multiple_of(3) {
            dense.fill_diagonal(0.0);
        }
        let mut full = vec![0.0; STRIDE * STRIDE];
        for i in 0..n {
            for j in 0..n {
                full[i * STRIDE + j] = dense[(i, j)];
            }
        }
        (dense, full)
    }

    fn assert_solves(dense: &DMatrix<f64>, factors: &[f64], order: &[u16], random: &mut Random) {
        let n = dense.nrows();
        let right: Vec<f64> = (0..n).map(|_| random.signed()).collect();
        let (mut found, mut spare) = (right.clone(), vec![0.0; n]);
        solve(factors, n, STRIDE, order, &mut found, &mut spare);
        let left = dense * DVector::from_vec(found.clone());
        let size = found.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
        for (left, right) in left.iter().zip(&right) {
            assert!((left - right).abs() < 1e-11 * size, "{n}: {left} against {right}");
        }
    }

    #[test]
    fn factors_solve_and_count_as_dense_algebra_does() {
        let mut random = Random::new(2);
        let mut pairs = 0;
        for round in 0..200 {
            let n = 1 + round % (STRIDE - 1);
            let (dense, mut factors) = matrix(&mut random, n, round);
            let eigenvalues = dense.clone().symmetric_eigenvalues();
            if eigenvalues.iter().any(|value| value.abs() < 1e-3) {
                continue;
            }
            let mut order = [0; STRIDE];
            let negative = factorise(&mut factors, n, STRIDE, &mut order);
            assert_eq!(negative, eigenvalues.iter().filter(|value| **value < 0.0).count());
            pairs += order.iter().take(n).filter(|place| **place & PAIR != 0).count();
            assert_solves(&dense, &factors, &order, &mut random);
        }
        assert!(pairs > 50, "{pairs}");
    }

    /// Rows that are added to factors in order leave what a factorisation of the whole leaves, and a pivot that vanishes is refused.
    #[test]
    fn a_factorisation_in_order_goes_on_where_it_ended() {
        let mut random = Random::new(3);
        for n in 2..STRIDE {
            let root = DMatrix::from_fn(n, n, |_, _| random.signed());
            let dense = &root * root.transpose() + DMatrix::identity(n, n);
            let mut whole = vec![0.0; STRIDE * STRIDE];
            for i in 0..n {
                for j in 0..n {
                    whole[i * STRIDE + j] = dense[(i, j)];
                }
            }
            let (mut parts, mut order) = (whole.clone(), [0; STRIDE]);
            assert!(factorise_in_order(&mut whole, 0, n, STRIDE, &mut order));
            assert!(factorise_in_order(&mut parts, 0, n / 2, STRIDE, &mut order));
            assert!(factorise_in_order(&mut parts, n / 2, n, STRIDE, &mut order));
            assert_eq!(whole, parts);
            assert_solves(&dense, &whole, &order, &mut random);
        }
        let mut zero_diagonal = [0.0, 1.0, 1.0, 0.0];
        assert!(!factorise_in_order(&mut zero_diagonal, 0, 2, 2, &mut [0; 2]));
    }

    /// Whatever order the rows are given in, and whether interchanges are called for or not.
    #[test]
    fn factors_in_a_given_order_are_of_the_same_matrix() {
        let mut random = Random::new(4);
        for round in 0..60 {
            let n = 2 + round % (STRIDE - 2);
            let (dense, full) = matrix(&mut random, n, round);
            if dense.clone().symmetric_eigenvalues().iter().any(|value| value.abs() < 1e-2) {
                continue;
            }
            let (mut factors, mut order) = (vec![0.0; STRIDE * STRIDE], [0; STRIDE]);
            factorise_from(&full, &mut factors, n, STRIDE, &mut order, |i| n - 1 - i);
            let mut found: Vec<f64> = (0..n).map(|_| random.signed()).collect();
            let right = DVector::from_vec(found.clone());
            solve(&factors, n, STRIDE, &order, &mut found, &mut [0.0; STRIDE]);
            let left = &dense * DVector::from_vec(found);
            // Without interchanges the factors may grow by the square root of the precision.
            assert!((left - right).amax() < 1e-6, "round {round}");
        }
    }
}
