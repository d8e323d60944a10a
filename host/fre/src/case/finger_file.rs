//! Files that hold a finger alone.

use std::path::Path;

use super::error::CaseError;
use super::finger::{self, Finger};
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

/// Reads a finger from a text; `name` is its own unless it has one.
///
/// # Errors
/// The first thing in it that cannot be used.
pub(super) fn finger_from_source(source: &Source, name: &str) -> Result<Finger, CaseError> {
    let tree = source.parse()?;
    let root = Table::root(source, tree.get_ref());
    let Some(table) = root.get("finger") else { return finger::read(&root, name) };
    let known = ["finger", "object", "motion"];
    root.only(&known, &known)?;
    finger::read(&table.table("a table")?, name)
}
