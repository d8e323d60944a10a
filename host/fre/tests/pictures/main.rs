//! Pictures are well-formed, show what they should, and survive odd input.

mod chart;
mod file;
mod finger;
mod reading;
