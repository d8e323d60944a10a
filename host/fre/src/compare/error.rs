//! Why there is no comparison.

use model_core::discretise::DiscretiseError;

use crate::case::CaseError;
use crate::fea::FeaError;
use crate::study::run::Unsolved;

/// Why there is no comparison.
#[derive(Debug, thiserror::Error)]
pub enum CompareError {
    /// The file has neither a force nor a point.
    #[error(
        "{file}: has motor torques alone, which `fre calibrate` reads; needed are forces (force_n, or fx_n and fy_n) or points (front_x_mm and front_y_mm)"
    )]
    TorquesAlone {
        /// The file.
        file: String,
    },
    /// The finger cannot be discretised as asked.
    #[error(transparent)]
    Discretise(#[from] DiscretiseError),
    /// The watcher stopped it.
    #[error("stopped")]
    Stopped,
    /// The case cannot be meshed.
    #[error(transparent)]
    Mesh(FeaError),
    /// CalculiX did not give a result.
    #[error(transparent)]
    Fea(FeaError),
    /// The case's material has memory.
    #[error(transparent)]
    Memory(CaseError),
    /// The measurements have another motion than the case.
    #[error("{file}: has {found}; the case's motion needs {needed}")]
    Coordinate {
        /// The file.
        file: String,
        /// Its column.
        found: &'static str,
        /// The column that the case's motion needs.
        needed: &'static str,
    },
}

impl From<Unsolved<()>> for CompareError {
    fn from(error: Unsolved<()>) -> Self {
        match error {
            Unsolved::Discretise(error) => Self::Discretise(error),
            Unsolved::Stopped(()) => Self::Stopped,
        }
    }
}
