//! Why a sweep cannot be done.

use crate::case::{CaseError, KeyError};
use crate::files::FileError;

/// Why a sweep cannot be done.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// The case cannot be used.
    #[error(transparent)]
    Case(Box<CaseError>),
    /// A file that must not be written.
    #[error(transparent)]
    Files(#[from] FileError),
    /// A point of the grid is not a case.
    #[error("at {point}: {reason}")]
    Point {
        /// Its keys with their values.
        point: String,
        /// The key at fault with its tables, where there is one.
        key: Option<String>,
        /// What is wrong and what is allowed.
        reason: String,
    },
    /// A key that cannot be varied.
    #[error("--vary: {0}")]
    Key(KeyError),
    /// The same key twice.
    #[error("--vary: {key} is given twice; allowed is once, with all its values")]
    Twice {
        /// The key.
        key: String,
    },
    /// A list and one of its entries.
    #[error("--vary: {part} is a part of {whole}, which is varied as well; allowed is one of them")]
    Within {
        /// The entry.
        part: String,
        /// The list.
        whole: String,
    },
    /// Values that cannot be read.
    #[error("--vary {text}: {reason}")]
    Vary {
        /// The option's value.
        text: String,
        /// What is wrong and what is allowed.
        reason: String,
    },
    /// Motor angles for a base that is translated.
    #[error("--angles: the case moves its base along a line; allowed are its own distances_mm")]
    Translating,
    /// More rows than anyone reads.
    #[error("the grid has {rows} rows; allowed are {max}")]
    TooMany {
        /// Rows.
        rows: u128,
        /// The most.
        max: usize,
    },
    /// A file cannot be read or written.
    #[error("{file}: {source}")]
    File {
        /// The file.
        file: String,
        /// The system's words.
        source: std::io::Error,
    },
    /// The output file belongs to something else.
    #[error("{file}: {reason}; give another --out, or remove the file to begin anew")]
    Foreign {
        /// The file.
        file: String,
        /// What it is instead.
        reason: String,
    },
    /// A file that cannot be merged with the others.
    #[error("{file}: {reason}")]
    Part {
        /// The file.
        file: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A row that no shard has.
    #[error(
        "row {row} is in none of the shards: one of them is not complete; the command that began it goes on with it"
    )]
    Incomplete {
        /// The row.
        row: usize,
    },
    /// Output that cannot be gone on with.
    #[error(
        "{file}: is not a regular file, which --out needs to continue in; without --out the rows go to standard output"
    )]
    NoFile {
        /// What is none.
        file: String,
    },
    /// All rows are in the file, in the order in which they were found.
    #[error("{file}: is complete, but its rows cannot be sorted: {source}")]
    Unsorted {
        /// The file.
        file: String,
        /// The system's words.
        source: std::io::Error,
    },
    /// Another process writes the same file.
    #[error("{file}: another sweep is writing this file")]
    Busy {
        /// The file.
        file: String,
    },
    /// The watcher stopped it; rows in a file stay there.
    #[error("stopped")]
    Stopped,
    /// The Parquet file cannot be written.
    #[cfg(feature = "parquet")]
    #[error(transparent)]
    Parquet(#[from] crate::parquet::ParquetError),
    /// No threads.
    #[error("--jobs: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}

impl From<CaseError> for SweepError {
    fn from(error: CaseError) -> Self {
        Self::Case(Box::new(error))
    }
}

impl From<KeyError> for SweepError {
    /// What is varied may be the resolution, too.
    fn from(mut error: KeyError) -> Self {
        let KeyError::Unknown { nearest, .. } = &mut error;
        nearest.push("elements".to_owned());
        Self::Key(error)
    }
}
