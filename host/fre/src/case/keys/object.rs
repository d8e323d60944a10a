//! Keys of `[object]`.

use model_core::equilibrium::FRICTIONS;
use model_core::object::{BORES, MAX_CORNERS, PLACES, RADII};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The object, world frame: that is the finger frame at a motor angle of 0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "shape", rename_all = "kebab-case", deny_unknown_fields)]
pub enum ObjectTable {
    /// A circular cylinder.
    Circle {
        /// Radius.
        #[schemars(extend("x-unit" = "mm", "x-range" = RADII, "x-picture" = "circle"))]
        radius_mm: f64,
        /// Centre.
        #[schemars(extend("x-unit" = "mm", "x-range" = PLACES, "x-picture" = "circle"))]
        centre_mm: [f64; 2],
        /// Coulomb's coefficient of friction between finger and object.
        #[serde(default)]
        #[schemars(extend("x-range" = FRICTIONS))]
        friction: f64,
    },
    /// An elliptic cylinder.
    Ellipse {
        /// Centre.
        #[schemars(extend("x-unit" = "mm", "x-range" = PLACES, "x-picture" = "ellipse"))]
        centre_mm: [f64; 2],
        /// Semi-axes, in any order. Their ends' radius of curvature must be at least 0.1 mm.
        #[schemars(extend("x-unit" = "mm", "x-range" = RADII, "x-needed" = "[a, b] in mm", "x-pair" = "[a, b]", "x-picture" = "ellipse"))]
        semi_axes_mm: [f64; 2],
        /// Angle of the first semi-axis from x, counter-clockwise.
        #[serde(default)]
        #[schemars(extend("x-unit" = "degrees", "x-range" = [-360.0, 360.0], "x-picture" = "ellipse"))]
        angle_deg: f64,
        /// Coulomb's coefficient of friction between finger and object.
        #[serde(default)]
        #[schemars(extend("x-range" = FRICTIONS))]
        friction: f64,
    },
    /// A convex prism with rounded edges: all points within `rounding_mm` of a polygon.
    Polygon {
        /// Corners of the polygon, which are the centres of the roundings, in order around the object. Two make a bar.
        #[schemars(extend(
            "x-unit" = "mm", "x-range" = PLACES, "maxItems" = MAX_CORNERS, "minItems" = 1,
            "x-needed" = "an array of [x, y] in mm, world frame, in order around the object", "x-picture" = "polygon"
        ))]
        corners_mm: Vec<[f64; 2]>,
        /// Radius of the roundings: the contour lies that far outside of the polygon.
        #[schemars(extend("x-unit" = "mm", "x-range" = RADII, "x-picture" = "polygon"))]
        rounding_mm: f64,
        /// Coulomb's coefficient of friction between finger and object.
        #[serde(default)]
        #[schemars(extend("x-range" = FRICTIONS))]
        friction: f64,
    },
    /// A wall or a floor.
    HalfPlane {
        /// A point of the surface.
        #[schemars(extend("x-unit" = "mm", "x-range" = PLACES, "x-picture" = "half-plane"))]
        point_mm: [f64; 2],
        /// Direction out of the object; its length does not matter.
        #[schemars(extend(
            "x-limits" = "a length of 1e-6 to 1e6", "x-needed" = "[x, y], out of the object", "x-picture" = "half-plane"
        ))]
        normal: [f64; 2],
        /// Coulomb's coefficient of friction between finger and object.
        #[serde(default)]
        #[schemars(extend("x-range" = FRICTIONS))]
        friction: f64,
    },
    /// A cylindrical hole, the finger being in it.
    Bore {
        /// Radius.
        #[schemars(extend("x-unit" = "mm", "x-range" = BORES, "x-picture" = "bore"))]
        radius_mm: f64,
        /// Centre.
        #[schemars(extend(
            "x-unit" = "mm", "x-limits" = "the wall comes within 2000 mm of the origin", "x-picture" = "bore"
        ))]
        centre_mm: [f64; 2],
        /// Coulomb's coefficient of friction between finger and object.
        #[serde(default)]
        #[schemars(extend("x-range" = FRICTIONS))]
        friction: f64,
    },
}

impl ObjectTable {
    /// The coefficient of friction.
    pub fn friction(&self) -> f64 {
        match self {
            Self::Circle { friction, .. }
            | Self::Ellipse { friction, .. }
            | Self::Polygon { friction, .. }
            | Self::HalfPlane { friction, .. }
            | Self::Bore { friction, .. } => *friction,
        }
    }
}
