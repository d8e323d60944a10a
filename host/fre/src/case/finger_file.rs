//! Files that hold a finger alone, and those that come with the program.

use std::path::{Path, PathBuf};

use super::error::CaseError;
use super::finger::{self, Finger};
use super::keys::FingerTable;
use super::preset::{PRESETS, preset_text};
use super::source::{Source, Table};

/// Reads a finger file: the keys of `[finger]` at the top, or under `[finger]` as in a case (whose object and motion
/// are then left aside).
///
/// # Errors
/// The first thing in it that cannot be used.
pub fn read_finger(path: &Path) -> Result<Finger, CaseError> {
    let name = path.file_stem().map_or_else(|| "finger".into(), |stem| stem.to_string_lossy().into_owned());
    finger_from_source(&Source::read(path)?, &name)
}

/// A finger that comes with the program; none for another name.
///
/// # Errors
/// As for a file; the texts inside the program are tested to have none.
pub fn preset(name: &str) -> Option<Result<Finger, CaseError>> {
    let text = preset_text(name)?.to_owned();
    Some(finger_from_source(&Source { name: format!("preset:{name}"), text }, name))
}

/// The keys of a finger that is to be drawn, with those that are not computed yet: of a finger file, of the finger in a case, or of
/// `preset:NAME`.
///
/// # Errors
/// The first thing in it that is not a key, or not a value of its key. Whether the values fit together is left to who uses them.
pub fn describe_finger(path: &Path) -> Result<FingerTable, CaseError> {
    describe(path, true)
}

/// Whether a file is a case, with an object or a motion, rather than a finger alone.
///
/// # Errors
/// The file cannot be read, or is not TOML.
pub fn is_case(path: &Path) -> Result<bool, CaseError> {
    let source = Source::read(path)?;
    let tree = source.parse()?;
    let root = Table::root(&source, tree.get_ref());
    Ok(["object", "motion"].into_iter().any(|key| root.has(key)))
}

/// The finger file that a case names, also one that cannot be computed; none for a finger of its own, a preset, and a file that is not TOML.
pub fn named_finger(path: &Path) -> Option<PathBuf> {
    let source = Source::read(path).ok()?;
    let tree = source.parse().ok()?;
    let finger = Table::root(&source, tree.get_ref()).get("finger").filter(|value| value.kind() == "string")?;
    let word = finger.text(|| "a table".to_owned()).ok().filter(|word| !word.starts_with("preset:"))?;
    Some(path.parent().unwrap_or(Path::new("")).join(word))
}

/// As [`describe_finger`]; `may_name`: a case may name another file, which names no third.
fn describe(path: &Path, may_name: bool) -> Result<FingerTable, CaseError> {
    let (source, name) = match path.to_str().and_then(|word| word.strip_prefix("preset:")) {
        Some(name) => {
            let text = preset_text(name).ok_or_else(|| CaseError::Unreadable {
                file: path.display().to_string(),
                reason: format!("there is no such preset; allowed is {}", PRESETS.join(", ")),
            })?;
            (Source { name: path.display().to_string(), text: text.to_owned() }, name.to_owned())
        }
        None => {
            let name = path.file_stem().map_or_else(|| "finger".into(), |stem| stem.to_string_lossy().into_owned());
            (Source::read(path)?, name)
        }
    };
    let tree = source.parse()?;
    let root = Table::root(&source, tree.get_ref());
    match root.get("finger") {
        None => finger::describe(&root, &name),
        Some(value) if may_name && value.kind() == "string" => {
            let word = value.text(|| "a table".to_owned())?;
            let is_preset = word.starts_with("preset:");
            let folder = path.parent().unwrap_or(Path::new(""));
            describe(&if is_preset { word.into() } else { folder.join(word) }, false)
        }
        Some(value) => finger::describe(&value.table(|| "a table".to_owned())?, &name),
    }
}

/// Reads a finger from a text; `name` is its own unless it has one.
///
/// # Errors
/// The first thing in it that cannot be used.
fn finger_from_source(source: &Source, name: &str) -> Result<Finger, CaseError> {
    let tree = source.parse()?;
    let root = Table::root(source, tree.get_ref());
    let Some(table) = root.get("finger") else { return finger::read(&root, name) };
    let known = ["finger", "object", "motion"];
    root.only(&known, || known.to_vec())?;
    finger::read(&table.table(|| "a table".to_owned())?, name)
}
