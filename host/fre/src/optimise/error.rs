//! Why a search has no result.

use super::problem::ProblemError;

/// Why a search has no result.
#[derive(Debug, thiserror::Error)]
pub enum OptimiseError {
    /// There is no problem.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// The file of finished starts cannot be used.
    #[error("{file}: {reason}")]
    Log {
        /// The file.
        file: String,
        /// Why.
        reason: String,
    },
    /// Whoever watched has stopped it.
    #[error("stopped")]
    Stopped,
}
