//! Why there is no comparison.

use model_core::discretise::DiscretiseError;

use crate::fea::FeaError;

/// Why there is no comparison.
#[derive(Debug, thiserror::Error)]
pub enum CompareError {
    /// The finger cannot be discretised as asked.
    #[error(transparent)]
    Discretise(#[from] DiscretiseError),
    /// The case cannot be meshed.
    #[error(transparent)]
    Mesh(FeaError),
    /// CalculiX did not give a result.
    #[error(transparent)]
    Fea(FeaError),
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
