//! Pivots that nearly vanish are bounded: the perturbation costs the step and not the solution, and the sign is kept for the inertia.

use crate::real::Real;

/// Smallest pivot, relative to the diagonal at rest. Square root of the precision: the perturbation costs the step and
/// the amplified rounding costs it about as many digits.
pub(crate) fn pivot_bound<T: Real>() -> T {
    T::of(4.0) * T::EPSILON.sqrt()
}

/// Pivot kept at least `least` away from zero, on its own side; true if it is negative.
#[inline]
pub(crate) fn bounded<T: Real>(pivot: T, least: T) -> (T, bool) {
    if pivot < T::ZERO { (pivot.min(-least), true) } else { (pivot.max(least), false) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bounded_pivot_keeps_its_side_and_what_is_large_enough() {
        assert_eq!(bounded(2.0, 0.5), (2.0, false));
        assert_eq!(bounded(-2.0, 0.5), (-2.0, true));
        assert_eq!(bounded(0.1, 0.5), (0.5, false));
        assert_eq!(bounded(-0.1, 0.5), (-0.5, true));
        assert_eq!(bounded(0.0, 0.5), (0.5, false));
    }
}
