//! The resolved case: its document with the finger written out, whose numbers can be changed key by key.

use std::fmt::Write as _;
use std::path::Path;

use toml::de::{DeTable, DeValue};

use super::SweepError;
use crate::case::{Case, CaseError};

/// How many keys a message suggests.
const SUGGESTIONS: usize = 4;

/// Numbers that a case may leave out, with the table in which they stand.
const OPTIONAL: [(&str, &str); 6] = [
    ("finger.front", "stiffness_factor"),
    ("finger.back", "stiffness_factor"),
    ("finger.front", "sagitta_mm"),
    ("finger.back", "sagitta_mm"),
    ("finger.tip", "rigid_above_mm"),
    ("finger.material", "max_strain"),
];

/// Keys whose array (a taper, or one number per lamella) may be replaced by one number.
const UNIFORM: [&str; 3] = ["width_mm", "thickness_mm", "length_mm"];

/// A value of a document. Numbers keep the digits of their file.
#[derive(Clone, Debug, PartialEq)]
enum Node {
    /// A number, as digits.
    Number(String),
    /// Anything else that stands alone, as TOML.
    Word(String),
    /// A list.
    List(Vec<Node>),
    /// Keys with their values, in the file's order of keys.
    Table(Vec<(String, Node)>),
}

/// A case in which every number can be set by its dotted key, such as `object.centre_mm.1` or
/// `finger.front.thickness_mm`.
#[derive(Clone, Debug, PartialEq)]
pub struct Document {
    name: String,
    root: Node,
}

impl Document {
    /// Reads a case file; a preset or a finger file that it names is written out.
    ///
    /// # Errors
    /// The first thing in the case that cannot be used.
    pub fn read(path: &Path) -> Result<Self, SweepError> {
        // The case's own reader says best what is wrong, with line and key.
        let (_, text) = Case::read_with_text(path)?;
        Self::resolve(&path.display().to_string(), &text, path.parent().unwrap_or(Path::new("")))
    }

    /// Reads a case from a text; finger files it names are looked for in a folder.
    ///
    /// # Errors
    /// The text is no TOML, or its finger cannot be found.
    pub fn resolve(name: &str, text: &str, folder: &Path) -> Result<Self, SweepError> {
        let mut root = parse(name, text)?;
        if let Some(word) = finger_file(text) {
            let word = word.as_str();
            let (from, text) = match word.strip_prefix("preset:") {
                Some(preset) => (preset.to_owned(), preset_text(preset).unwrap_or_default().to_owned()),
                None => {
                    let file = folder.join(word);
                    let stem = file.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
                    (stem, read(&file)?)
                }
            };
            let Node::Table(mut entries) = parse(word, &text)? else { return Ok(Self { name: name.to_owned(), root }) };
            if let Some((_, Node::Table(inner))) = entries.iter().find(|(key, _)| key == "finger") {
                entries = inner.clone();
            }
            if !entries.iter().any(|(key, _)| key == "name") {
                entries.push(("name".to_owned(), Node::Word(quoted(&from))));
            }
            put(&mut root, "finger", Node::Table(entries));
        }
        Ok(Self { name: name.to_owned(), root })
    }

    /// The document as TOML: one line, the same for the same case.
    pub fn text(&self) -> String {
        let mut out = String::new();
        if let Node::Table(entries) = &self.root {
            for (key, node) in entries {
                let _ = write!(out, "{} = ", bare_or_quoted(key));
                write(&mut out, node);
                out.push('\n');
            }
        }
        out
    }

    /// The case that it describes.
    ///
    /// # Errors
    /// The first thing in it that cannot be used.
    pub fn case(&self) -> Result<Case, CaseError> {
        Case::parse(&self.name, &self.text())
    }

    /// Keys of the numbers that can be varied, sorted. The places of the motion are not among them.
    pub fn keys(&self) -> Vec<String> {
        let mut keys = Vec::new();
        collect(&self.root, String::new(), &mut keys);
        keys.retain(|key| !key.starts_with("motion.motor_angles_deg") && !key.starts_with("motion.distances_mm"));
        let absent = OPTIONAL.iter().map(|(table, key)| format!("{table}.{key}"));
        let ellipse = keys.iter().any(|key| key.starts_with("object.semi_axes_mm"));
        let absent = absent.chain(ellipse.then(|| "object.angle_deg".to_owned()));
        keys.extend(absent.filter(|key| !keys.contains(key)).collect::<Vec<_>>());
        keys.sort();
        keys
    }

    /// Fails for a key that is no number of this case; the error names those that are nearest.
    ///
    /// # Errors
    /// An unknown key.
    pub fn need(&self, key: &str) -> Result<(), SweepError> {
        let mut keys = self.keys();
        if keys.iter().any(|known| known == key) {
            return Ok(());
        }
        // A key is often given by its last word: what ends alike comes first.
        let end = |key: &str| key.split('.').rfind(|part| part.parse::<usize>().is_err()).unwrap_or(key).to_owned();
        keys.sort_by_cached_key(|known| {
            strsim::levenshtein(known, key).min(1 + strsim::levenshtein(&end(known), &end(key)))
        });
        keys.truncate(SUGGESTIONS);
        Err(SweepError::UnknownKey { key: key.to_owned(), nearest: keys })
    }

    /// Sets a number.
    ///
    /// # Errors
    /// An unknown key.
    pub fn set(&mut self, key: &str, value: f64) -> Result<(), SweepError> {
        self.need(key)?;
        self.set_known(key, value);
        Ok(())
    }

    /// Sets a number whose key [`Self::need`] has found.
    pub(super) fn set_known(&mut self, key: &str, value: f64) {
        set(&mut self.root, key, Node::Number(number(value)));
    }

    /// Sets the motor angles, degrees.
    pub fn set_angles(&mut self, angles_deg: &[f64]) {
        let list = Node::List(angles_deg.iter().map(|&angle| Node::Number(number(angle))).collect());
        set(&mut self.root, "motion.motor_angles_deg", list);
    }
}

/// The text of a finger that comes with the program.
fn preset_text(name: &str) -> Option<&'static str> {
    match name {
        "ladder-80" => Some(include_str!("../case/presets/ladder-80.toml")),
        "fea-80" => Some(include_str!("../case/presets/fea-80.toml")),
        "dhas-80" => Some(include_str!("../case/presets/dhas-80.toml")),
        _ => None,
    }
}

/// The preset or file that a case names as its finger.
fn finger_file(text: &str) -> Option<String> {
    let table = DeTable::parse(text).ok()?;
    match table.get_ref().get("finger")?.get_ref() {
        DeValue::String(word) => Some(word.to_string()),
        _ => None,
    }
}

fn read(path: &Path) -> Result<String, SweepError> {
    std::fs::read_to_string(path).map_err(|source| SweepError::File { file: path.display().to_string(), source })
}

fn parse(name: &str, text: &str) -> Result<Node, SweepError> {
    let table = DeTable::parse(text)
        .map_err(|error| SweepError::NotToml { file: name.to_owned(), reason: error.message().to_owned() })?;
    Ok(table_node(table.get_ref()))
}

fn table_node(table: &DeTable<'_>) -> Node {
    let mut entries: Vec<_> = table.iter().collect();
    entries.sort_by_key(|(key, _)| key.span().start);
    Node::Table(entries.into_iter().map(|(key, value)| (key.get_ref().to_string(), node(value.get_ref()))).collect())
}

fn node(value: &DeValue<'_>) -> Node {
    match value {
        DeValue::Integer(integer) if integer.radix() == 10 => Node::Number(integer.as_str().to_owned()),
        DeValue::Integer(integer) => Node::Number(integer.to_string()),
        DeValue::Float(float) => Node::Number(float.as_str().to_owned()),
        DeValue::String(text) => Node::Word(quoted(text)),
        DeValue::Boolean(value) => Node::Word(value.to_string()),
        DeValue::Datetime(value) => Node::Word(value.to_string()),
        DeValue::Array(array) => Node::List(array.iter().map(|item| node(item.get_ref())).collect()),
        DeValue::Table(table) => table_node(table),
    }
}

/// A number as TOML reads it back, bit for bit.
fn number(value: f64) -> String {
    format!("{value:?}")
}

fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for letter in text.chars() {
        match letter {
            '"' | '\\' => out.extend(['\\', letter]),
            control if control.is_control() => {
                let _ = write!(out, "\\U{:08X}", u32::from(control));
            }
            other => out.push(other),
        }
    }
    out.push('"');
    out
}

fn bare_or_quoted(key: &str) -> String {
    let bare = !key.is_empty() && key.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-');
    if bare { key.to_owned() } else { quoted(key) }
}

fn write(out: &mut String, node: &Node) {
    match node {
        Node::Number(text) | Node::Word(text) => out.push_str(text),
        Node::List(items) => {
            out.push('[');
            for (index, item) in items.iter().enumerate() {
                out.push_str(if index == 0 { "" } else { ", " });
                write(out, item);
            }
            out.push(']');
        }
        Node::Table(entries) => {
            out.push('{');
            for (index, (key, item)) in entries.iter().enumerate() {
                let _ = write!(out, "{}{} = ", if index == 0 { " " } else { ", " }, bare_or_quoted(key));
                write(out, item);
            }
            out.push_str(" }");
        }
    }
}

fn collect(node: &Node, path: String, keys: &mut Vec<String>) {
    let below = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
    match node {
        Node::Number(_) => keys.push(path),
        Node::Word(_) => {}
        Node::List(items) => {
            items.iter().enumerate().for_each(|(index, item)| collect(item, below(&index.to_string()), keys));
            if path.rsplit('.').next().is_some_and(|last| UNIFORM.contains(&last)) {
                keys.push(path);
            }
        }
        Node::Table(entries) => entries.iter().for_each(|(key, item)| collect(item, below(key), keys)),
    }
}

/// Sets the value at a dotted key; tables that are missing on the way are made.
fn set(node: &mut Node, path: &str, value: Node) {
    let (key, rest) = path.split_once('.').map_or((path, None), |(key, rest)| (key, Some(rest)));
    let Some(rest) = rest else { return put(node, key, value) };
    match node {
        Node::List(items) => {
            if let Some(item) = key.parse::<usize>().ok().and_then(|index| items.get_mut(index)) {
                set(item, rest, value);
            }
        }
        Node::Table(entries) => {
            if !entries.iter().any(|(name, _)| name == key) {
                entries.push((key.to_owned(), Node::Table(Vec::new())));
            }
            if let Some((_, item)) = entries.iter_mut().find(|(name, _)| name == key) {
                set(item, rest, value);
            }
        }
        Node::Number(_) | Node::Word(_) => {}
    }
}

fn put(node: &mut Node, key: &str, value: Node) {
    match node {
        Node::List(items) => {
            if let Some(item) = key.parse::<usize>().ok().and_then(|index| items.get_mut(index)) {
                *item = value;
            }
        }
        Node::Table(entries) => match entries.iter_mut().find(|(name, _)| name == key) {
            Some((_, item)) => *item = value,
            None => entries.push((key.to_owned(), value)),
        },
        Node::Number(_) | Node::Word(_) => {}
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::Document;
    use crate::case::{Case, PRESETS};

    const REST: &str = "[object]\nshape = \"circle\"\nradius_mm = 40\ncentre_mm = [41, 0x2d]\n\
        [motion]\nmotor_angles_deg = [1, 2.5]\n";

    fn document(preset: &str) -> (Document, Case) {
        let text = format!("finger = \"preset:{preset}\"\n{REST}");
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
            let (document, _) = document(preset);
            for key in document.keys() {
                let mut varied = document.clone();
                varied.set(&key, 1.25).unwrap();
                assert_ne!(varied.text(), document.text(), "{key}");
            }
            let mut varied = document.clone();
            varied.set("object.centre_mm.1", 50.0).unwrap();
            varied.set("finger.material.youngs_modulus_pa", 3e7).unwrap();
            varied.set("finger.back.stiffness_factor", 0.5).unwrap();
            varied.set("finger.hinge.length_mm", 1.75).unwrap();
            varied.set_angles(&[7.0]);
            let case = varied.case().unwrap();
            assert_eq!(case.finger.design.material.youngs_modulus, 30.0);
            assert_eq!(case.finger.design.back.stiffness_factor, 0.5);
            assert!(case.finger.design.hinge.length.iter().all(|&length| length == 1.75));
            assert_eq!(case.path.places, [7.0]);
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
}
