//! Tests that run on the microcontroller, in QEMU, each in a machine of its own.
//!
//! One module per part of the firmware. The runner (`cargo xtask test`, or `cargo xtask qemu-run ELF`) connects the board's two UARTs
//! to each other.

#![no_std]
#![cfg_attr(test, no_main)]

#[cfg(test)]
mod board;
#[cfg(test)]
mod codec;
#[cfg(test)]
mod guard;
#[cfg(test)]
mod half_duplex;
#[cfg(test)]
mod missed;
#[cfg(test)]
mod model;
#[cfg(test)]
mod sweep;
