//! Discrete Cosserat-rod model of a Fin-Ray finger.
#![no_std]
#[cfg(test)]
#[macro_use]
extern crate std;

pub mod contact;
pub mod design;
pub mod discretise;
#[cfg(test)]
mod elastica;
pub mod equilibrium;
pub mod estimator;
pub mod ladder;
pub mod newton;
pub mod object;
#[cfg(test)]
mod random_designs;
pub mod real;
pub mod sensitivity;
pub mod size;
pub mod status;
