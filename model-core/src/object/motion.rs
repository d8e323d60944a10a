//! Rigid displacements, and the motion between finger and world.

use crate::real::{Real, Vec2, vec2};

/// A rigid displacement of the plane: p ↦ R p + t.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Displacement<T: Real> {
    /// Cosine and sine of the rotation angle (counter-clockwise positive).
    pub rotation: Vec2<T>,
    /// Translation applied after the rotation, mm.
    pub translation: Vec2<T>,
}

impl<T: Real> Displacement<T> {
    /// Image of a point.
    #[inline]
    pub fn point(&self, p: Vec2<T>) -> Vec2<T> {
        self.vector(p) + self.translation
    }

    /// By how much a point moves: precise where that is little, as the image is not.
    #[inline]
    pub(crate) fn moves(&self, p: Vec2<T>) -> Vec2<T> {
        self.turns(p) + self.translation
    }

    /// The same with its rotation about a point, not the origin.
    pub(crate) fn about(self, pivot: Vec2<T>) -> Self {
        Self { translation: self.translation - self.turns(pivot), ..self }
    }

    /// (R − 1) v.
    #[inline]
    fn turns(&self, v: Vec2<T>) -> Vec2<T> {
        let (back, s) = (self.back(), self.rotation.y);
        Vec2::new(-(back * v.x + s * v.y), s * v.x - back * v.y)
    }

    /// 1 − cos α, precise where that is little.
    #[inline]
    pub(crate) fn back(&self) -> T {
        let (c, s) = (self.rotation.x, self.rotation.y);
        if c > T::ZERO { s * s / (T::one() + c) } else { T::one() - c }
    }

    /// Image of a free vector.
    #[inline]
    pub fn vector(&self, v: Vec2<T>) -> Vec2<T> {
        let (c, s) = (self.rotation.x, self.rotation.y);
        Vec2::new(c * v.x - s * v.y, s * v.x + c * v.y)
    }

    /// Pre-image of a point.
    #[inline]
    pub fn point_back(&self, p: Vec2<T>) -> Vec2<T> {
        self.vector_back(p - self.translation)
    }

    /// Pre-image of a free vector.
    #[inline]
    pub fn vector_back(&self, v: Vec2<T>) -> Vec2<T> {
        let (c, s) = (self.rotation.x, self.rotation.y);
        Vec2::new(c * v.x + s * v.y, c * v.y - s * v.x)
    }
}

/// How the finger's base moves in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub enum Motion {
    /// A motor turns the base about the axis M (mm, world = finger frame at angle 0); positive angles (rad) turn
    /// clockwise, towards +x, and close the finger.
    Rotating {
        /// Motor axis M, mm.
        axis: [f64; 2],
    },
    /// A parallel gripper: the base moves along a unit direction; the coordinate is the distance in mm.
    Translating {
        /// Unit vector of the base's motion in the world.
        direction: [f64; 2],
    },
}

impl Motion {
    /// The displacement that takes world coordinates to finger coordinates at a motion coordinate
    /// (angle in rad, or distance in mm).
    pub fn world_to_finger<T: Real>(&self, coordinate: T) -> Displacement<T> {
        match *self {
            Self::Rotating { axis } => {
                let m = vec2::<T>(axis);
                let (s, c) = coordinate.sin_cos();
                let rotated = Vec2::new(c * m.x - s * m.y, s * m.x + c * m.y);
                Displacement { rotation: Vec2::new(c, s), translation: m - rotated }
            }
            Self::Translating { direction } => Displacement {
                rotation: Vec2::new(T::one(), T::ZERO),
                translation: -(vec2::<T>(direction) * coordinate),
            },
        }
    }
}
