//! The two floating-point types the model runs in.
//!
//! Every elementary function comes from `libm` or from a polynomial written here, never from the platform, so that a
//! result depends on the precision only: `f32` on the microcontroller equals `f32` on the PC bit for bit.

use core::fmt::Debug;
use nalgebra::{ClosedAddAssign, ClosedDivAssign, ClosedMulAssign, ClosedSubAssign, Scalar, Vector2};
use num_traits::{NumAssign, One, Zero};

use crate::size::Blank;

/// A point or a vector in the plane.
pub type Vec2<T> = Vector2<T>;

/// A floating-point number: `f32` or `f64`.
pub trait Real:
    Blank
    + Scalar
    + Copy
    + Default
    + Debug
    + PartialOrd
    + Zero
    + One
    + NumAssign
    + core::ops::Neg<Output = Self>
    + ClosedAddAssign
    + ClosedSubAssign
    + ClosedMulAssign
    + ClosedDivAssign
{
    /// Zero, for constants.
    const ZERO: Self;
    /// Distance from 1 to the next larger number.
    const EPSILON: Self;
    /// Residuals at which an equilibrium counts as converged in this precision.
    const TOLERANCE: Tolerance<Self>;
    /// The nearest number of this precision.
    fn of(value: f64) -> Self;
    /// The same number in double precision.
    fn to_f64(self) -> f64;
    /// Magnitude.
    fn abs(self) -> Self;
    /// Square root, within one unit in the last place; in single precision zero below 1e-30; not a number of a negative one.
    fn sqrt(self) -> Self;
    /// Sine and cosine of an angle in rad.
    fn sin_cos(self) -> (Self, Self);
    /// True for numbers that are neither infinite nor NaN.
    fn is_finite(self) -> bool;
    /// The larger of two numbers.
    #[inline]
    fn max(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
    /// The smaller of two numbers.
    #[inline]
    fn min(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
}

/// Residuals at which an equilibrium counts as converged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance<T> {
    /// Largest component of the energy's gradient, N·mm.
    pub gradient: T,
    /// Largest closure error, gap error and penetration, mm.
    pub length: T,
}

impl Real for f64 {
    const ZERO: Self = 0.0;
    const EPSILON: Self = f64::EPSILON;
    const TOLERANCE: Tolerance<f64> = Tolerance { gradient: 1e-9, length: 1e-10 };
    #[inline]
    fn of(value: f64) -> Self {
        value
    }
    #[inline]
    fn to_f64(self) -> f64 {
        self
    }
    #[inline]
    fn abs(self) -> Self {
        f64::abs(self)
    }
    #[inline]
    fn sqrt(self) -> Self {
        libm::sqrt(self)
    }
    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        libm::sincos(self)
    }
    #[inline]
    fn is_finite(self) -> bool {
        f64::is_finite(self)
    }
}

impl Real for f32 {
    const ZERO: Self = 0.0;
    const EPSILON: Self = f32::EPSILON;
    const TOLERANCE: Tolerance<f32> = Tolerance { gradient: 1e-3, length: 1e-4 };
    #[inline]
    fn of(value: f64) -> Self {
        value as f32
    }
    #[inline]
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
    #[inline]
    fn abs(self) -> Self {
        f32::abs(self)
    }
    #[inline]
    fn sqrt(self) -> Self {
        sqrt_f32(self)
    }
    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        sin_cos_f32(self)
    }
    #[inline]
    fn is_finite(self) -> bool {
        f32::is_finite(self)
    }
}

/// Square root within one unit in the last place: three of Newton's steps for 1/√x from a guess out of the exponent, and one
/// for √x. `libm::sqrtf` goes bit by bit, at four times the cost.
#[inline]
fn sqrt_f32(x: f32) -> f32 {
    // A squared length below that is none; and half of it must not leave the normal numbers.
    const LEAST: f32 = 1e-30;
    if x.is_nan() || x <= LEAST {
        return if x >= 0.0 { 0.0 } else { f32::NAN };
    }
    let half = 0.5 * x;
    let mut y = f32::from_bits(0x5f37_59df - (x.to_bits() >> 1));
    y *= 1.5 - half * y * y;
    y *= 1.5 - half * y * y;
    y *= 1.5 - half * y * y;
    let root = x * y;
    root + 0.5 * y * (x - root * root)
}

/// Sine and cosine within 1e-7 of the true values for |angle| ≤ 50 rad, in single precision throughout: `libm::sinf`
/// computes in `f64`, which costs 50 times as much on a single-precision FPU.
///
/// The angle is reduced by multiples of π/2 (π/2 split in three parts) to |r| ≤ π/4, where minimax polynomials of
/// degree 7 and 8 (fitted for this file) apply.
#[inline]
fn sin_cos_f32(angle: f32) -> (f32, f32) {
    const TWO_OVER_PI: f32 = core::f32::consts::FRAC_2_PI;
    // The first two parts of π/2 have trailing zero bits, so that their products with small integers are exact.
    const HALF_PI: [f32; 3] = [1.570_312_5, 4.837_513e-4, 7.549_79e-8];
    if angle.abs() <= core::f32::consts::FRAC_PI_4 {
        return near_zero(angle);
    }
    let scaled = angle * TWO_OVER_PI;
    // Truncation saturates on huge angles and maps NaN to 0: no branch can panic.
    let quadrant = (if scaled >= 0.0 { scaled + 0.5 } else { scaled - 0.5 }) as i32;
    let turns = quadrant as f32;
    let r = ((angle - turns * HALF_PI[0]) - turns * HALF_PI[1]) - turns * HALF_PI[2];
    let (sin, cos) = near_zero(r);
    match quadrant & 3 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// Sine and cosine of an angle of at most π/4.
#[inline]
fn near_zero(r: f32) -> (f32, f32) {
    let z = r * r;
    let sin = r + r * z * (-0.166_666_54 + z * (0.008_332_083 + z * -0.000_195_043_18));
    let cos = 1.0 - 0.5 * z + z * z * (0.041_666_646 + z * (-0.001_388_724_3 + z * 2.442_388_9e-5));
    (sin, cos)
}

/// z component of the cross product a × b.
#[inline]
pub(crate) fn cross<T: Real>(a: Vec2<T>, b: Vec2<T>) -> T {
    a.x * b.y - a.y * b.x
}

/// A plane vector in this precision from one in double precision.
#[inline]
pub(crate) fn vec2<T: Real>(v: [f64; 2]) -> Vec2<T> {
    Vec2::new(T::of(v[0]), T::of(v[1]))
}

/// Length of a plane vector.
#[inline]
pub(crate) fn norm<T: Real>(v: Vec2<T>) -> T {
    (v.x * v.x + v.y * v.y).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_precision_sine_and_cosine_are_within_1e_7() {
        let mut worst = 0.0_f64;
        for i in -500_000..=500_000 {
            let angle = i as f32 * 1e-4;
            let (s, c) = Real::sin_cos(angle);
            worst = worst.max((f64::from(s) - libm::sin(f64::from(angle))).abs());
            worst = worst.max((f64::from(c) - libm::cos(f64::from(angle))).abs());
        }
        assert!(worst < 1e-7, "worst error {worst:e}");
    }

    #[test]
    fn single_precision_square_roots_are_within_one_unit_in_the_last_place() {
        for i in 0..2_000_000_u32 {
            let x = f32::from_bits(1e-30_f32.to_bits() + 1 + i * 640);
            let (root, exact) = (Real::sqrt(x), libm::sqrt(f64::from(x)));
            assert!((f64::from(root) - exact).abs() <= exact * f64::from(f32::EPSILON), "{x:e}: {root:e}");
        }
        assert_eq!(Real::sqrt(0.0_f32), 0.0);
        assert!(Real::sqrt(-1.0_f32).is_nan() && Real::sqrt(f32::NAN).is_nan());
    }

    #[test]
    fn sine_of_nonsense_does_not_panic() {
        for angle in [f32::NAN, f32::INFINITY, f32::MIN, f32::MAX, 1e20] {
            let _ = Real::sin_cos(angle);
        }
    }
}
