//! Where a case's file has what only some commands compute: friction, and a material with memory.

use super::error::Place;
use super::source::Table;

/// Where a case's file has friction and memory; nothing for a case that is in no file. Equal cases may come from different files: it does
/// not count for their equality.
#[derive(Clone, Debug, Default)]
pub struct Written {
    friction: Option<Place>,
    memory: Option<Place>,
}

impl PartialEq for Written {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Written {
    /// Looks them up in a case. The memory of a finger that has its own file is where the case names it.
    pub(super) fn of(root: &Table<'_>) -> Self {
        let place = |key: &str| root.find(key).map(|value| value.place());
        Self { friction: place("object.friction"), memory: place("finger.material.prony").or_else(|| place("finger")) }
    }

    /// Forgets what is about to be changed.
    pub(super) fn forget(&mut self, key: &str) {
        if key.starts_with("object.friction") {
            self.friction = None;
        } else if key.starts_with("finger.material.prony") {
            self.memory = None;
        }
    }

    /// Where friction is.
    pub(super) fn friction(&self) -> Option<Box<Place>> {
        self.friction.clone().map(Box::new)
    }

    /// Where the material's memory is.
    pub(super) fn memory(&self) -> Option<Box<Place>> {
        self.memory.clone().map(Box::new)
    }
}
