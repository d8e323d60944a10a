//! A circle: a cylinder seen along its axis.

use super::{Displacement, Gap, Object};
use crate::real::{Real, Vec2, norm, vec2};
use crate::size::Blank;

/// A circular cylinder seen along its axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circle<T: Real> {
    /// Centre C, mm.
    pub centre: Vec2<T>,
    /// Radius R, mm.
    pub radius: T,
}

impl<T: Real> Circle<T> {
    /// A circle of a centre and a radius, mm.
    pub fn new(centre: [f64; 2], radius: f64) -> Self {
        Self { centre: vec2(centre), radius: T::of(radius) }
    }
}

impl<T: Real> Object<T> for Circle<T> {
    fn displaced(&self, by: &Displacement<T>) -> Self {
        Self { centre: by.point(self.centre), radius: self.radius }
    }

    #[inline]
    fn gap(&self, point: Vec2<T>) -> Gap<T> {
        let offset = point - self.centre;
        let distance = norm(offset);
        // At the centre itself every direction is a normal; pushing back along −x is as good as any.
        if distance <= T::EPSILON {
            return Gap { distance: -self.radius, normal: Vec2::new(-T::one(), T::ZERO), curvature: T::ZERO };
        }
        let inverse = T::one() / distance;
        Gap { distance: distance - self.radius, normal: offset * inverse, curvature: inverse }
    }

    fn sharpest(&self) -> T {
        self.radius
    }

    #[inline]
    fn clears(&self, point: Vec2<T>, least: T) -> bool {
        let (offset, reach) = (point - self.centre, self.radius + least);
        // A thousandth more than rounding takes.
        offset.x * offset.x + offset.y * offset.y > reach * reach * T::of(1.001)
    }
}

impl<T: Real> Blank for Circle<T> {
    const BLANK: Self = Self { centre: Vec2::new(T::ZERO, T::ZERO), radius: T::ZERO };
}
