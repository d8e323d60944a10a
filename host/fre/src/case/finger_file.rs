//! Files that hold a finger alone, and those that come with the program.

use std::path::{Path, PathBuf};

use super::error::CaseError;
use super::finger::{self, Finger};
use super::preset::preset_text;
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

/// The finger file that a case names, also one that cannot be computed; none for a finger of its own, a preset, and a file that is not TOML.
pub fn named_finger(path: &Path) -> Option<PathBuf> {
    let source = Source::read(path).ok()?;
    let tree = source.parse().ok()?;
    let finger = Table::root(&source, tree.get_ref()).get("finger").filter(|value| value.kind() == "string")?;
    let word = finger.text(|| "a table".to_owned()).ok().filter(|word| !word.starts_with("preset:"))?;
    Some(path.parent().unwrap_or(Path::new("")).join(word))
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
