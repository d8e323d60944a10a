//! Dense unsymmetric matrices: L U with interchanges of rows, for contacts that slip.
//!
//! Matrices are in full storage, `stride` entries per row.

use super::symmetric::product;
use crate::access::Access;
use crate::real::Real;

/// Columns that are eliminated together: an entry beyond them is written once for all of them.
const TOGETHER: usize = 4;

/// Factorises the leading n×n block in place, L below the diagonal (its own diagonal being 1) and U on and above it; `order` gets the row
/// that each pivot was taken from.
///
/// A pivot that vanishes beside the largest so far is replaced by one just large enough: the factors are then those of a matrix that
/// differs from the given one by rounding.
pub(crate) fn factorise<T: Real>(a: &mut [T], n: usize, stride: usize, order: &mut [u16]) {
    let mut largest = T::ZERO;
    for first in (0..n).step_by(TOGETHER) {
        let end = (first + TOGETHER).min(n);
        for k in first..end {
            largest = largest.max(exchange(a, k, n, stride, order));
            let Some((above, below)) = a.split_at_mut_checked((k + 1) * stride) else { return };
            let Some([pivot, beyond @ ..]) = above.get_mut(k * stride + k..k * stride + end) else { return };
            let least = (largest * T::EPSILON).max(T::of(1e-30));
            if pivot.abs() < least {
                *pivot = if *pivot < T::ZERO { -least } else { least };
            }
            let inverse = T::one() / *pivot;
            for row in below.chunks_mut(stride.max(1)).take(n - k - 1) {
                let Some([part, rest @ ..]) = row.get_mut(k..end) else { return };
                *part *= inverse;
                for (value, &upper) in rest.iter_mut().zip(&*beyond) {
                    *value -= *part * upper;
                }
            }
        }
        // The columns beyond: first of the pivots' rows, then of those below.
        let Some((above, below)) = a.split_at_mut_checked(end * stride) else { return };
        for k in first + 1..end {
            let Some((above, row)) = above.split_at_mut_checked(k * stride) else { return };
            let Some((row, beyond)) = row.get_mut(..n).and_then(|row| row.split_at_mut_checked(end)) else { return };
            for (m, &part) in (first..k).zip(row.iter().skip(first)) {
                for (value, &upper) in beyond.iter_mut().zip(above.run(m * stride + end..m * stride + n)) {
                    *value -= part * upper;
                }
            }
        }
        if end < n {
            let upper = |i: usize| above.run((first + i) * stride + end..(first + i) * stride + n);
            let upper = [upper(0), upper(1), upper(2), upper(3)];
            for row in below.chunks_mut(stride.max(1)).take(n - end) {
                let Some((row, beyond)) = row.get_mut(..n).and_then(|row| row.split_at_mut_checked(end)) else {
                    return;
                };
                if let Some(parts) = row.last_chunk() {
                    take(beyond, parts, upper);
                }
            }
        }
    }
}

/// Takes the largest entry of a column, from the diagonal down, for its pivot; returns its magnitude.
fn exchange<T: Real>(a: &mut [T], k: usize, n: usize, stride: usize, order: &mut [u16]) -> T {
    let (mut from, mut size) = (k, a.at(k * stride + k).abs());
    for i in k + 1..n {
        let here = a.at(i * stride + k).abs();
        if here > size {
            (from, size) = (i, here);
        }
    }
    order.put(k, from as u16);
    if from > k
        && let Some((above, below)) = a.split_at_mut_checked(from * stride)
        && let (Some(pivots), Some(row)) = (above.get_mut(k * stride..k * stride + n), below.get_mut(..n))
    {
        pivots.iter_mut().zip(row).for_each(|(upper, lower)| core::mem::swap(upper, lower));
    }
    size
}

/// Takes multiples of rows from a row.
#[inline(always)]
fn take<T: Real>(row: &mut [T], &[a, b, c, d]: &[T; TOGETHER], rows: [&[T]; TOGETHER]) {
    let (row, left) = row.as_chunks_mut::<4>();
    let [(x, x_left), (y, y_left), (z, z_left), (w, w_left)] = rows.map(<[T]>::as_chunks::<4>);
    let minus = |value: &mut T, x: T, y: T, z: T, w: T| *value = *value - a * x - b * y - c * z - d * w;
    for (row, ((x, y), (z, w))) in row.iter_mut().zip(x.iter().zip(y).zip(z.iter().zip(w))) {
        for i in 0..4 {
            minus(&mut row[i], x[i], y[i], z[i], w[i]);
        }
    }
    for (value, ((&x, &y), (&z, &w))) in left.iter_mut().zip(x_left.iter().zip(y_left).zip(z_left.iter().zip(w_left))) {
        minus(value, x, y, z, w);
    }
}

/// Solves A x = b with the factors; `x` is b on entry.
pub(crate) fn solve<T: Real>(a: &[T], n: usize, stride: usize, order: &[u16], x: &mut [T]) {
    for (k, &from) in order.iter().enumerate().take(n) {
        let (here, there) = (x.at(k), x.at(usize::from(from)));
        x.put(k, there);
        x.put(usize::from(from), here);
    }
    for i in 1..n {
        let value = x.at(i) - product(a.run(i * stride..i * stride + i), x);
        x.put(i, value);
    }
    for i in (0..n).rev() {
        let Some((pivot, row)) = a.get(i * stride + i..i * stride + n).and_then(<[T]>::split_first) else { return };
        let value = (x.at(i) - product(row, x.get(i + 1..).unwrap_or(&[]))) / *pivot;
        x.put(i, value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random_designs::Random;

    const STRIDE: usize = 12;

    /// The solution that the factors give.
    fn solved(a: &[f64; STRIDE * STRIDE], n: usize, b: &[f64]) -> [f64; STRIDE] {
        let (mut factors, mut order, mut x) = (*a, [0; STRIDE], [0.0; STRIDE]);
        x[..n].copy_from_slice(&b[..n]);
        factorise(&mut factors, n, STRIDE, &mut order);
        solve(&factors, n, STRIDE, &order, &mut x);
        x
    }

    #[test]
    fn the_solution_times_the_matrix_is_the_right_hand_side() {
        let mut random = Random::new(31);
        for round in 0..400 {
            let n = 1 + round % STRIDE;
            let mut a = [0.0; STRIDE * STRIDE];
            for i in 0..n {
                for j in 0..n {
                    // Many zeros, on the diagonal too, so that rows must be interchanged.
                    a[i * STRIDE + j] = if random.unit() < 0.4 { 0.0 } else { random.signed() };
                }
                a[i * STRIDE + (i + 1) % n] += 3.0;
            }
            let b: [f64; STRIDE] = core::array::from_fn(|_| random.signed());
            let x = solved(&a, n, &b);
            for i in 0..n {
                let product: f64 = (0..n).map(|j| a[i * STRIDE + j] * x[j]).sum();
                assert!((product - b[i]).abs() < 1e-10, "{n}: {product} against {}", b[i]);
            }
        }
    }

    #[test]
    fn a_singular_matrix_gives_finite_numbers() {
        let mut a = [0.0; STRIDE * STRIDE];
        (a[0], a[1], a[STRIDE], a[STRIDE + 1]) = (1.0, 2.0, 2.0, 4.0);
        assert!(solved(&a, 2, &[1.0, 2.0]).iter().all(|x| x.is_finite()));
        assert!(solved(&[0.0; STRIDE * STRIDE], 3, &[1.0, 2.0, 3.0]).iter().all(|x| x.is_finite()));
        assert_eq!(solved(&a, 0, &[]), [0.0; STRIDE]);
    }
}
