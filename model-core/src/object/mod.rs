//! Shapes to grasp: signed distance, normal and curvature at a point, and the motion between finger and object.
//!
//! The solver knows an object through the trait [`Object`] only. The built-in shapes are one type, [`Shape`], made from
//! the description that files and messages carry, [`ObjectDesign`].

mod bore;
mod circle;
mod design;
mod ellipse;
mod half_plane;
mod motion;
mod outline;
mod placement;
mod polygon;
#[cfg(test)]
mod tests;

pub use bore::Bore;
pub use circle::Circle;
pub use design::{BORES, Corners, MAX_CORNERS, ObjectDesign, ObjectError, PLACES, RADII};
pub use ellipse::Ellipse;
pub use half_plane::HalfPlane;
pub use motion::{Displacement, Motion};
pub use outline::Piece;
pub use placement::Placement;
pub use polygon::Polygon;

use crate::real::{Real, Vec2};
use crate::size::Blank;

/// Where a point lies relative to an object's surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap<T: Real> {
    /// Signed distance to the surface, mm; negative inside.
    pub distance: T,
    /// Outward unit normal: the direction in which the distance grows.
    pub normal: Vec2<T>,
    /// Curvature of the level line of the distance through the point, 1/mm; positive for convex objects, 0 beside a flat
    /// face, negative in a bore. It is what turns the normal when the point moves along the line.
    pub curvature: T,
}

/// A rigid object in the plane. The solver knows objects through this trait only.
///
/// The distance must be continuous, and smooth enough for the normal to be continuous outside of the object and a little
/// way (some µm, the contact's softness) into it. A blank object is never solved for: it holds a place in a static.
pub trait Object<T: Real>: Blank {
    /// The same object after a rigid displacement.
    fn displaced(&self, by: &Displacement<T>) -> Self;
    /// Signed distance, normal and curvature at a point, in the frame the object is described in.
    fn gap(&self, point: Vec2<T>) -> Gap<T>;

    /// True only if the distance at a point is certainly larger than `least` (≥ 0, mm): a cheap test that spares most samples of
    /// a finger in contact the whole one. Never true unless a shape knows better.
    #[inline]
    fn clears(&self, _point: Vec2<T>, _least: T) -> bool {
        false
    }

    /// Smallest radius of curvature of the convex parts of the outline, mm. Where it is large, the finger need not look for contacts
    /// between its samples, and may take larger steps. Without an answer the outline may have any corner.
    fn sharpest(&self) -> T {
        T::of(design::SHARPEST)
    }
}

/// The built-in shapes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape<T: Real> {
    /// A circle. First, so that a blank shape is all zeros.
    Circle(Circle<T>),
    /// An ellipse.
    Ellipse(Ellipse<T>),
    /// A rounded convex polygon.
    Polygon(Polygon<T>),
    /// A half-plane.
    HalfPlane(HalfPlane<T>),
    /// A bore.
    Bore(Bore<T>),
}

impl<T: Real> Blank for Shape<T> {
    const BLANK: Self = Self::Circle(Circle::BLANK);
}

impl<T: Real> Object<T> for Shape<T> {
    fn displaced(&self, by: &Displacement<T>) -> Self {
        match self {
            Self::Circle(circle) => Self::Circle(circle.displaced(by)),
            Self::Ellipse(ellipse) => Self::Ellipse(ellipse.displaced(by)),
            Self::Polygon(polygon) => Self::Polygon(polygon.displaced(by)),
            Self::HalfPlane(half_plane) => Self::HalfPlane(half_plane.displaced(by)),
            Self::Bore(bore) => Self::Bore(bore.displaced(by)),
        }
    }

    #[inline]
    fn gap(&self, point: Vec2<T>) -> Gap<T> {
        match self {
            Self::Circle(circle) => circle.gap(point),
            Self::Ellipse(ellipse) => ellipse.gap(point),
            Self::Polygon(polygon) => polygon.gap(point),
            Self::HalfPlane(half_plane) => half_plane.gap(point),
            Self::Bore(bore) => bore.gap(point),
        }
    }

    fn sharpest(&self) -> T {
        match self {
            Self::Circle(circle) => circle.sharpest(),
            Self::Ellipse(ellipse) => ellipse.sharpest(),
            Self::Polygon(polygon) => polygon.sharpest(),
            Self::HalfPlane(half_plane) => half_plane.sharpest(),
            Self::Bore(bore) => bore.sharpest(),
        }
    }

    #[inline]
    fn clears(&self, point: Vec2<T>, least: T) -> bool {
        match self {
            Self::Circle(circle) => circle.clears(point, least),
            Self::Ellipse(ellipse) => ellipse.clears(point, least),
            Self::Polygon(polygon) => polygon.clears(point, least),
            Self::HalfPlane(half_plane) => half_plane.clears(point, least),
            Self::Bore(bore) => bore.clears(point, least),
        }
    }
}

impl<T: Real> From<ObjectDesign> for Shape<T> {
    fn from(design: ObjectDesign) -> Self {
        match design {
            ObjectDesign::Circle { centre, radius } => Self::Circle(Circle::new(centre, radius)),
            ObjectDesign::Ellipse { centre, semi_axes, angle } => Self::Ellipse(Ellipse::new(centre, semi_axes, angle)),
            ObjectDesign::Polygon { corners, rounding } => Self::Polygon(Polygon::new(&corners, rounding)),
            ObjectDesign::HalfPlane { point, normal } => Self::HalfPlane(HalfPlane::new(point, normal)),
            ObjectDesign::Bore { centre, radius } => Self::Bore(Bore::new(centre, radius)),
        }
    }
}
