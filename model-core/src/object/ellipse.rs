//! An ellipse, by its true distance.

use super::{Displacement, Gap, Object};
use crate::real::{Real, Vec2, norm, vec2};
use crate::size::Blank;

/// Bound on the iterations for the nearest point; tests meet at most 12.
const ITERATIONS: usize = 16;

/// An elliptic cylinder seen along its axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipse<T: Real> {
    /// Centre, mm.
    centre: Vec2<T>,
    /// Unit vector along the longer semi-axis.
    axis: Vec2<T>,
    /// Semi-axes a ≥ b, mm.
    long: T,
    short: T,
}

impl<T: Real> Ellipse<T> {
    /// An ellipse of a centre (mm), two semi-axes (mm) and the angle (rad, counter-clockwise) of the first one from x.
    pub fn new(centre: [f64; 2], semi_axes: [f64; 2], angle: f64) -> Self {
        let (sin, cos) = libm::sincos(angle);
        let [first, second] = semi_axes;
        let (axis, long, short) =
            if first >= second { ([cos, sin], first, second) } else { ([-sin, cos], second, first) };
        Self { centre: vec2(centre), axis: vec2(axis), long: T::of(long), short: T::of(short) }
    }

    /// The nearest point of the outline to a point, both in the quadrant u, v ≥ 0 of the axes.
    ///
    /// It is (a²u/(t + a²), b²v/(t + b²)) with the largest t at which that lies on the outline (Eberly, *Distance from a
    /// Point to an Ellipse*). With s = t + b² > 0, f(s) = (au/(s + a² − b²))² + (bv/s)² falls from the first bound below
    /// to 1; 1/√f is concave and nearly straight (as in trust-region methods: Moré & Sorensen 1983), so that Newton's
    /// method climbs to 1/√f = 1 from below without ever passing it.
    pub(super) fn foot(&self, u: T, v: T) -> (T, T, usize) {
        let (a, b) = (self.long, self.short);
        let (au, bv) = (a * u, b * v);
        let spread = (a - b) * (a + b);
        let mut s = bv.max(au - spread);
        let mut passes = 0;
        if s <= T::ZERO {
            // On the long axis between the outline's centres of curvature: the foot lies beside, not ahead.
            let x = if spread > T::ZERO { a * (au / spread) } else { T::ZERO };
            let part = (x / a).min(T::one());
            return (x, b * (T::one() - part * part).max(T::ZERO).sqrt(), passes);
        }
        let (mut p, mut q) = (au / (s + spread), bv / s);
        for _ in 0..ITERATIONS {
            let f = p * p + q * q;
            let slope = p * p / (s + spread) + q * q / s;
            let next = s + (f.sqrt() - T::one()) * f / slope;
            passes += 1;
            // Rounding ends the climb.
            if next <= s || !next.is_finite() {
                break;
            }
            s = next;
            (p, q) = (au / (s + spread), bv / s);
        }
        // What rounding left: the foot lies on the outline.
        let scale = T::one() / (p * p + q * q).sqrt();
        (a * (p * scale), b * (q * scale), passes)
    }
}

impl<T: Real> Object<T> for Ellipse<T> {
    fn displaced(&self, by: &Displacement<T>) -> Self {
        Self { centre: by.point(self.centre), axis: by.vector(self.axis), ..*self }
    }

    #[inline(never)]
    fn gap(&self, point: Vec2<T>) -> Gap<T> {
        let offset = point - self.centre;
        let u = offset.x * self.axis.x + offset.y * self.axis.y;
        let v = offset.y * self.axis.x - offset.x * self.axis.y;
        let (x, y, _) = self.foot(u.abs(), v.abs());
        // Gradient of (x/a)² + (y/b)², halved and times ab.
        let gradient = Vec2::new(x * (self.short / self.long), y * (self.long / self.short));
        let length = norm(gradient);
        let (nu, nv) = (gradient.x / length, gradient.y / length);
        let distance = nu * (u.abs() - x) + nv * (v.abs() - y);
        // Curvature of the outline ab/(b²x²/a² + a²y²/b²)^{3/2}, and of the level line at that distance.
        let curvature = self.long * self.short / (length * length * length);
        let growth = T::one() + curvature * distance;
        // Beyond the outline's centre of curvature there is no level line to speak of.
        let curvature = if growth > T::of(1e-3) { curvature / growth } else { T::ZERO };
        let (nu, nv) = (if u < T::ZERO { -nu } else { nu }, if v < T::ZERO { -nv } else { nv });
        let normal = Vec2::new(nu * self.axis.x - nv * self.axis.y, nu * self.axis.y + nv * self.axis.x);
        Gap { distance, normal, curvature }
    }

    fn sharpest(&self) -> T {
        self.short * (self.short / self.long)
    }

    #[inline]
    fn clears(&self, point: Vec2<T>, least: T) -> bool {
        let offset = point - self.centre;
        let u = offset.x * self.axis.x + offset.y * self.axis.y;
        let v = offset.y * self.axis.x - offset.x * self.axis.y;
        // Beside the box around it.
        u.abs() > (self.long + least) * T::of(1.001) || v.abs() > (self.short + least) * T::of(1.001)
    }
}

impl<T: Real> Blank for Ellipse<T> {
    const BLANK: Self =
        Self { centre: Vec2::new(T::ZERO, T::ZERO), axis: Vec2::new(T::ZERO, T::ZERO), long: T::ZERO, short: T::ZERO };
}
