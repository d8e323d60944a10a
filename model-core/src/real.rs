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
    /// Turns things by angles (rad), each with something beside it, sine and cosine: those of [`Self::sin_cos`], several at a time
    /// where that is faster.
    #[inline]
    fn turn_each<X, Y>(angles: &[Self], things: &mut [X], beside: &[Y], turn: impl Fn(&mut X, &Y, Self, Self)) {
        for ((&angle, thing), beside) in angles.iter().zip(things).zip(beside) {
            let (sin, cos) = angle.sin_cos();
            turn(thing, beside, sin, cos);
        }
    }
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

/// Residuals at which an equilibrium counts as converged, in the finger's units ([`crate::units`]): those below for a finger of 80 mm in
/// a soft plastic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance<T> {
    /// Largest component of the energy's gradient, N·mm.
    pub gradient: T,
    /// Largest closure error, gap error and penetration, mm.
    pub length: T,
}

impl<T: Real> Tolerance<T> {
    /// So many times these residuals.
    pub(crate) fn times(self, times: T) -> Self {
        Self { gradient: times * self.gradient, length: times * self.length }
    }
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
        sin_cos_f64(self)
    }
    #[inline]
    fn turn_each<X, Y>(angles: &[Self], things: &mut [X], beside: &[Y], turn: impl Fn(&mut X, &Y, Self, Self)) {
        let ((angles, angles_left), (beside, beside_left)) = (angles.as_chunks::<4>(), beside.as_chunks::<4>());
        let (things, things_left) = things.as_chunks_mut::<4>();
        for ((angles, things), beside) in angles.iter().zip(&mut *things).zip(beside) {
            let (sin, cos) = if angles.iter().all(|&angle| is_near_zero(angle)) {
                near_zero_f64(angles)
            } else {
                let both = angles.map(sin_cos_f64);
                (both.map(|(sin, _)| sin), both.map(|(_, cos)| cos))
            };
            for i in 0..4 {
                turn(&mut things[i], &beside[i], sin[i], cos[i]);
            }
        }
        for ((&angle, thing), beside) in angles_left.iter().zip(things_left).zip(beside_left) {
            let (sin, cos) = sin_cos_f64(angle);
            turn(thing, beside, sin, cos);
        }
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

/// True where the polynomials of [`near_zero_f64`] apply.
#[inline(always)]
fn is_near_zero(angle: f64) -> bool {
    angle.abs() <= core::f64::consts::FRAC_PI_4
}

/// Sine and cosine within one unit in the last place: polynomials for |angle| ≤ π/4, beyond it `libm`.
#[inline]
fn sin_cos_f64(angle: f64) -> (f64, f64) {
    if is_near_zero(angle) {
        let ([sin], [cos]) = near_zero_f64(&[angle]);
        return (sin, cos);
    }
    libm::sincos(angle)
}

/// Sines and cosines of angles of at most π/4, side by side: minimax polynomials (fitted for this file), errors 4e-18 and 2e-19 before
/// rounding.
#[inline(always)]
fn near_zero_f64<const N: usize>(angles: &[f64; N]) -> ([f64; N], [f64; N]) {
    const SIN: [f64; 6] = [
        -1.666_666_666_666_664e-1,
        8.333_333_333_323_624e-3,
        -1.984_126_983_010_882_6e-4,
        2.755_731_363_850_452e-6,
        -2.505_073_237_966_471e-8,
        1.589_457_978_246_372e-10,
    ];
    const COS: [f64; 6] = [
        4.166_666_666_666_650_5e-2,
        -1.388_888_888_888_281_6e-3,
        2.480_158_729_460_575e-5,
        -2.755_731_573_026_136_3e-7,
        2.087_589_636_756_933_6e-9,
        -1.136_790_004_194_104_9e-11,
    ];
    let z = angles.map(|r| r * r);
    let horner = |c: [f64; 6]| z.map(|z| c[0] + z * (c[1] + z * (c[2] + z * (c[3] + z * (c[4] + z * c[5])))));
    let (p, q) = (horner(SIN), horner(COS));
    let sin = core::array::from_fn(|i| angles[i] + angles[i] * (z[i] * p[i]));
    let cos = core::array::from_fn(|i| 1.0 - (0.5 * z[i] - z[i] * (z[i] * q[i])));
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
    fn double_precision_sine_and_cosine_are_those_of_libm() {
        let mut worst = 0.0_f64;
        let angles: std::vec::Vec<f64> = (-400_001..=400_000).map(|i| f64::from(i) * 1e-5).collect();
        let mut found = std::vec![(0.0, 0.0); angles.len()];
        f64::turn_each(&angles, &mut found, &angles, |into, _, sin, cos| *into = (sin, cos));
        for (&angle, &(sin, cos)) in angles.iter().zip(&found) {
            assert_eq!((sin, cos), Real::sin_cos(angle), "one by one and side by side");
            let (s, c) = libm::sincos(angle);
            worst = worst.max((sin - s).abs() / s.abs().max(f64::MIN_POSITIVE)).max((cos - c).abs() / c.abs());
        }
        assert!(worst <= 2.0 * f64::EPSILON, "worst error {worst:e}");
        assert!(Real::sin_cos(f64::NAN).0.is_nan());
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
