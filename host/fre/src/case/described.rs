//! A finger that is to be drawn, which need not be one that can be computed.

use std::path::{Path, PathBuf};

use super::error::CaseError;
use super::finger;
use super::keys::FingerTable;
use super::preset::{no_such_preset, preset_text};
use super::read::Case;
use super::source::{Source, Table};

/// A finger that is to be drawn, with the file that it was found in, which is read once: what comes through a pipe is gone then.
pub struct Described {
    /// Its keys, with those that are not computed yet.
    pub keys: FingerTable,
    source: Source,
    folder: Option<PathBuf>,
    is_case: bool,
}

impl Described {
    /// Of a finger file, of the finger in a case, or of `preset:NAME`.
    ///
    /// # Errors
    /// The first thing in it that is not a key, or not a value of its key. Whether the values fit together is left to who uses them.
    pub fn read(path: &Path) -> Result<Self, CaseError> {
        let (source, name) = named_source(path)?;
        let keys = describe(&source, &name, path.parent(), true)?;
        let tree = source.parse()?;
        let root = Table::root(&source, tree.get_ref());
        let is_case = ["object", "motion"].into_iter().any(|key| root.has(key));
        drop(tree);
        Ok(Self { keys, source, folder: path.parent().map(Path::to_owned), is_case })
    }

    /// The case around it; none of a file with neither an object nor a motion.
    ///
    /// # Errors
    /// The first thing in it that cannot be used.
    pub fn case(&self) -> Result<Option<Case>, CaseError> {
        self.is_case.then(|| Case::from_source(&self.source, self.folder.as_deref())).transpose()
    }
}

/// The keys of a finger that is to be drawn.
///
/// # Errors
/// As [`Described::read`].
pub fn describe_finger(path: &Path) -> Result<FingerTable, CaseError> {
    Ok(Described::read(path)?.keys)
}

/// A file, or the text of `preset:NAME`, and what its finger is called unless it says so.
fn named_source(path: &Path) -> Result<(Source, String), CaseError> {
    if let Some(name) = path.to_str().and_then(|word| word.strip_prefix("preset:")) {
        let missing = || CaseError::Unreadable {
            file: path.display().to_string(),
            kind: std::io::ErrorKind::NotFound,
            reason: no_such_preset(),
        };
        let text = preset_text(name).ok_or_else(missing)?;
        return Ok((Source { name: path.display().to_string(), text: text.to_owned() }, name.to_owned()));
    }
    let name = path.file_stem().map_or_else(|| "finger".into(), |stem| stem.to_string_lossy().into_owned());
    Ok((Source::read(path)?, name))
}

/// The keys of a finger; `may_name`: a case may name another file, which names no third.
fn describe(source: &Source, name: &str, folder: Option<&Path>, may_name: bool) -> Result<FingerTable, CaseError> {
    let tree = source.parse()?;
    let root = Table::root(source, tree.get_ref());
    match root.get("finger") {
        None => finger::describe(&root, name),
        Some(value) if may_name && value.kind() == "string" => {
            let word = value.text(|| "a table".to_owned())?;
            let is_preset = word.starts_with("preset:");
            let path = if is_preset { word.into() } else { folder.unwrap_or(Path::new("")).join(word) };
            let (source, name) = named_source(&path)?;
            describe(&source, &name, path.parent(), false)
        }
        Some(value) => finger::describe(&value.table(|| "a table".to_owned())?, name),
    }
}
