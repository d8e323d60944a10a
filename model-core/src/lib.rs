//! Discrete Cosserat-rod model of a Fin-Ray finger.
#![no_std]
#[cfg(feature = "trace")]
extern crate std;

pub mod contact;
pub mod design;
pub mod discretise;
pub mod equilibrium;
pub mod estimator;
pub mod ladder;
pub mod newton;
pub mod object;
pub mod real;
pub mod size;
pub mod status;
