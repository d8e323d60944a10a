//! Boards from the PC's side: what is flashed ([`Image`]), how its log is read (feature `log`), and the two ways to it: a debug
//! probe (feature `probe`) or QEMU (`emulated`).

mod board;
#[cfg(feature = "log")]
pub mod emulated;
mod error;
mod image;
#[cfg(feature = "probe")]
pub mod session;

pub use board::Board;
pub use error::ProbeError;
pub use image::{Image, Piece};
