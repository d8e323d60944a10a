//! Objects as the page fills them in, by the keys of a case's `[object]`, and as it draws them.

use fre::case::keys::ObjectTable;
use fre::case::read_object;
use model_core::object::ObjectDesign;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// An object by the keys of `[object]`, as the page has it: not read into types, because serde_json with `arbitrary_precision`, which
/// any crate of a build may ask for, takes no fractions in enums that are tagged inside.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct ObjectFields(Value);

impl From<&ObjectDesign> for ObjectFields {
    fn from(object: &ObjectDesign) -> Self {
        // Numbers, lists and a word are always JSON.
        Self(serde_json::to_value(ObjectTable::from(object)).unwrap_or_default())
    }
}

impl ObjectFields {
    /// The object, validated as a case's is.
    ///
    /// # Errors
    /// What is wrong with it, with the key.
    pub fn design(&self) -> Result<ObjectDesign, String> {
        let Value::Object(entries) = &self.0 else { return Err("the object has no keys".to_owned()) };
        let line = |(key, value): (&String, &Value)| Ok(format!("{} = {}\n", quoted(key), toml(key, value)?));
        let text = entries.iter().map(line).collect::<Result<String, String>>()?;
        read_object("object", &text).map_err(|error| error.without_place())
    }
}

/// A value as TOML, in which cases are written.
fn toml(key: &str, value: &Value) -> Result<String, String> {
    match value {
        Value::Number(number) => match number.as_f64() {
            Some(number) if number.is_finite() => Ok(format!("{number:?}")),
            _ => Err(format!("{key} = {number}: is not a number that can be used")),
        },
        Value::String(word) => Ok(quoted(word)),
        Value::Array(values) => {
            let values = values.iter().map(|value| toml(key, value)).collect::<Result<Vec<_>, _>>()?;
            Ok(format!("[{}]", values.join(", ")))
        }
        other => Err(format!("{key} = {other}: is neither a number, nor a word, nor a list")),
    }
}

/// A word in quotation marks: those of JSON are TOML's, too.
fn quoted(word: &str) -> String {
    Value::from(word).to_string()
}

/// The object's contour as a closed polyline, world frame, mm; a wall, also a bore's, is as large as any picture.
pub fn contour(object: &ObjectDesign) -> Vec<[f64; 2]> {
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
            r#"{"shape":"circle","centre_mm":[41.0,45],"radius_mm":40.5}"#,
            r#"{"shape":"ellipse","centre_mm":[41.0,45.0],"semi_axes_mm":[40.0,30.0],"angle_deg":30.0}"#,
            r#"{"shape":"polygon","corners_mm":[[20.0,30.0],[60.0,30.0],[60.0,70.0]],"rounding_mm":5.0}"#,
            r#"{"shape":"half-plane","point_mm":[10.0,0.0],"normal":[-1.0,0.0]}"#,
            r#"{"shape":"bore","centre_mm":[-180.0,60.0],"radius_mm":200.0}"#,
        ] {
            let fields: ObjectFields = serde_json::from_str(text).unwrap();
            let object = fields.design().unwrap();
            let back: ObjectFields =
                serde_json::from_str(&serde_json::to_string(&ObjectFields::from(&object)).unwrap()).unwrap();
            let again = back.design().unwrap();
            let (a, b) = (contour(&object), contour(&again));
            assert!(a.len() >= 4 && a.iter().zip(&b).all(|(p, q)| (p[0] - q[0]).hypot(p[1] - q[1]) < 1e-9), "{text}");
        }
    }

    #[test]
    fn what_is_wrong_is_said_as_in_a_case() {
        let said = |text: &str| serde_json::from_str::<ObjectFields>(text).unwrap().design().unwrap_err();
        let wrong = said(r#"{"shape":"circle","centre_mm":[0,0],"radius_mm":-1}"#);
        assert!(wrong.starts_with("radius_mm = -1.0: allowed is"), "{wrong}");
        let unknown = said(r#"{"shape":"circle","centre_mm":[0,0],"radius":20}"#);
        assert!(unknown.contains("radius_mm"), "{unknown}");
        let text = said(r#"{"shape":"circle","centre_mm":[0,0],"radius_mm":null}"#);
        assert!(text.starts_with("radius_mm = null"), "{text}");
    }
}
