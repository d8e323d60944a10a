//! A bore: a cylinder from inside.

use super::{Displacement, Gap, Object};
use crate::real::{Real, Vec2, norm, vec2};
use crate::size::Blank;

/// A cylindrical hole seen along its axis: the finger is in it and touches its wall.
///
/// Kept as the wall's point nearest to the world's origin and the wall's curvature: at a radius of kilometres the distance to a far
/// centre has no digits left in single precision, the distance to a near wall has them all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bore<T: Real> {
    /// A point of the wall, mm.
    wall: Vec2<T>,
    /// Unit normal there, out of the object: towards the centre.
    inwards: Vec2<T>,
    /// Inverse radius, 1/mm.
    curvature: T,
}

impl<T: Real> Bore<T> {
    /// A bore of a centre and a radius, mm.
    pub fn new(centre: [f64; 2], radius: f64) -> Self {
        let off = libm::hypot(centre[0], centre[1]);
        // About its own axis every point of the wall is as near.
        let [x, y] = if off > 0.0 { [centre[0] / off, centre[1] / off] } else { [-1.0, 0.0] };
        let wall = [x * (off - radius), y * (off - radius)];
        Self { wall: vec2(wall), inwards: vec2([x, y]), curvature: T::of(1.0 / radius) }
    }
}

impl<T: Real> Object<T> for Bore<T> {
    fn displaced(&self, by: &Displacement<T>) -> Self {
        Self { wall: by.point(self.wall), inwards: by.vector(self.inwards), ..*self }
    }

    #[inline]
    fn gap(&self, point: Vec2<T>) -> Gap<T> {
        let (one, k) = (T::one(), self.curvature);
        let offset = point - self.wall;
        // From the centre, in radii: v = κ (p − w) − n, whose length falls from 1 at the wall to 0.
        let from_centre = offset * k - self.inwards;
        let length = norm(from_centre);
        if length <= T::EPSILON {
            // At the centre itself every direction is a normal.
            return Gap { distance: one / k, normal: self.inwards, curvature: T::ZERO };
        }
        // R − |p − C| = R (1 − |v|) = R (1 − |v|²)/(1 + |v|), without the difference of two large numbers.
        let ahead = offset.x * self.inwards.x + offset.y * self.inwards.y;
        let square = offset.x * offset.x + offset.y * offset.y;
        let distance = (ahead + ahead - k * square) / (one + length);
        Gap { distance, normal: from_centre * (-one / length), curvature: -k / length }
    }

    fn sharpest(&self) -> T {
        // Nowhere convex.
        T::of(1e9)
    }

    #[inline]
    fn clears(&self, point: Vec2<T>, least: T) -> bool {
        // Within the circle about the centre that lies so far inside of the wall.
        let from_centre = (point - self.wall) * self.curvature - self.inwards;
        let room = T::one() - least * self.curvature * T::of(1.001);
        let square = from_centre.x * from_centre.x + from_centre.y * from_centre.y;
        room > T::ZERO && square < room * room * T::of(0.999)
    }
}

impl<T: Real> Blank for Bore<T> {
    const BLANK: Self =
        Self { wall: Vec2::new(T::ZERO, T::ZERO), inwards: Vec2::new(T::ZERO, T::ZERO), curvature: T::ZERO };
}
