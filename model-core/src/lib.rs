//! Discrete Cosserat-rod model of a Fin-Ray finger.
#![no_std]

pub mod design;
pub mod object;
pub mod size;
pub mod status;
mod real;
