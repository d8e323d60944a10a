//! Why the virtual board did not run.

use std::io;
use std::path::PathBuf;
use std::time::Duration;

/// Why the virtual board did not run, or not as long as it was needed.
#[derive(Debug, thiserror::Error)]
pub enum QemuError {
    /// The image is not a file.
    #[error("{} is not a file; `cargo xtask firmware mps2` builds it", .0.display())]
    NoImage(PathBuf),
    /// QEMU is not installed, or does not start.
    #[error("qemu-system-arm cannot be started ({0}); `cargo xtask setup` installs it")]
    NoQemu(#[source] io::Error),
    /// QEMU ended although nothing here had ended it.
    #[error("QEMU has ended by itself ({status}); it said:\n{words}")]
    Ended {
        /// Its exit status.
        status: String,
        /// What it wrote to standard error, shortened.
        words: String,
    },
    /// Something did not happen in time.
    #[error("no {what} within {waited:?}{hint}")]
    Timeout {
        /// What was waited for.
        what: &'static str,
        /// How long.
        waited: Duration,
        /// The last refusal and QEMU's own words, if there are any.
        hint: String,
    },
    /// A socket, file or process.
    #[error("the system gives no socket, file or process: {0}")]
    System(#[from] io::Error),
}
