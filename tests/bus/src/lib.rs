//! What tests that speak with other programs have in common.

mod python;

pub use python::{python, python_with};
