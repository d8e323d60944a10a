//! Why a recording cannot be written or read.

use std::io;
use std::path::PathBuf;

use fre::files::FileError;

/// Why a recording cannot be written or read.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The file.
    #[error("{}: {source}", path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// The system's words.
        source: io::Error,
    },
    /// The file must not be written.
    #[error(transparent)]
    Files(#[from] FileError),
    /// The file is not MCAP.
    #[error("{}: {why}", path.display())]
    Format {
        /// Which.
        path: PathBuf,
        /// What is wrong with it.
        why: String,
    },
    /// A message is not what its topic carries.
    #[error("{}: a message on {topic} cannot be read ({why}): was it written by another version of fre?", path.display())]
    Message {
        /// Which file.
        path: PathBuf,
        /// Which topic.
        topic: String,
        /// What is wrong.
        why: String,
    },
}
