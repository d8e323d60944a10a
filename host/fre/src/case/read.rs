//! A case, and how it is read.

use std::path::Path;

use model_core::object::ObjectDesign;

use super::error::CaseError;
use super::finger::Finger;
use super::finger_file::{preset, read_finger};
use super::keys::{self, CaseFile, FingerEntry};
use super::motion::Path as MotionPath;
use super::preset::no_such_preset;
use super::source::{Source, Table};
use super::written::Written;
use super::{check, finger, motion, object};

/// A case: what is computed.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// The finger.
    pub finger: Finger,
    /// The object, world frame.
    pub object: ObjectDesign,
    /// Coulomb's coefficient of friction between finger and object.
    pub friction: f64,
    /// The motion and the places along it that are asked for.
    pub path: MotionPath,
    /// Where the file has what some commands refuse.
    pub written: Written,
}

impl Case {
    /// Reads a case file.
    ///
    /// # Errors
    /// The first thing in it that cannot be used.
    pub fn read(path: &Path) -> Result<Self, CaseError> {
        Ok(Self::read_with_text(path)?.0)
    }

    /// The same, with the file's text: what comes through a pipe can be read once only.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn read_with_text(path: &Path) -> Result<(Self, String), CaseError> {
        let source = Source::read(path)?;
        Ok((Self::from_source(&source, path.parent())?, source.text))
    }

    /// Reads a case from a text; `name` stands for the file in messages. Finger files it names are looked for in the
    /// current folder.
    ///
    /// # Errors
    /// The first thing in it that cannot be used.
    pub fn parse(name: &str, text: &str) -> Result<Self, CaseError> {
        Self::from_source(&Source { name: name.to_owned(), text: text.to_owned() }, None)
    }

    /// The case, for a command that computes without friction.
    ///
    /// # Errors
    /// The case has friction.
    pub fn frictionless(self, who: &'static str) -> Result<Self, CaseError> {
        self.refuse_friction(who).map(|()| self)
    }

    /// The same for a case that is only looked at.
    ///
    /// # Errors
    /// As [`Self::frictionless`].
    pub fn refuse_friction(&self, who: &'static str) -> Result<(), CaseError> {
        if self.friction == 0.0 {
            Ok(())
        } else {
            let place = self.written.friction();
            Err(CaseError::Friction { place, who, friction: self.friction.to_string() })
        }
    }

    /// The case, for a command that computes without a material with memory.
    ///
    /// # Errors
    /// The finger's material has memory.
    pub fn elastic(self, who: &'static str) -> Result<Self, CaseError> {
        self.refuse_memory(who).map(|()| self)
    }

    /// The same for a case that is only looked at.
    ///
    /// # Errors
    /// As [`Self::elastic`].
    pub fn refuse_memory(&self, who: &'static str) -> Result<(), CaseError> {
        if self.finger.prony.is_empty() { Ok(()) } else { Err(CaseError::Memory { place: self.written.memory(), who }) }
    }

    pub(super) fn from_source(source: &Source, folder: Option<&Path>) -> Result<Self, CaseError> {
        let tree = source.parse()?;
        let root = Table::root(source, tree.get_ref());
        check::table(&root, keys::schema())?;
        let keys: CaseFile = root.read()?;
        let below = |key| root.child(key).unwrap_or_else(|| root.clone());
        let finger = match &keys.finger {
            FingerEntry::Named(word) => named_finger(&root, word, folder)?,
            FingerEntry::Table(keys) => finger::build(keys, &below("finger"), "finger")?,
        };
        let object = object::build(&keys.object, &below("object"))?;
        let path = motion::build(&keys.motion, &below("motion"), &finger)?;
        Ok(Self { finger, object, friction: keys.object.friction(), path, written: Written::of(&root) })
    }
}

/// The preset or finger file that a case names.
fn named_finger(root: &Table<'_>, word: &str, folder: Option<&Path>) -> Result<Finger, CaseError> {
    if let Some(name) = word.strip_prefix("preset:") {
        return preset(name).unwrap_or_else(|| Err(root.refuse("finger", no_such_preset())));
    }
    read_finger(&folder.unwrap_or(Path::new("")).join(word)).map_err(|error| without_finger(root, error))
}

/// The error of a case whose finger file has this one.
pub(super) fn without_finger(root: &Table<'_>, error: CaseError) -> CaseError {
    match error {
        CaseError::Unreadable { file, reason, .. } => {
            root.refuse("finger", format!("the finger file {file} cannot be read: {reason}"))
        }
        other => other,
    }
}
