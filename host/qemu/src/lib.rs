//! The gripper's virtual board: QEMU's machine `mps2-an500` (Cortex-M7) with semihosting, started, watched and ended in one place.
//!
//! ```no_run
//! use std::{process::Stdio, time::Duration};
//! use fre_qemu::{Machine, Pace, Sockets};
//! let sockets = Sockets::new()?;
//! let machine = Machine::new("gripper-mps2").pace(Pace::Counted { shift: 2 }).listening(&sockets);
//! let mut running = machine.boot(Stdio::null())?;
//! let link = running.until("link", Duration::from_secs(20), || {
//!     std::os::unix::net::UnixStream::connect(sockets.link())
//! })?;
//! # drop(link);
//! # Ok::<(), fre_qemu::QemuError>(())
//! ```
//!
//! The image's log (defmt frames) comes out on QEMU's standard output, by semihosting.

mod error;
mod heir;
mod machine;
mod memory;
mod running;
mod sockets;

pub use error::QemuError;
pub use machine::{BOARD, Machine, PROGRAM, Pace, Uart};
pub use running::Running;
pub use sockets::Sockets;
