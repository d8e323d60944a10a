//! New images by a board's own boot loader, over its own port: no debug probe is needed.
//!
//! ROBOTIS' OpenCR has one. Its messages are MAVLink 1 with a dialect of their own; what is here follows ROBOTIS' sources (repository
//! `ROBOTIS-GIT/OpenCR`, `arduino/opencr_develop`: `opencr_bootloader/src/cmd.c`, `opencr_ld_shell`). It was tried on a simulated loader only.

mod error;
mod frame;
mod message;
mod session;
mod update;

pub use error::LoaderError;
pub use frame::{Decoder, Frame, crc};
pub use message::{Acknowledgement, Kind, checksum};
pub use update::{Patience, update};
