//! Dense unsymmetric matrices: L U with interchanges of rows, for contacts that slip.
//!
//! Matrices are in full storage, `stride` entries per row.

use crate::access::Access;
use crate::real::Real;

/// Factorises the leading n×n block in place, L below the diagonal (its own diagonal being 1) and U on and above it; `order` gets the row
/// that each pivot was taken from.
///
/// A pivot that vanishes beside the largest entry of the matrix is replaced by one just large enough: the factors are then those of a
/// matrix that differs from the given one by rounding.
pub(crate) fn factorise<T: Real>(a: &mut [T], n: usize, stride: usize, order: &mut [u16]) {
    let largest = a
        .chunks(stride.max(1))
        .take(n)
        .flat_map(|row| row.iter().take(n))
        .fold(T::ZERO, |most, entry| most.max(entry.abs()));
    let least = (largest * T::EPSILON).max(T::of(1e-30));
    for k in 0..n {
        let (mut from, mut size) = (k, T::ZERO);
        for i in k..n {
            let here = a.at(i * stride + k).abs();
            if here > size {
                (from, size) = (i, here);
            }
        }
        order.put(k, from as u16);
        if from != k {
            for j in 0..n {
                let (upper, lower) = (a.at(k * stride + j), a.at(from * stride + j));
                a.put(k * stride + j, lower);
                a.put(from * stride + j, upper);
            }
        }
        let Some((above, below)) = a.split_at_mut_checked((k + 1) * stride) else { return };
        let Some(pivots) = above.get_mut(k * stride..k * stride + n) else { return };
        let Some((pivot, beyond)) = pivots.get_mut(k..).and_then(<[T]>::split_first_mut) else { return };
        if pivot.abs() < least {
            *pivot = if *pivot < T::ZERO { -least } else { least };
        }
        let inverse = T::one() / *pivot;
        for row in below.chunks_mut(stride.max(1)).take(n - k - 1) {
            let Some((first, rest)) = row.get_mut(k..n).and_then(<[T]>::split_first_mut) else { return };
            let part = *first * inverse;
            *first = part;
            if part != T::ZERO {
                for (value, &upper) in rest.iter_mut().zip(&*beyond) {
                    *value -= part * upper;
                }
            }
        }
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
        let Some(row) = a.get(i * stride..i * stride + i) else { return };
        let taken = row.iter().zip(&*x).fold(T::ZERO, |sum, (&l, &y)| sum + l * y);
        let value = x.at(i) - taken;
        x.put(i, value);
    }
    for i in (0..n).rev() {
        let Some((pivot, row)) = a.get(i * stride + i..i * stride + n).and_then(<[T]>::split_first) else { return };
        let above = x.get(i + 1..).unwrap_or(&[]);
        let taken = row.iter().zip(above).fold(T::ZERO, |sum, (&u, &y)| sum + u * y);
        let value = (x.at(i) - taken) / *pivot;
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
