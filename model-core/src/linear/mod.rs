//! Linear algebra on slices. It knows matrices, not fingers.

pub(crate) mod banded;
pub(crate) mod cholesky;
pub(crate) mod lu;
pub(crate) mod pivot;
pub(crate) mod symmetric;
