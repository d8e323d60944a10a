//! Cholesky's factorisation of a small symmetric matrix.

/// Cholesky's factor L of the leading n×n block of A + shift·I; the row at which that block is first not positive definite
/// otherwise. Only the lower triangle of A is read.
pub(crate) fn cholesky<const N: usize>(a: &[[f64; N]; N], n: usize, shift: f64) -> Result<[[f64; N]; N], usize> {
    let mut l = [[0.0; N]; N];
    for i in 0..n.min(N) {
        for j in 0..=i {
            let mut value = a[i][j] + if i == j { shift } else { 0.0 };
            for k in 0..j {
                value -= l[i][k] * l[j][k];
            }
            if i > j {
                l[i][j] = value / l[j][j];
            } else if value > 0.0 {
                l[i][i] = libm::sqrt(value);
            } else {
                return Err(i);
            }
        }
    }
    Ok(l)
}
