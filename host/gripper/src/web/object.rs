//! Objects as the page fills them in, by the keys of a case file, and as it draws them.

use model_core::object::{Corners, ObjectDesign};
use serde::{Deserialize, Serialize};

/// An object by the keys of `[object]`, below its shape.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum ObjectFields {
    /// A circular cylinder.
    Circle { centre_mm: [f64; 2], radius_mm: f64 },
    /// An elliptic cylinder.
    Ellipse {
        centre_mm: [f64; 2],
        semi_axes_mm: [f64; 2],
        #[serde(default)]
        angle_deg: f64,
    },
    /// A rounded convex polygon.
    Polygon { corners_mm: Vec<[f64; 2]>, rounding_mm: f64 },
    /// A wall.
    HalfPlane { point_mm: [f64; 2], normal: [f64; 2] },
    /// A cylindrical hole, from inside.
    Bore { centre_mm: [f64; 2], radius_mm: f64 },
}

impl From<&ObjectDesign> for ObjectFields {
    fn from(object: &ObjectDesign) -> Self {
        match *object {
            ObjectDesign::Circle { centre, radius } => Self::Circle { centre_mm: centre, radius_mm: radius },
            ObjectDesign::Ellipse { centre, semi_axes, angle } => {
                Self::Ellipse { centre_mm: centre, semi_axes_mm: semi_axes, angle_deg: angle.to_degrees() }
            }
            ObjectDesign::Polygon { corners, rounding } => {
                Self::Polygon { corners_mm: corners.to_vec(), rounding_mm: rounding }
            }
            ObjectDesign::HalfPlane { point, normal } => Self::HalfPlane { point_mm: point, normal },
            ObjectDesign::Bore { centre, radius } => Self::Bore { centre_mm: centre, radius_mm: radius },
        }
    }
}

impl ObjectFields {
    /// The object, validated.
    ///
    /// # Errors
    /// What is wrong with it, with the key.
    pub fn design(&self) -> Result<ObjectDesign, String> {
        let object = match self {
            Self::Circle { centre_mm, radius_mm } => ObjectDesign::Circle { centre: *centre_mm, radius: *radius_mm },
            Self::Ellipse { centre_mm, semi_axes_mm, angle_deg } => {
                ObjectDesign::Ellipse { centre: *centre_mm, semi_axes: *semi_axes_mm, angle: angle_deg.to_radians() }
            }
            Self::Polygon { corners_mm, rounding_mm } => ObjectDesign::Polygon {
                corners: Corners::new(corners_mm).ok_or("corners_mm has too many corners; allowed are 8")?,
                rounding: *rounding_mm,
            },
            Self::HalfPlane { point_mm, normal } => ObjectDesign::HalfPlane { point: *point_mm, normal: *normal },
            Self::Bore { centre_mm, radius_mm } => ObjectDesign::Bore { centre: *centre_mm, radius: *radius_mm },
        };
        object.validate().map_err(|error| error.to_string())?;
        Ok(object)
    }
}

/// The object's outline as a closed polyline, world frame, mm; a wall, also a bore's, is as large as any picture.
pub fn outline(object: &ObjectDesign) -> Vec<[f64; 2]> {
    let round = |to: &dyn Fn(f64, f64) -> [f64; 2]| {
        (0..180).map(|i| f64::from(2 * i).to_radians().sin_cos()).map(|(sin, cos)| to(cos, sin)).collect()
    };
    match *object {
        ObjectDesign::Circle { centre: [x, y], radius } => round(&|cos, sin| [x + radius * cos, y + radius * sin]),
        ObjectDesign::Ellipse { centre: [x, y], semi_axes: [a, b], angle } => {
            let (s, c) = angle.sin_cos();
            round(&|cos, sin| [x + a * cos * c - b * sin * s, y + a * cos * s + b * sin * c])
        }
        ObjectDesign::Polygon { corners, rounding } => {
            // The farthest corner in every direction, moved out by the rounding.
            let directions = (0..360).map(|i| f64::from(i).to_radians().sin_cos());
            let far = |sin: f64, cos: f64| {
                let along = |p: &[f64; 2]| p[0] * cos + p[1] * sin;
                corners.iter().copied().max_by(|p, q| along(p).total_cmp(&along(q)))
            };
            directions
                .filter_map(|(sin, cos)| far(sin, cos).map(|[x, y]| [x + rounding * cos, y + rounding * sin]))
                .collect()
        }
        ObjectDesign::HalfPlane { point: [x, y], normal: [nx, ny] } => {
            let size = nx.hypot(ny).max(f64::MIN_POSITIVE);
            let (nx, ny, far) = (nx / size, ny / size, 1000.0);
            [(far, 0.0), (far, far), (-far, far), (-far, 0.0)]
                .map(|(along, deep)| [x - along * ny - deep * nx, y + along * nx - deep * ny])
                .to_vec()
        }
        ObjectDesign::Bore { centre: [x, y], radius } => {
            // The wall's part about the finger's base, there and back at a larger radius.
            let (far, ahead) = (1000.0, (-y).atan2(-x));
            let half = (far / radius).min(std::f64::consts::PI);
            let on = |r: f64, part: f64| {
                let (sin, cos) = (ahead + half * part).sin_cos();
                [x + r * cos, y + r * sin]
            };
            let parts = || (-180..=180).map(|i| f64::from(i) / 180.0);
            parts().map(|part| on(radius, part)).chain(parts().rev().map(|part| on(radius + far, part))).collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shape_comes_back_as_it_was_sent() {
        for text in [
            r#"{"circle":{"centre_mm":[41.0,45.0],"radius_mm":40.0}}"#,
            r#"{"ellipse":{"centre_mm":[41.0,45.0],"semi_axes_mm":[40.0,30.0],"angle_deg":30.0}}"#,
            r#"{"polygon":{"corners_mm":[[20.0,30.0],[60.0,30.0],[60.0,70.0]],"rounding_mm":5.0}}"#,
            r#"{"half-plane":{"point_mm":[10.0,0.0],"normal":[-1.0,0.0]}}"#,
            r#"{"bore":{"centre_mm":[-180.0,60.0],"radius_mm":200.0}}"#,
        ] {
            let fields: ObjectFields = serde_json::from_str(text).unwrap();
            let object = fields.design().unwrap();
            let back: ObjectFields =
                serde_json::from_str(&serde_json::to_string(&ObjectFields::from(&object)).unwrap()).unwrap();
            let again = back.design().unwrap();
            let (a, b) = (outline(&object), outline(&again));
            assert!(a.len() >= 4 && a.iter().zip(&b).all(|(p, q)| (p[0] - q[0]).hypot(p[1] - q[1]) < 1e-9), "{text}");
        }
    }

    #[test]
    fn a_wrong_number_is_named() {
        let wrong = ObjectFields::Circle { centre_mm: [0.0; 2], radius_mm: -1.0 };
        assert!(wrong.design().unwrap_err().contains("radius_mm is -1"));
    }
}
