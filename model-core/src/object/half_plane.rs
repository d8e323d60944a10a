//! A half-plane: a wall or a floor.

use super::{Displacement, Gap, Object};
use crate::real::{Real, Vec2, vec2};
use crate::size::Blank;

/// All points on one side of a straight line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfPlane<T: Real> {
    /// A point of the surface, mm.
    pub point: Vec2<T>,
    /// Unit normal out of the object.
    pub normal: Vec2<T>,
}

impl<T: Real> HalfPlane<T> {
    /// A half-plane through a point (mm) with an outward normal of any length but zero.
    pub fn new(point: [f64; 2], normal: [f64; 2]) -> Self {
        let length = libm::hypot(normal[0], normal[1]);
        Self { point: vec2(point), normal: vec2([normal[0] / length, normal[1] / length]) }
    }
}

impl<T: Real> Object<T> for HalfPlane<T> {
    fn displaced(&self, by: &Displacement<T>) -> Self {
        Self { point: by.point(self.point), normal: by.vector(self.normal) }
    }

    #[inline]
    fn gap(&self, point: Vec2<T>) -> Gap<T> {
        let offset = point - self.point;
        let distance = offset.x * self.normal.x + offset.y * self.normal.y;
        Gap { distance, normal: self.normal, curvature: T::ZERO }
    }

    fn sharpest(&self) -> T {
        T::of(1e9)
    }
}

impl<T: Real> Blank for HalfPlane<T> {
    const BLANK: Self = Self { point: Vec2::new(T::ZERO, T::ZERO), normal: Vec2::new(T::ZERO, T::ZERO) };
}
