//! Objects as the page fills them in, by the keys of a case's `[object]`, and as it draws them.

use fre::case::keys::ObjectTable;
use fre::case::read_object;
use fre::draw::object_contour;
use messages::Object;
use model_core::object::ObjectDesign;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// An object by the keys of `[object]`, as the page has it: not read into types, because serde_json with `arbitrary_precision`, which
/// any crate of a build may ask for, takes no fractions in enums that are tagged inside.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct ObjectFields(Value);

impl From<&Object> for ObjectFields {
    fn from(object: &Object) -> Self {
        // Numbers, lists and a word are always JSON.
        Self(serde_json::to_value(ObjectTable::of(&object.design, object.friction)).unwrap_or_default())
    }
}

impl ObjectFields {
    /// The object, validated as a case's is.
    ///
    /// # Errors
    /// What is wrong with it, with the key.
    pub fn object(&self) -> Result<Object, String> {
        let Value::Object(entries) = &self.0 else { return Err("the object has no keys".to_owned()) };
        let line = |(key, value): (&String, &Value)| Ok(format!("{} = {}\n", quoted(key), toml(key, value)?));
        let text = entries.iter().map(line).collect::<Result<String, String>>()?;
        let (design, friction) = read_object("object", &text).map_err(|error| error.without_place())?;
        Ok(Object { design, friction })
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
    object_contour(object, [0.0; 2], 1000.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shape_comes_back_as_it_was_sent() {
        for text in [
            r#"{"shape":"circle","centre_mm":[41.0,45],"radius_mm":40.5,"friction":0.6}"#,
            r#"{"shape":"ellipse","centre_mm":[41.0,45.0],"semi_axes_mm":[40.0,30.0],"angle_deg":30.0}"#,
            r#"{"shape":"polygon","corners_mm":[[20.0,30.0],[60.0,30.0],[60.0,70.0]],"rounding_mm":5.0}"#,
            r#"{"shape":"half-plane","point_mm":[10.0,0.0],"normal":[-1.0,0.0]}"#,
            r#"{"shape":"bore","centre_mm":[-180.0,60.0],"radius_mm":200.0}"#,
        ] {
            let fields: ObjectFields = serde_json::from_str(text).unwrap();
            let object = fields.object().unwrap();
            let back: ObjectFields =
                serde_json::from_str(&serde_json::to_string(&ObjectFields::from(&object)).unwrap()).unwrap();
            let again = back.object().unwrap();
            assert_eq!(
                (object.friction, again.friction == object.friction),
                (if text.contains("friction") { 0.6 } else { 0.0 }, true)
            );
            let (a, b) = (contour(&object.design), contour(&again.design));
            assert!(a.len() >= 4 && a.iter().zip(&b).all(|(p, q)| (p[0] - q[0]).hypot(p[1] - q[1]) < 1e-9), "{text}");
        }
    }

    #[test]
    fn what_is_wrong_is_said_as_in_a_case() {
        let said = |text: &str| serde_json::from_str::<ObjectFields>(text).unwrap().object().unwrap_err();
        let wrong = said(r#"{"shape":"circle","centre_mm":[0,0],"radius_mm":-1}"#);
        assert!(wrong.starts_with("radius_mm = -1.0: allowed is"), "{wrong}");
        let unknown = said(r#"{"shape":"circle","centre_mm":[0,0],"radius":20}"#);
        assert!(unknown.contains("radius_mm"), "{unknown}");
        let rough = said(r#"{"shape":"circle","centre_mm":[0,0],"radius_mm":20,"friction":4}"#);
        assert!(rough.starts_with("friction = 4.0: allowed is"), "{rough}");
        let text = said(r#"{"shape":"circle","centre_mm":[0,0],"radius_mm":null}"#);
        assert!(text.starts_with("radius_mm = null"), "{text}");
    }
}
