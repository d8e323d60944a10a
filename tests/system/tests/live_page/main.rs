//! The live page in a real browser, on the firmware in QEMU.

mod card;
mod free;
mod frozen;
mod jaw;
mod one;
mod page;
mod several;
