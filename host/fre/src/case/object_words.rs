//! What objects are called in texts and pictures.

use model_core::object::ObjectDesign;
use serde_json::Value;

use super::keys::ObjectTable;

/// An object in words, each part for itself.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectWords {
    /// Its kind, such as "cylinder".
    pub kind: &'static str,
    /// Its size, such as "Ø80 mm". A wall has none.
    pub size: Option<String>,
    /// Its place in the world frame, such as "at (41, 45) mm". A polygon has too many.
    pub place: Option<String>,
}

impl ObjectWords {
    /// An object's words.
    pub fn of(object: &ObjectDesign) -> Self {
        let length = |mm: f64| (1e3 * mm).round() / 1e3;
        let at = |[x, y]: [f64; 2]| Some(format!("at ({x}, {y}) mm"));
        let (kind, size, place) = match *object {
            ObjectDesign::Circle { centre, radius } => {
                ("cylinder", Some(format!("Ø{} mm", length(2.0 * radius))), at(centre))
            }
            ObjectDesign::Ellipse { centre, semi_axes: [a, b], angle } => {
                let degrees = (1e6 * angle.to_degrees()).round() / 1e6;
                let turned = if degrees == 0.0 { String::new() } else { format!(" turned by {degrees}°") };
                let size = format!("{} × {} mm", length(2.0 * a), length(2.0 * b));
                ("ellipse", Some(size), at(centre).map(|place| place + &turned))
            }
            ObjectDesign::Polygon { corners, rounding } => {
                let corner = if corners.len() == 1 { "corner" } else { "corners" };
                let size = format!("of {} {corner}, rounding {} mm", corners.len(), length(rounding));
                ("polygon", Some(size), None)
            }
            ObjectDesign::HalfPlane { point, normal: [x, y] } => {
                ("wall", None, at(point).map(|place| format!("{place}, normal ({x}, {y})")))
            }
            ObjectDesign::Bore { centre, radius } => {
                ("bore", Some(format!("Ø{} mm", length(2.0 * radius))), at(centre))
            }
        };
        Self { kind, size, place }
    }

    /// Kind and size: "cylinder Ø80 mm".
    pub fn name(&self) -> String {
        match &self.size {
            Some(size) => format!("{} {size}", self.kind),
            None => self.kind.to_owned(),
        }
    }

    /// Kind, size and place as part of a sentence: "a cylinder Ø80 mm at (41, 45) mm".
    pub fn phrase(&self) -> String {
        let article = if self.kind.starts_with('e') { "an" } else { "a" };
        let place = self.place.as_ref().map_or_else(String::new, |place| format!(" {place}"));
        format!("{article} {}{place}", self.name())
    }
}

/// An object by its shape and the keys of a case, without the friction that it does not have: "circle, radius_mm = 40.0, centre_mm =
/// [41.0, 45.0]".
pub fn object_keys(object: &ObjectDesign, friction: f64) -> String {
    // Numbers, lists and words are always JSON.
    let table = ObjectTable::of(object, friction);
    let Ok(Value::Object(entries)) = serde_json::to_value(table) else { return String::new() };
    let words = |(key, value): (&String, &Value)| match (key.as_str(), value) {
        ("friction", _) if friction == 0.0 => None,
        ("shape", Value::String(shape)) => Some(shape.clone()),
        _ => Some(format!("{key} = {}", value.to_string().replace(',', ", "))),
    };
    entries.iter().filter_map(words).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use model_core::object::Corners;

    use super::*;

    #[test]
    fn every_shape_has_its_words_and_its_keys() {
        let corners = Corners::new(&[[0.0, 0.0], [10.0, 0.5]]).unwrap();
        let cases = [
            (
                ObjectDesign::Circle { centre: [41.0, 45.5], radius: 40.0 },
                "a cylinder Ø80 mm at (41, 45.5) mm",
                "circle, radius_mm = 40.0, centre_mm = [41.0, 45.5]",
            ),
            (
                ObjectDesign::Ellipse { centre: [1.0, 2.0], semi_axes: [20.0, 45.25], angle: 0.0 },
                "an ellipse 40 × 90.5 mm at (1, 2) mm",
                "ellipse, centre_mm = [1.0, 2.0], semi_axes_mm = [20.0, 45.25], angle_deg = 0.0",
            ),
            (
                ObjectDesign::Ellipse { centre: [1.0, 2.0], semi_axes: [20.0, 45.0], angle: std::f64::consts::PI },
                "an ellipse 40 × 90 mm at (1, 2) mm turned by 180°",
                "ellipse, centre_mm = [1.0, 2.0], semi_axes_mm = [20.0, 45.0], angle_deg = 180.0",
            ),
            (
                ObjectDesign::Polygon { corners, rounding: 2.0 },
                "a polygon of 2 corners, rounding 2 mm",
                "polygon, corners_mm = [[0.0, 0.0], [10.0, 0.5]], rounding_mm = 2.0",
            ),
            (
                ObjectDesign::HalfPlane { point: [4.0, 0.0], normal: [-1.0, 0.0] },
                "a wall at (4, 0) mm, normal (-1, 0)",
                "half-plane, point_mm = [4.0, 0.0], normal = [-1.0, 0.0]",
            ),
            (
                ObjectDesign::Bore { centre: [-122.0, 0.0], radius: 150.0 },
                "a bore Ø300 mm at (-122, 0) mm",
                "bore, radius_mm = 150.0, centre_mm = [-122.0, 0.0]",
            ),
        ];
        for (object, phrase, keys) in cases {
            assert_eq!(ObjectWords::of(&object).phrase(), phrase);
            assert_eq!(object_keys(&object, 0.0), keys);
            assert_eq!(object_keys(&object, 0.6), format!("{keys}, friction = 0.6"));
        }
    }
}
