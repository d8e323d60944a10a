//! What a person says about an object, and what is refused.

use core::ops::Deref;

use crate::size::{Lists, TooLong};

/// The most corners of a polygon on this machine.
pub const MAX_CORNERS: usize = Lists::HERE.corners as usize;

/// Smallest radius of curvature of any outline, mm.
pub(super) const SHARPEST: f64 = 0.1;
/// Smallest and largest radius or semi-axis, mm.
pub const RADII: [f64; 2] = [SHARPEST, 1000.0];
/// Smallest and largest coordinate, mm.
pub const PLACES: [f64; 2] = [-2000.0, 2000.0];
/// Smallest and largest radius of a bore, mm.
pub const BORES: [f64; 2] = [SHARPEST, 1e7];
/// Sine of the smallest turn at a corner: less is a corner on a straight edge.
const LEAST_TURN: f64 = 1e-6;

/// A polygon's corners.
#[derive(Clone, Copy)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(from = "CornerList", into = "CornerList"))]
pub struct Corners {
    at: [[f64; 2]; MAX_CORNERS],
    count: usize,
}

/// Corners as files and messages carry them.
type CornerList = heapless::Vec<[f64; 2], MAX_CORNERS>;

impl Corners {
    /// Corners in order, mm; none if there are more than [`MAX_CORNERS`].
    pub fn new(corners: &[[f64; 2]]) -> Option<Self> {
        let mut at = [[0.0; 2]; MAX_CORNERS];
        at.get_mut(..corners.len())?.copy_from_slice(corners);
        Some(Self { at, count: corners.len() })
    }

    /// The same number of corners elsewhere.
    pub fn map(mut self, to: impl Fn([f64; 2]) -> [f64; 2]) -> Self {
        for corner in self.at.iter_mut().take(self.count) {
            *corner = to(*corner);
        }
        self
    }
}

impl Deref for Corners {
    type Target = [[f64; 2]];
    fn deref(&self) -> &Self::Target {
        self.at.get(..self.count).unwrap_or(&self.at)
    }
}

impl core::fmt::Debug for Corners {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        (**self).fmt(f)
    }
}

impl PartialEq for Corners {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl From<CornerList> for Corners {
    fn from(list: CornerList) -> Self {
        let mut at = [[0.0; 2]; MAX_CORNERS];
        for (to, from) in at.iter_mut().zip(&list) {
            *to = *from;
        }
        Self { at, count: list.len() }
    }
}

impl From<Corners> for CornerList {
    fn from(corners: Corners) -> Self {
        corners.iter().copied().collect()
    }
}

#[cfg(feature = "schema")]
impl postcard_schema::Schema for Corners {
    const SCHEMA: &'static postcard_schema::schema::NamedType = <CornerList as postcard_schema::Schema>::SCHEMA;
}

/// What a person says about an object: the description that files and messages carry. World frame, mm and rad.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub enum ObjectDesign {
    /// A circular cylinder.
    Circle {
        /// Centre, mm.
        centre: [f64; 2],
        /// Radius, mm.
        radius: f64,
    },
    /// An elliptic cylinder.
    Ellipse {
        /// Centre, mm.
        centre: [f64; 2],
        /// Semi-axes, mm, in any order.
        semi_axes: [f64; 2],
        /// Angle of the first semi-axis from x, rad, counter-clockwise.
        angle: f64,
    },
    /// A convex prism with rounded edges: all points within `rounding` of a polygon.
    Polygon {
        /// Corners of the polygon (centres of the roundings), mm, in order either way round. Two make a rounded bar.
        corners: Corners,
        /// Radius of the rounding, mm: the outline lies that far outside of the polygon.
        rounding: f64,
    },
    /// A wall or a floor.
    HalfPlane {
        /// A point of the surface, mm.
        point: [f64; 2],
        /// Normal out of the object; its length does not matter.
        normal: [f64; 2],
    },
    /// A cylindrical hole, the finger being in it.
    Bore {
        /// Centre, mm.
        centre: [f64; 2],
        /// Radius, mm.
        radius: f64,
    },
}

/// Why an [`ObjectDesign`] is refused. `key` is the key in a case file, below `[object]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ObjectError {
    /// A number is outside its range, infinite or NaN.
    OutOfRange {
        /// Its key.
        key: &'static str,
        /// The number in the key's unit.
        value: f64,
        /// Smallest allowed.
        min: f64,
        /// Largest allowed.
        max: f64,
    },
    /// The ends of a slender ellipse are sharper than any outline may be.
    TooSharp {
        /// Their radius of curvature b²/a, mm.
        radius: f64,
        /// Smallest allowed, mm.
        min: f64,
    },
    /// A polygon has no corner.
    NoCorner,
    /// A corner is where another one is.
    RepeatedCorner {
        /// Number of the corner, from 0, that is like one before it.
        index: usize,
    },
    /// The outline does not turn the same way at every corner.
    NotConvex {
        /// Number of the corner, from 0, that lies within the others' outline or on its edge.
        index: usize,
    },
    /// A normal without a direction.
    NoDirection {
        /// Its key.
        key: &'static str,
    },
}

impl core::fmt::Display for ObjectError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::OutOfRange { key, value, min, max } => write!(f, "{key} is {value}; allowed is {min} to {max}"),
            Self::TooSharp { radius, min } => write!(
                f,
                "semi_axes_mm end in a radius of curvature of {radius} mm; allowed is {min} mm or more (b²/a)"
            ),
            Self::NoCorner => write!(f, "corners_mm is empty; allowed are 1 to {MAX_CORNERS} corners"),
            Self::RepeatedCorner { index } => {
                write!(f, "corners_mm[{index}] is the same as another corner; each corner is named once")
            }
            Self::NotConvex { index } => {
                write!(
                    f,
                    "corners_mm[{index}] makes the polygon not convex; allowed are corners that all turn the same way, in order"
                )
            }
            Self::NoDirection { key } => {
                write!(f, "{key} has no length to speak of; allowed is a length of 1e-6 to 1e6")
            }
        }
    }
}

impl core::error::Error for ObjectError {}

fn within(key: &'static str, value: f64, [min, max]: [f64; 2]) -> Result<(), ObjectError> {
    if (min..=max).contains(&value) { Ok(()) } else { Err(ObjectError::OutOfRange { key, value, min, max }) }
}

fn place(key: &'static str, point: [f64; 2]) -> Result<(), ObjectError> {
    point.into_iter().try_for_each(|value| within(key, value, PLACES))
}

impl ObjectDesign {
    /// Checks that another machine has room for the object's list.
    ///
    /// # Errors
    /// A polygon of too many corners.
    pub fn fits(&self, room: Lists) -> Result<(), TooLong> {
        match self {
            Self::Polygon { corners, .. } => TooLong::check("corners_mm", corners.len(), room.corners),
            _ => Ok(()),
        }
    }

    /// Checks the numbers.
    ///
    /// # Errors
    /// The first number out of its range, or the first corner at fault.
    pub fn validate(&self) -> Result<(), ObjectError> {
        match *self {
            Self::Circle { centre, radius } => {
                within("radius_mm", radius, RADII)?;
                place("centre_mm", centre)
            }
            Self::Ellipse { centre, semi_axes, angle } => {
                semi_axes.into_iter().try_for_each(|axis| within("semi_axes_mm", axis, RADII))?;
                let [long, short] = [semi_axes[0].max(semi_axes[1]), semi_axes[0].min(semi_axes[1])];
                let radius = short * short / long;
                // Equal axes of the smallest size pass whatever rounding does.
                if radius < SHARPEST * (1.0 - 1e-9) {
                    return Err(ObjectError::TooSharp { radius, min: SHARPEST });
                }
                within("angle_deg", angle.to_degrees(), [-360.0, 360.0])?;
                place("centre_mm", centre)
            }
            Self::Polygon { corners, rounding } => {
                corners.iter().try_for_each(|&corner| place("corners_mm", corner))?;
                within("rounding_mm", rounding, RADII)?;
                convex(&corners)
            }
            Self::HalfPlane { point, normal } => {
                place("point_mm", point)?;
                let length = libm::hypot(normal[0], normal[1]);
                if (1e-6..=1e6).contains(&length) { Ok(()) } else { Err(ObjectError::NoDirection { key: "normal" }) }
            }
            Self::Bore { centre, radius } => {
                within("radius_mm", radius, BORES)?;
                // Its wall must come near the finger, wherever its centre is.
                let far = radius + PLACES[1];
                centre.into_iter().try_for_each(|value| within("centre_mm", value, [-far, far]))
            }
        }
    }
}

/// Checks that corners are those of a convex polygon, each of them a true corner.
fn convex(corners: &[[f64; 2]]) -> Result<(), ObjectError> {
    let count = corners.len();
    if count == 0 {
        return Err(ObjectError::NoCorner);
    }
    for (index, corner) in corners.iter().enumerate() {
        let near = |other: &&[f64; 2]| libm::hypot(other[0] - corner[0], other[1] - corner[1]) < 1e-3;
        if corners.iter().take(index).find(near).is_some() {
            return Err(ObjectError::RepeatedCorner { index });
        }
    }
    let twice_area = corners.iter().zip(corners.iter().cycle().skip(1)).map(|(a, b)| a[0] * b[1] - a[1] * b[0]);
    let sign = if twice_area.sum::<f64>() < 0.0 { -1.0 } else { 1.0 };
    if count < 3 {
        return Ok(());
    }
    let at = |index: usize| index.checked_rem(count).and_then(|index| corners.get(index)).copied().unwrap_or_default();
    // Which side of the line from corner `first` to the next one a corner lies on: the inner side is positive.
    let inwards = |first: usize, index: usize| {
        let (a, b, p) = (at(first), at(first + 1), at(index));
        let (edge, offset) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
        let size = libm::hypot(edge[0], edge[1]) * libm::hypot(offset[0], offset[1]);
        sign * (edge[0] * offset[1] - edge[1] * offset[0]) > LEAST_TURN * size
    };
    if let Some(index) = (0..count).find(|&index| !inwards(index + count - 1, index + 1)) {
        return Err(ObjectError::NotConvex { index });
    }
    // All turns are alike, so an outline that goes round more than once crosses some edge's line.
    for first in 0..count {
        if let Some(step) = (2..count).find(|&step| !inwards(first, first + step)) {
            return Err(ObjectError::NotConvex { index: (first + step) % count });
        }
    }
    Ok(())
}
