//! Shapes to grasp: signed distance, normal and curvature at a point, and the motion between finger and object.

use crate::real::{Real, Vec2, norm, vec2};

/// Where a point lies relative to an object's surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap<T: Real> {
    /// Signed distance to the surface, mm; negative inside.
    pub distance: T,
    /// Outward unit normal: the direction in which the distance grows.
    pub normal: Vec2<T>,
    /// Curvature of the level line through the point, 1/mm; positive for convex objects.
    pub curvature: T,
}

/// A rigid object in the plane. The solver knows objects through this trait only.
pub trait Object<T: Real>: Copy {
    /// The same object after a rigid displacement.
    fn displaced(&self, by: &Displacement<T>) -> Self;
    /// Signed distance, normal and curvature at a point, in the frame the object is described in.
    fn gap(&self, point: Vec2<T>) -> Gap<T>;
}

/// A circular cylinder seen along its axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circle<T: Real> {
    /// Centre C, mm.
    pub centre: Vec2<T>,
    /// Radius R, mm.
    pub radius: T,
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
}

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

    /// Image of a free vector.
    #[inline]
    pub fn vector(&self, v: Vec2<T>) -> Vec2<T> {
        let (c, s) = (self.rotation.x, self.rotation.y);
        Vec2::new(c * v.x - s * v.y, s * v.x + c * v.y)
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

/// What a person says about an object: the description that files and messages carry.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub enum ObjectDesign {
    /// A circular cylinder.
    Circle {
        /// Centre in the world frame, mm.
        centre: [f64; 2],
        /// Radius, mm.
        radius: f64,
    },
}

/// Why an [`ObjectDesign`] is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ObjectError {
    /// A number is outside its range, infinite or NaN.
    OutOfRange {
        /// Key in a case file, below `[object]`.
        key: &'static str,
        /// The number, mm.
        value: f64,
        /// Smallest allowed, mm.
        min: f64,
        /// Largest allowed, mm.
        max: f64,
    },
}

impl core::fmt::Display for ObjectError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self::OutOfRange { key, value, min, max } = self;
        write!(f, "{key} is {value}; allowed is {min} to {max}")
    }
}

impl core::error::Error for ObjectError {}

impl ObjectDesign {
    /// Checks the numbers.
    ///
    /// # Errors
    /// The first number out of its range.
    pub fn validate(&self) -> Result<(), ObjectError> {
        let Self::Circle { centre, radius } = *self;
        let check = |key, value: f64, min, max| {
            if (min..=max).contains(&value) { Ok(()) } else { Err(ObjectError::OutOfRange { key, value, min, max }) }
        };
        check("radius_mm", radius, 0.1, 1000.0)?;
        check("centre_mm", centre[0], -2000.0, 2000.0)?;
        check("centre_mm", centre[1], -2000.0, 2000.0)
    }

    /// The object in the solver's precision, world frame.
    pub fn circle<T: Real>(&self) -> Circle<T> {
        let Self::Circle { centre, radius } = *self;
        Circle { centre: vec2(centre), radius: T::of(radius) }
    }
}
