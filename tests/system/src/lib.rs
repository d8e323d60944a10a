//! A gripper on the PC: its firmware in QEMU, its servo simulated, its link a unix socket.
//!
//! ```no_run
//! use system_tests::Machine;
//! let machine = Machine::boot(Machine::servo());
//! let link = machine.link();
//! link.set_finger(0, &system_tests::finger()).unwrap();
//! link.set_object(0, system_tests::OBJECT).unwrap();
//! ```
//!
//! The firmware's ELF is named by the environment variable `FRE_FIRMWARE_ELF`; `cargo xtask test` builds it and sets it.

mod agreement;
mod bench;
mod browser;
mod campaign;
mod cycles;
mod flash;
mod hour;
mod judge;
mod line;
mod machine;
mod shared_bus;
mod watch;

pub use agreement::Agreement;
pub use bench::{Bench, Meddling};
pub use browser::Browser;
pub use campaign::{Campaign, campaign};
pub use cycles::Cycles;
pub use flash::Flash;
pub use hour::{GEARED_MOUNT, Hour, an_hour, geared_servo, ready, set_up};
pub use judge::{Judge, is_sound};
pub use machine::{Machine, OBJECT, finger, firmware, load_of, load_on};
pub use shared_bus::SharedBus;
pub use test_bus::Tries;
pub use watch::Watch;
