//! Why a case file is refused: file, line, key, value, what was wrong and what is allowed.

use std::fmt;

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
    #[error("{file}:{line}: is not text (a byte that is not UTF-8); a case is a TOML file")]
    NotText {
        /// The file.
        file: String,
        /// Line of the first byte at fault, from 1.
        line: usize,
    },
    /// The file is not TOML.
    #[error("{file}:{line}: is not valid TOML: {reason}")]
    Syntax {
        /// The file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// What the parser expected.
        reason: String,
    },
    /// A key that means nothing.
    #[error("{place}: unknown key; allowed here: {}", list(.allowed))]
    UnknownKey {
        /// Where.
        place: Place,
        /// Keys that are known at this place.
        allowed: Vec<&'static str>,
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
    /// A value of the right type that cannot be accepted.
    #[error("{place}: {reason}")]
    Refused {
        /// Where.
        place: Place,
        /// What is wrong and what is allowed.
        reason: String,
    },
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
    /// The value as it stands in the file, shortened; none for a missing key.
    pub value: Option<String>,
}

impl Place {
    /// A place whose value is repeated in messages, on one line and shortened.
    pub(super) fn new(file: &str, line: usize, key: &str, value: Option<&str>) -> Self {
        let value = value.map(|text| {
            let line: String = text.split_whitespace().collect::<Vec<_>>().join(" ");
            if line.chars().count() <= LONGEST_VALUE {
                line
            } else {
                line.chars().take(LONGEST_VALUE).chain(['…']).collect()
            }
        });
        Self { file: file.to_owned(), line, key: visible(key), value: value.map(|value| visible(&value)) }
    }
}

/// A piece of a file on one line: control characters, which a quoted key may hold, are escaped.
pub(super) fn visible(text: &str) -> String {
    let letter = |letter: char| if letter.is_control() { letter.escape_default().to_string() } else { letter.into() };
    text.chars().map(letter).collect()
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
            Self::UnknownKey { place, .. }
            | Self::Missing { place, .. }
            | Self::WrongType { place, .. }
            | Self::Refused { place, .. } => Some(&place.key),
        }
    }
}

/// "a, b, c" for messages.
pub(super) fn list(words: &[&str]) -> String {
    words.join(", ")
}
