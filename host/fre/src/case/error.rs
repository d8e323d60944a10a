//! Why a case file is refused: file, line, key, value, what was wrong and what is allowed.

use std::fmt;

use crate::visible::{self, visible};

/// The longest piece of a file that a message repeats, characters.
const LONGEST_VALUE: usize = 60;

/// A case (or finger) file that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CaseError {
    /// The file cannot be opened or read.
    #[error("{file}: cannot be read: {reason}")]
    Unreadable {
        /// The file as it was named.
        file: String,
        /// What kept it from being read.
        kind: std::io::ErrorKind,
        /// The system's words.
        reason: String,
    },
    /// The file is far larger than any case.
    #[error("{file}: has {bytes} bytes; a case has at most {max}")]
    TooLarge {
        /// The file.
        file: String,
        /// Its size.
        bytes: u64,
        /// The largest allowed.
        max: u64,
    },
    /// The file is not text.
    #[error("{file}:{line}: is not text ({found}); a case is a TOML file in UTF-8")]
    NotText {
        /// The file.
        file: String,
        /// Line of the first byte at fault, from 1.
        line: usize,
        /// What it is instead.
        found: &'static str,
    },
    /// The file is not TOML.
    #[error("{file}:{line}: is not valid TOML: {reason}; the line is: {text}")]
    Syntax {
        /// The file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// What the parser expected.
        reason: String,
        /// The line as written in the file, shortened.
        text: String,
    },
    /// A key that means nothing.
    #[error("{place}: unknown key{}", .known)]
    UnknownKey {
        /// Where.
        place: Place,
        /// What is known there.
        known: Box<KnownKeys>,
    },
    /// A key that is needed.
    #[error("{place}: is missing; needed is {expected}")]
    Missing {
        /// Where it should be (the line of its table).
        place: Place,
        /// What it should hold.
        expected: String,
    },
    /// A value of another type.
    #[error("{place}: is {found}; needed is {expected}")]
    WrongType {
        /// Where.
        place: Place,
        /// What it is, with its article.
        found: &'static str,
        /// What it should hold.
        expected: String,
    },
    /// The case has friction, and what it is for computes without.
    #[error(
        "{}: {who} computes without friction; allowed is 0",
        .place.as_ref().map_or_else(|| format!("object.friction = {friction}"), ToString::to_string)
    )]
    Friction {
        /// Where; `None` for a case that is in no file.
        place: Option<Box<Place>>,
        /// What it is for.
        who: &'static str,
        /// The coefficient.
        friction: String,
    },
    /// The case's material has memory, and what it is for computes without.
    #[error(
        "{}: {who} computes without memory; allowed is an elastic material",
        .place.as_ref().map_or_else(|| "finger.material.prony".to_owned(), ToString::to_string)
    )]
    Memory {
        /// Where; `None` for a case that is in no file.
        place: Option<Box<Place>>,
        /// What it is for.
        who: &'static str,
    },
    /// A value of the right type that cannot be accepted.
    #[error("{place}: {reason}")]
    Refused {
        /// Where.
        place: Place,
        /// What is wrong and what is allowed.
        reason: String,
    },
}

/// The keys that are known where an unknown one is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KnownKeys {
    /// All of them.
    pub allowed: Vec<&'static str>,
    /// The one that the unknown key resembles.
    pub nearest: Option<&'static str>,
}

impl fmt::Display for KnownKeys {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(key) = self.nearest {
            write!(f, " (did you mean {key}?)")?;
        }
        write!(f, "; allowed here: {}", self.allowed.join(", "))
    }
}

/// A place in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Key with its tables, for example `finger.front.thickness_mm`.
    pub key: String,
    /// The value as written in the file, shortened; none for a missing key.
    pub value: Option<String>,
}

impl Place {
    /// A place whose value is repeated in messages, on one line and shortened.
    pub(super) fn new(file: &str, line: usize, key: &str, value: Option<&str>) -> Self {
        Self { file: file.to_owned(), line, key: visible(key), value: value.map(shortened) }
    }
}

/// A piece of a file on one line of bounded length.
pub(super) fn shortened(text: &str) -> String {
    // Not `split_whitespace`: blanks that no editor shows are to be seen.
    let words: Vec<&str> = text.split([' ', '\t', '\r', '\n']).filter(|word| !word.is_empty()).collect();
    visible::shortened(&words.join(" "), LONGEST_VALUE)
}

/// The key that an unknown one resembles: the same but for a unit, an ending or a few letters.
pub(super) fn nearest(key: &str, known: &[&'static str]) -> Option<&'static str> {
    let key = key.to_lowercase();
    let distance = |other: &str| {
        let begins = key.len() >= 3 && (other.starts_with(&key) || key.starts_with(other));
        if begins { 0 } else { strsim::osa_distance(&key, other) }
    };
    let best = known.iter().copied().min_by_key(|other| distance(other))?;
    (distance(best) <= 2.max(key.chars().count() / 3).min(key.chars().count() / 2)).then_some(best)
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}: {}", self.file, self.line, self.key)?;
        match &self.value {
            Some(value) => write!(f, " = {value}"),
            None => Ok(()),
        }
    }
}

impl CaseError {
    /// Line of the file, from 1, where there is one.
    pub fn line(&self) -> Option<usize> {
        match self {
            Self::Unreadable { .. } | Self::TooLarge { .. } => None,
            Self::Friction { place, .. } | Self::Memory { place, .. } => place.as_ref().map(|place| place.line),
            Self::NotText { line, .. } | Self::Syntax { line, .. } => Some(*line),
            Self::UnknownKey { place, .. }
            | Self::Missing { place, .. }
            | Self::WrongType { place, .. }
            | Self::Refused { place, .. } => Some(place.line),
        }
    }

    /// Key at fault with its tables, where there is one.
    pub fn key(&self) -> Option<&str> {
        match self {
            Self::Unreadable { .. } | Self::TooLarge { .. } | Self::NotText { .. } | Self::Syntax { .. } => None,
            Self::Friction { .. } => Some("object.friction"),
            Self::Memory { place, .. } => Some(place.as_ref().map_or("finger.material.prony", |place| &place.key)),
            Self::UnknownKey { place, .. }
            | Self::Missing { place, .. }
            | Self::WrongType { place, .. }
            | Self::Refused { place, .. } => Some(&place.key),
        }
    }
}

impl CaseError {
    /// The error without its place, for a text that nobody has written down line by line.
    pub fn without_place(&self) -> String {
        match self {
            Self::Friction { who, friction, .. } => {
                Self::Friction { place: None, who, friction: friction.clone() }.to_string()
            }
            Self::Memory { who, .. } => Self::Memory { place: None, who }.to_string(),
            Self::UnknownKey { place, .. }
            | Self::Missing { place, .. }
            | Self::WrongType { place, .. }
            | Self::Refused { place, .. } => {
                let words = self.to_string();
                words.strip_prefix(&format!("{}:{}: ", place.file, place.line)).unwrap_or(&words).to_owned()
            }
            other => other.to_string(),
        }
    }
}

/// A key that cannot be set.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum KeyError {
    /// No number of the case has this key.
    #[error("\"{key}\" is not a number of this case; the nearest are {}", .nearest.join(", "))]
    Unknown {
        /// The key.
        key: String,
        /// Keys like it.
        nearest: Vec<String>,
    },
}

impl KeyError {
    /// The key.
    pub fn key(&self) -> &str {
        match self {
            Self::Unknown { key, .. } => key,
        }
    }
}
