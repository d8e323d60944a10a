//! reference-tests
