//! Cholesky's factorisation of a small symmetric matrix.

use crate::access::Access;

/// Cholesky's factor L of the leading n×n block of A + shift·I; the row at which that block is first not positive definite
/// otherwise. Only the lower triangle of A is read.
pub(crate) fn cholesky<const N: usize>(a: &[[f64; N]; N], n: usize, shift: f64) -> Result<[[f64; N]; N], usize> {
    let mut l = [[0.0; N]; N];
    for (i, given) in a.iter().enumerate().take(n) {
        // Split instead of indexed: no way to panic, whatever the compiler finds out about the indices.
        let Some((above, [row, ..])) = l.split_at_mut_checked(i) else { break };
        for (j, other) in above.iter().enumerate() {
            let taken = row.iter().zip(other).take(j);
            let value = taken.fold(given.at(j), |value, (x, y)| value - x * y);
            row.put(j, value / other.at(j));
        }
        let value = row.iter().take(i).fold(given.at(i) + shift, |value, x| value - x * x);
        if value > 0.0 {
            row.put(i, libm::sqrt(value));
        } else {
            return Err(i);
        }
    }
    Ok(l)
}

#[cfg(test)]
mod tests {
    use super::cholesky;

    #[test]
    fn a_factor_times_itself_is_the_matrix_and_the_first_row_at_fault_is_named() {
        // The upper triangle is not read.
        let a = [[4.0, 9.0, 9.0], [2.0, 5.0, 9.0], [-2.0, 1.0, 6.0]];
        let l = cholesky(&a, 3, 0.0).expect("positive definite");
        assert_eq!(l, [[2.0, 0.0, 0.0], [1.0, 2.0, 0.0], [-1.0, 1.0, 2.0]]);
        let shifted = cholesky(&a, 2, 5.0).expect("positive definite");
        assert_eq!((shifted[0], shifted[2]), ([3.0, 0.0, 0.0], [0.0; 3]));
        assert_eq!(cholesky(&[[1.0, 0.0], [2.0, 4.0]], 2, 0.0), Err(1));
        assert_eq!(cholesky(&[[f64::NAN]], 1, 0.0), Err(0));
    }
}
