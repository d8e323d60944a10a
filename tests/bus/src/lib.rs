//! What tests that speak with other programs have in common.

mod cyclone;
mod elf;
mod left_out;
mod python;
mod tries;

pub use cyclone::Cyclone;
pub use elf::elf;
pub use left_out::{ALLOWED, Feature, left_out};
pub use python::{python, python_with};
pub use tries::Tries;
