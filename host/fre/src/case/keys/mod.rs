//! The model of a case file: every key with its unit, default, range and meaning, declared once.
//!
//! Serde reads and writes these types. Schemars makes their JSON Schema, from which come the checks of a file, the keys
//! that sweeps and edits address ([`super::Document`]) and the page of all keys ([`super::reference()`]). A doc comment is what a key means. Attributes say the rest:
//!
//! | attribute | says |
//! |---|---|
//! | `x-unit` | unit of the numbers |
//! | `x-range` | smallest and largest number, in the file's unit |
//! | `x-limits` | the range in words where it depends on other keys; the finger's own checks keep it |
//! | `x-needed` | what a message asks for, where type and unit do not say it |
//! | `x-pair` | names of a pair's two numbers |
//! | `x-default` | the default in words, where it is not a value |
//! | `x-picture` | picture on the page of all keys |

mod finger;
mod motion;
mod object;
mod values;

use std::sync::LazyLock;

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value as Json};

pub use finger::{
    BeamTable, FingerTable, HingeFrom, HingeKind, HingeTable, LamellaKind, LamellaeTable, MaterialLaw, MaterialTable,
    Memory, MotorTable, PlaneStrain, RibEnds, TipTable,
};
pub use motion::{MAX_ANGLE, MAX_DISTANCE, MAX_TIME, MotionTable};
pub use object::ObjectTable;
pub use values::{Along, PerRib, RibThickness, TipFrom, TipWord};

/// A case: a finger, the object that it grasps and the motion of its base.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CaseFile {
    /// The finger: a table, the name of a finger file beside the case (its keys at the top or under `[finger]`), or
    /// `"preset:NAME"`.
    #[schemars(extend("x-needed" = "a table [finger], a finger file or \"preset:NAME\""))]
    pub finger: FingerEntry,
    /// The object, world frame.
    #[schemars(extend("x-needed" = "a table with shape and the shape's keys"))]
    pub object: ObjectTable,
    /// How the finger's base moves, and the places where results are wanted.
    #[schemars(extend("x-needed" = "a table with motor_angles_deg, or with direction and distances_mm"))]
    pub motion: MotionTable,
}

/// A finger in a case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum FingerEntry {
    /// `"preset:NAME"` or a file.
    Named(String),
    /// Two flexible beams that meet at the tip, and lamellae between them.
    Table(Box<FingerTable>),
}

/// JSON Schema of a case file (draft 7, which editors read), without references.
pub fn schema() -> &'static Json {
    static SCHEMA: LazyLock<Json> = LazyLock::new(generate::<CaseFile>);
    &SCHEMA
}

/// JSON Schema of a finger file.
pub(crate) fn finger_schema() -> &'static Json {
    static SCHEMA: LazyLock<Json> = LazyLock::new(generate::<FingerTable>);
    &SCHEMA
}

/// JSON Schema of the keys of `[object]` alone.
pub(crate) fn object_schema() -> &'static Json {
    static SCHEMA: LazyLock<Json> = LazyLock::new(generate::<ObjectTable>);
    &SCHEMA
}

fn generate<X: JsonSchema>() -> Json {
    let settings = SchemaSettings::draft07().with(|settings| settings.inline_subschemas = true);
    let mut schema = settings.into_generator().into_root_schema_for::<X>().to_value();
    tidy(&mut schema);
    schema
}

/// Brings a schema into the form that its readers expect: no null (TOML has none), and what applies to a key applied to
/// each number and list in it.
fn tidy(schema: &mut Json) {
    let Json::Object(entries) = schema else { return };
    entries.remove("format");
    if entries.get("default").is_some_and(Json::is_null) {
        entries.remove("default");
    }
    if let Some(Json::Array(types)) = entries.get_mut("type") {
        types.retain(|name| name != "null");
        if let [only] = &types[..] {
            let only = only.clone();
            entries.insert("type".to_owned(), only);
        }
    }
    if let Some(Json::Array(forms)) = entries.get_mut("anyOf") {
        forms.retain(|form| form["type"] != "null");
        if let [Json::Object(only)] = &forms[..] {
            let only = only.clone();
            entries.remove("anyOf");
            for (key, value) in only {
                entries.entry(key).or_insert(value);
            }
        }
    }
    hand_down(entries);
    for key in ["anyOf", "oneOf", "items"] {
        match entries.get_mut(key) {
            Some(Json::Array(parts)) => parts.iter_mut().for_each(tidy),
            Some(part) => tidy(part),
            None => {}
        }
    }
    if let Some(Json::Object(properties)) = entries.get_mut("properties") {
        properties.values_mut().for_each(tidy);
    }
}

/// Gives unit, range, names and lengths of a key to the forms that it can have and to their entries.
fn hand_down(entries: &mut Map<String, Json>) {
    if entries.get("type").is_some_and(|name| name == "number")
        && let Some([least, most]) = entries.get("x-range").and_then(Json::as_array).map(Vec::as_slice)
    {
        let (least, most) = (least.clone(), most.clone());
        entries.insert("minimum".to_owned(), least);
        entries.insert("maximum".to_owned(), most);
    }
    let said: Vec<(String, Json)> = ["x-unit", "x-range", "x-note", "x-pair"]
        .into_iter()
        .filter_map(|key| Some((key.to_owned(), entries.get(key)?.clone())))
        .collect();
    let length: Vec<(String, Json)> = ["minItems", "maxItems"]
        .into_iter()
        .filter_map(|key| Some((key.to_owned(), entries.get(key)?.clone())))
        .collect();
    let give = |part: &mut Json, said: &[(String, Json)]| {
        if let Json::Object(part) = part {
            for (key, value) in said {
                part.entry(key.clone()).or_insert_with(|| value.clone());
            }
        }
    };
    if let Some(Json::Array(forms)) = entries.get_mut("anyOf") {
        for form in forms {
            give(form, &said);
            if form["type"] == "array" {
                give(form, &length);
            }
        }
        entries.remove("minItems");
        entries.remove("maxItems");
    }
    match entries.get_mut("items") {
        // Of a pair, the second number is the key's; the first says where.
        Some(Json::Array(pair)) => pair.last_mut().into_iter().for_each(|value| give(value, &said)),
        Some(item) => give(item, &said),
        None => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Calls with every key's path and schema.
    fn each(schema: &Json, path: &str, see: &mut impl FnMut(&str, &Json)) {
        for form in ["anyOf", "oneOf"].iter().filter_map(|key| schema[*key].as_array()).flatten() {
            each(form, path, see);
        }
        for (key, property) in schema["properties"].as_object().into_iter().flatten() {
            let path = format!("{path}.{key}");
            see(&path, property);
            each(property, &path, see);
        }
    }

    #[test]
    fn every_key_says_what_it_means_and_every_length_its_unit() {
        let mut count = 0;
        each(schema(), "", &mut |path, key| {
            count += 1;
            assert!(key["description"].is_string() || !key["const"].is_null(), "{path}: {key}");
            for (ending, unit) in
                [("_mm", "mm"), ("_deg", "degrees"), ("_pa", "Pa"), ("_s", "s"), ("_per_s", "degrees/s")]
            {
                let other = ending == "_s" && path.ends_with("_per_s");
                if path.ends_with(ending) && !other {
                    assert_eq!(key["x-unit"], unit, "{path}");
                }
            }
        });
        assert!(count > 40, "{count}");
    }

    #[test]
    fn nothing_is_null_and_nothing_is_a_reference() {
        let text = schema().to_string();
        assert!(!text.contains("null") && !text.contains("$ref") && !text.contains("format"), "{text}");
    }
}
