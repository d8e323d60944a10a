//! Why the table cannot be made.

use model_core::discretise::DiscretiseError;

use super::series::PRESET;
use crate::case::CaseError;
use crate::draw;
use crate::files::FileError;

/// Why the table cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum Table1Error {
    /// The preset.
    #[error(transparent)]
    Case(#[from] CaseError),
    /// The watcher stopped it.
    #[error("stopped")]
    Stopped,
    /// The preset's discretisation.
    #[error("{PRESET}: {0}")]
    Discretise(#[from] DiscretiseError),
    /// A file cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// The picture cannot be written.
    #[error(transparent)]
    Draw(#[from] draw::DrawError),
}
