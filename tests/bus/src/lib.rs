//! What tests that speak with other programs have in common.

mod left_out;
mod python;

pub use left_out::{ALLOWED, Feature, left_out};
pub use python::{python, python_with};
