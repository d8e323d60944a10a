//! A case's document: its text with the finger written out, whose values are changed by their keys. Comments and order
//! survive.

use std::path::Path;

use serde_json::Value as Json;
use toml_edit::{DocumentMut, InlineTable, Item, Table, TableLike, Value};

use super::error::{CaseError, KeyError};
use super::finger::Finger;
use super::keys::{self, FingerTable};
use super::preset::{no_such_preset, preset_text};
use super::read::{Case, without_finger};
use super::source::{self, Source};
use super::written::Written;
use crate::faces;
use crate::visible::visible;

/// How many keys a message suggests.
const SUGGESTIONS: usize = 4;
/// Numbers nearer than this, as a share, are the same: a conversion of units has rounded.
const SAME: f64 = 1e-12;

/// A case in which every number can be set by its dotted key, such as `object.centre_mm.1` (or `object.centre_mm[1]`, as
/// messages have it) or `finger.front.thickness_mm`.
#[derive(Clone, Debug)]
pub struct Document {
    name: String,
    root: DocumentMut,
    /// Where the case itself has what some commands refuse, if its lines are others because its finger is written out.
    written: Option<Written>,
}

impl Document {
    /// Reads a case file; a preset or a finger file that it names is written out.
    ///
    /// # Errors
    /// The first thing in the case that cannot be used.
    pub fn read(path: &Path) -> Result<Self, CaseError> {
        // The case's own reader says best what is wrong, with line and key.
        let (_, text) = Case::read_with_text(path)?;
        Self::resolve(&path.display().to_string(), &text, path.parent().unwrap_or(Path::new("")))
    }

    /// Reads a case from a text; finger files it names are looked for in a folder.
    ///
    /// # Errors
    /// The text is not TOML, or its finger cannot be found.
    pub fn resolve(name: &str, text: &str, folder: &Path) -> Result<Self, CaseError> {
        let case = Source { name: name.to_owned(), text: text.to_owned() };
        let (mut root, mut written) = (parse(&case)?, None);
        if let Some(word) = root.get("finger").and_then(Item::as_str).map(str::to_owned) {
            let tree = case.parse()?;
            let table = source::Table::root(&case, tree.get_ref());
            written = Some(Written::of(&table));
            let (from, source) = match word.strip_prefix("preset:") {
                Some(preset) => {
                    let text = preset_text(preset).ok_or_else(|| table.refuse("finger", no_such_preset()))?;
                    (preset.to_owned(), Source { name: word.clone(), text: text.to_owned() })
                }
                None => {
                    let file = folder.join(&word);
                    let stem = file.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
                    (stem, Source::read(&file).map_err(|error| without_finger(&table, error))?)
                }
            };
            let file = parse(&source)?;
            let mut finger = match file.get("finger") {
                Some(inner) => as_table(inner),
                None => file.into_table(),
            };
            if !finger.contains_key("name") {
                finger.insert("name", toml_edit::value(visible(&from)));
            }
            set_free(&mut finger);
            root.insert("finger", Item::Table(finger));
        }
        Ok(Self { name: name.to_owned(), root, written })
    }

    /// The document as TOML; the same for the same case.
    pub fn text(&self) -> String {
        self.root.to_string()
    }

    /// The case that it describes.
    ///
    /// # Errors
    /// The first thing in it that cannot be used.
    pub fn case(&self) -> Result<Case, CaseError> {
        let mut case = Case::parse(&self.name, &self.text())?;
        if let Some(written) = &self.written {
            case.written = written.clone();
        }
        Ok(case)
    }

    /// Keys of the numbers that can be varied, sorted. The places of the motion are not among them.
    pub fn keys(&self) -> Vec<String> {
        let mut keys = Vec::new();
        table_keys(self.root.as_table(), keys::schema(), "", &mut keys);
        keys.retain(|key| !key.starts_with("motion.motor_angles_deg") && !key.starts_with("motion.distances_mm"));
        keys.sort();
        keys
    }

    /// Fails for a key that is not a number of this case; the error names those that are nearest.
    ///
    /// # Errors
    /// An unknown key.
    pub fn need(&self, key: &str) -> Result<(), KeyError> {
        let wanted = dotted(key);
        let mut keys = self.keys();
        if keys.contains(&wanted) {
            return Ok(());
        }
        // A key is often given by its last word: what ends alike comes first.
        let end = |key: &str| key.split('.').rfind(|part| part.parse::<usize>().is_err()).unwrap_or(key).to_owned();
        keys.sort_by_cached_key(|known| {
            strsim::levenshtein(known, &wanted).min(1 + strsim::levenshtein(&end(known), &end(&wanted)))
        });
        keys.truncate(SUGGESTIONS);
        Err(KeyError::Unknown { key: key.to_owned(), nearest: keys })
    }

    /// Sets a number.
    ///
    /// # Errors
    /// As [`Self::need`].
    pub fn set(&mut self, key: &str, value: f64) -> Result<(), KeyError> {
        self.need(key)?;
        self.set_known(key, value);
        Ok(())
    }

    /// Sets a number whose key [`Self::need`] has found.
    pub fn set_known(&mut self, key: &str, value: f64) {
        let key = dotted(key);
        self.written.iter_mut().for_each(|written| written.forget(&key));
        put(self.root.as_item_mut(), &key, value.into());
    }

    /// Sets the motor angles, degrees.
    pub fn set_angles(&mut self, angles_deg: &[f64]) {
        put(self.root.as_item_mut(), "motion.motor_angles_deg", angles_deg.iter().copied().collect());
    }

    /// Sets what differs in the finger; the rest stays as it was written.
    pub fn set_finger(&mut self, finger: &Finger) {
        // A model of numbers and texts is always JSON.
        let mut model = serde_json::to_value(FingerTable::from(finger)).unwrap_or_default();
        let places = self.case().ok().map(|case| case.finger.design.lamellae.attachments);
        let is_moved = places.as_ref() != Some(&finger.design.lamellae.attachments);
        let Some(item) = self.root.get_mut("finger") else { return };
        // Lamellae have one of several forms of places: only one that differs takes the place of the form in the file.
        let lamellae = item.get_mut("lamellae").and_then(Item::as_table_like_mut);
        if let (Some(written), Some(model)) = (lamellae, model.get_mut("lamellae").and_then(Json::as_object_mut)) {
            for key in ["heights_mm", "angle_deg", "front_arc_mm", "back_arc_mm"] {
                if !is_moved {
                    model.remove(key);
                } else if model.get(key).is_none_or(Json::is_null) || key == "angle_deg" {
                    written.remove(key);
                }
            }
        }
        // As long as the tip begins where the file's words put it, they stay.
        let tip = item.get("tip").and_then(|tip| tip.get("rigid_above_mm"));
        let is_there = faces::solid_above(&finger.design.front, &finger.design.back) == finger.design.rigid_above;
        if tip.is_some_and(Item::is_str)
            && is_there
            && let Some(model) = model.get_mut("tip").and_then(Json::as_object_mut)
        {
            model.remove("rigid_above_mm");
        }
        merge(item, &model, keys::finger_schema());
    }

    /// The finger as the text of a finger file: its keys at the top, below `remarks`, a comment line each.
    pub fn finger_text(&self, remarks: &[String]) -> String {
        let mut finger = self.root.get("finger").map(as_table).unwrap_or_default();
        set_free(&mut finger);
        let remarks = remarks.iter().map(|remark| format!("# {remark}\n")).collect::<String>();
        remarks + DocumentMut::from(finger).to_string().trim_start_matches('\n')
    }
}

/// The tree to edit; what is not TOML is refused with its line.
fn parse(source: &Source) -> Result<DocumentMut, CaseError> {
    source.parse()?;
    source.text.parse().map_err(|error: toml_edit::TomlError| source.syntax(error.span(), error.message()))
}

/// A table of its own, whatever form it was written in.
fn as_table(item: &Item) -> Table {
    let mut table = item.clone().into_table().unwrap_or_default();
    table.set_dotted(false);
    table.set_implicit(false);
    table
}

/// Takes a table's places in its file, so that it goes wherever it is put.
fn set_free(table: &mut Table) {
    table.set_position(None);
    table.iter_mut().filter_map(|(_, item)| item.as_table_mut()).for_each(set_free);
}

/// A key with dots alone: `a[1]` is `a.1`.
pub(crate) fn dotted(key: &str) -> String {
    key.replace('[', ".").replace(']', "")
}

/// The schema of a table's keys: of several variants, the one whose tag the table carries.
fn properties<'s>(table: &dyn TableLike, schema: &'s Json) -> &'s Json {
    let forms = schema["anyOf"].as_array().into_iter().flatten().find(|form| form["type"] == "object");
    let schema = forms.unwrap_or(schema);
    let fits = |variant: &&Json| {
        let mut properties = variant["properties"].as_object().into_iter().flatten();
        properties.any(|(key, property)| {
            property["const"].as_str().is_some_and(|tag| table.get(key).and_then(Item::as_str) == Some(tag))
        })
    };
    let variant = schema["oneOf"].as_array().into_iter().flatten().find(fits);
    &variant.unwrap_or(schema)["properties"]
}

/// True for a key that may hold one number.
fn is_number(schema: &Json) -> bool {
    schema["type"] == "number" || schema["anyOf"].as_array().is_some_and(|forms| forms.iter().any(is_number))
}

fn table_keys(table: &dyn TableLike, schema: &Json, path: &str, keys: &mut Vec<String>) {
    let empty = Table::new();
    for (key, schema) in properties(table, schema).as_object().into_iter().flatten() {
        let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        match table.get(key) {
            Some(item) => match item.as_table_like() {
                Some(below) => table_keys(below, schema, &path, keys),
                None => item.as_value().into_iter().for_each(|value| value_keys(value, schema, path.clone(), keys)),
            },
            None if is_number(schema) => keys.push(path),
            None => table_keys(&empty, schema, &path, keys),
        }
    }
}

fn value_keys(value: &Value, schema: &Json, path: String, keys: &mut Vec<String>) {
    match value {
        Value::Integer(_) | Value::Float(_) => keys.push(path),
        Value::Array(items) => {
            for (index, item) in items.iter().enumerate() {
                value_keys(item, &Json::Null, format!("{path}.{index}"), keys);
            }
            if is_number(schema) {
                keys.push(path);
            }
        }
        _ => {}
    }
}

/// Sets the value at a dotted key; tables that are missing on the way are made.
fn put(item: &mut Item, path: &str, value: Value) {
    let (key, rest) = path.split_once('.').map_or((path, None), |(key, rest)| (key, Some(rest)));
    if let Item::Value(Value::Array(_)) = item {
        if let Item::Value(list) = item {
            put_in_list(list, path, value);
        }
        return;
    }
    let inline = item.is_inline_table();
    let Some(table) = item.as_table_like_mut() else { return };
    match (rest, table.get_mut(key)) {
        (None, Some(item)) => replace(item, value),
        (None, None) => {
            table.insert(key, Item::Value(value));
        }
        (Some(rest), Some(item)) => put(item, rest, value),
        (Some(rest), None) => {
            let mut below =
                if inline { Item::Value(Value::InlineTable(InlineTable::new())) } else { Item::Table(Table::new()) };
            put(&mut below, rest, value);
            table.insert(key, below);
        }
    }
}

/// The same in a list, and in the lists within it.
fn put_in_list(list: &mut Value, path: &str, value: Value) {
    let (index, rest) = path.split_once('.').map_or((path, None), |(index, rest)| (index, Some(rest)));
    let entry = list.as_array_mut().zip(index.parse().ok()).and_then(|(list, index)| list.get_mut(index));
    match (entry, rest) {
        (Some(entry), Some(rest)) => put_in_list(entry, rest, value),
        (Some(entry), None) => replace_value(entry, value),
        (None, _) => {}
    }
}

fn replace(item: &mut Item, value: Value) {
    match item {
        Item::Value(old) => replace_value(old, value),
        other => *other = Item::Value(value),
    }
}

/// Another value in the same place, with the blanks and comments around it.
fn replace_value(old: &mut Value, mut value: Value) {
    *value.decor_mut() = old.decor().clone();
    *old = value;
}

/// Sets what differs between an item and the model of it.
fn merge(item: &mut Item, model: &Json, schema: &Json) {
    match model {
        Json::Object(entries) => {
            let inline = item.is_inline_table();
            let Some(table) = item.as_table_like_mut() else { return replace(item, value(model)) };
            let properties = properties(table, schema);
            for (key, model) in entries {
                let schema = &properties[key];
                match table.get_mut(key) {
                    Some(item) => merge(item, model, schema),
                    None if schema["default"] == *model => {}
                    None => {
                        let new = value(model);
                        let new = match new {
                            Value::InlineTable(table) if !inline => Item::Table(table.into_table()),
                            other => Item::Value(other),
                        };
                        table.insert(key, new);
                    }
                }
            }
        }
        _ => match item {
            Item::Value(old) => merge_value(old, model),
            other => *other = Item::Value(value(model)),
        },
    }
}

fn merge_value(old: &mut Value, model: &Json) {
    match (&mut *old, model) {
        (Value::Array(list), Json::Array(models)) if list.len() == models.len() => {
            list.iter_mut().zip(models).for_each(|(old, model)| merge_value(old, model));
        }
        (Value::Integer(_) | Value::Float(_), Json::Number(new)) => {
            let number = old.as_float().or(old.as_integer().map(|integer| integer as f64)).unwrap_or(f64::NAN);
            let new = new.as_f64().unwrap_or(f64::NAN);
            let same = (number - new).abs() <= SAME * number.abs().max(new.abs());
            if !same {
                replace_value(old, new.into());
            }
        }
        (Value::String(text), Json::String(new)) if text.value() == new => {}
        _ => replace_value(old, value(model)),
    }
}

/// A JSON value as TOML.
fn value(model: &Json) -> Value {
    match model {
        Json::String(text) => text.into(),
        Json::Bool(value) => (*value).into(),
        Json::Number(number) => number.as_f64().unwrap_or_default().into(),
        Json::Array(list) => list.iter().map(value).collect(),
        Json::Object(entries) => {
            Value::InlineTable(entries.iter().map(|(key, model)| (key.as_str(), value(model))).collect())
        }
        // The model has no null: what is absent is left out.
        Json::Null => "".into(),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::{Document, preset_text};
    use crate::case::{Case, PRESETS, preset, read_finger};

    const REST: &str = "[object]\nshape = \"circle\"\nradius_mm = 40 # of a bottle\ncentre_mm = [41, 0x2d]\n\
        [motion]\nmotor_angles_deg = [1, 2.5]\n";

    /// A case with a preset, turned by its motor if it has one, else moved by a gripper's jaw.
    fn document(name: &str) -> (Document, Case) {
        let has_motor = preset(name).unwrap().unwrap().has_motor;
        let jaw = "direction = [1, 0]\ndistances_mm = ";
        let rest = if has_motor { REST.to_owned() } else { REST.replace("motor_angles_deg = ", jaw) };
        let text = format!("finger = \"preset:{name}\"\n{rest}");
        let document = Document::resolve("case.toml", &text, Path::new("")).unwrap();
        (document, Case::parse("case.toml", &text).unwrap())
    }

    #[test]
    fn a_resolved_case_is_the_same_case() {
        for preset in PRESETS {
            let (document, case) = document(preset);
            assert_eq!(document.case().unwrap(), case, "{}", document.text());
            let again = Document::resolve("case.toml", &document.text(), Path::new("")).unwrap();
            assert_eq!(again.text(), document.text());
        }
    }

    #[test]
    fn every_key_reaches_the_case() {
        for preset in PRESETS {
            let (document, before) = document(preset);
            let keys = document.keys();
            for key in &keys {
                let mut varied = document.clone();
                varied.set(key, 1.25).unwrap();
                assert_ne!(varied.text(), document.text(), "{key}");
            }
            for absent in ["finger.front.sagitta_mm", "finger.back.stiffness_factor", "finger.material.max_strain"] {
                assert!(keys.iter().any(|key| key == absent), "{absent}");
            }
            let mut varied = document.clone();
            varied.set("object.centre_mm.1", 50.0).unwrap();
            varied.set("object.centre_mm[0]", 42.0).unwrap();
            varied.set("finger.material.youngs_modulus_pa", 3e7).unwrap();
            varied.set("finger.back.stiffness_factor", 0.5).unwrap();
            // Welded ribs have no hinges.
            let is_rigid = before.finger.design.lamellae.ribs().is_none();
            if is_rigid {
                varied.set("finger.hinge.length_mm", 1.75).unwrap();
            }
            if before.finger.has_motor {
                varied.set_angles(&[7.0]);
            }
            let case = varied.case().unwrap();
            assert_eq!(case.finger.design.material.youngs_modulus, 30.0);
            assert_eq!(case.finger.design.back.stiffness_factor, 0.5);
            assert!(!is_rigid || case.finger.design.hinge.length.iter().all(|&length| length == 1.75));
            assert_eq!(case.path.places, if before.finger.has_motor { &[7.0][..] } else { &[1.0, 2.5] });
            assert!(matches!(case.object, model_core::object::ObjectDesign::Circle { centre: [42.0, 50.0], .. }));
            assert!(varied.text().contains("radius_mm = 40 # of a bottle"), "{}", varied.text());
        }
    }

    #[test]
    fn an_unknown_key_names_its_neighbours() {
        let (document, _) = document("fea-80");
        for (key, near) in [
            ("object.radius", "object.radius_mm"),
            ("radius_mm", "object.radius_mm"),
            ("finger.frnt.thickness_mm", "finger.front.thickness_mm"),
            ("youngs_modulus_pa", "finger.material.youngs_modulus_pa"),
            ("object.centre_mm", "object.centre_mm.0"),
            ("object.centre_mm.2", "object.centre_mm.1"),
        ] {
            let message = document.need(key).unwrap_err().to_string();
            assert!(message.contains(&format!("\"{key}\"")) && message.contains(near), "{message}");
        }
        assert!(document.need("finger.name").is_err() && document.need("motion.motor_angles_deg.0").is_err());
    }

    #[test]
    fn a_finger_that_is_written_is_read_again() {
        let folder = tempfile::tempdir().unwrap();
        for name in PRESETS {
            let (mut document, _) = document(name);
            let before = document.finger_text(&[]);
            document.set_finger(&preset(name).unwrap().unwrap());
            // Nothing differs, so nothing is touched: not a digit, not a comment.
            assert_eq!(document.finger_text(&[]), before);
            let mut finger = preset(name).unwrap().unwrap();
            finger.name = "a \"name\" with = and #".to_owned();
            finger.max_strain = Some(0.3);
            finger.prony = vec![[0.1, 5.0], [0.2, 60.0]];
            finger.design.width.knots.push([50.0, 17.5]).unwrap();
            match finger.design.back.via.first_mut() {
                Some(point) => point[0] += 0.5,
                None => finger.design.back.sagitta = 0.5,
            }
            // Of such beams the faces meet elsewhere: where the tip begins is written as a number.
            finger.is_tip_auto = false;
            document.set_finger(&finger);
            let text = document.finger_text(&["remark".to_owned()]);
            assert!(text.starts_with("# remark\n# "), "{text}");
            let modulus = preset_text(name).unwrap().lines().find(|line| line.starts_with("youngs_modulus_pa = "));
            assert!(text.contains(modulus.unwrap()), "{text}");
            let file = folder.path().join("finger.toml");
            std::fs::write(&file, text).unwrap();
            assert_eq!(read_finger(&file).unwrap(), finger, "{name}");
        }
    }

    #[test]
    fn a_finger_written_in_any_form_is_written_out() {
        let inline = "finger = { width_mm = 28, material = { youngs_modulus_pa = 2.13e11, poissons_ratio = 0.3 }, \
            front = { base_mm = [0, 0], tip_mm = [0, 150], thickness_mm = [[0, 0.2], [50, 0.3]] }, \
            back = { base_mm = [-73.24, 0], tip_mm = [0, 150], thickness_mm = 0.2 }, motor.axis_mm = [0, 0] }\n";
        let text = format!("{inline}{REST}");
        let mut document = Document::resolve("case.toml", &text, Path::new("")).unwrap();
        let mut finger = document.case().unwrap().finger;
        finger.design.rigid_above = Some(140.0);
        finger.design.front.thickness.knots[1][1] = 0.4;
        document.set_finger(&finger);
        assert_eq!(document.case().unwrap().finger, finger);
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("finger.toml");
        std::fs::write(&file, document.finger_text(&[])).unwrap();
        assert_eq!(read_finger(&file).unwrap(), finger);
    }
}
