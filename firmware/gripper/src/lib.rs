//! The gripper's program, for any board.
//!
//! Four tasks over one [`Shared`]:
//!
//! - [`serve`] asks the servos where they are, and writes their goals, at a fixed rate.
//! - [`control`] estimates the contact force from each answer, reports it and finds the next goals; it waits for the bus and for its
//!   clock, for nothing else.
//! - [`send`] writes reports, shapes, events and answers to the link. What the link cannot take in time is dropped and
//!   counted.
//! - [`answer`] hears the host's requests.
//!
//! That is the role of a master. As a tap or a device ([`messages::Role`]) the gripper leaves the servos to another master:
//! [`serve`] hears what that one reads of them, and answers it, and [`control`] estimates from what was heard.
//!
//! A gripper starts without finger and object: every estimate is `out-of-range` until the host has set both.
//!
//! A board brings a bus, a link, flash, a watchdog and clocks ([`Board`]) and runs the four as tasks: [`control`] in an
//! executor whose interrupt goes before the last two, [`serve`] in one whose interrupt goes before that, and behind those of the devices.
//!
//! [`tasks!`] writes them out for a board.
#![cfg_attr(not(test), no_std)]
#![cfg_attr(
    not(test),
    deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::unreachable)
)]

// Floating-point numbers are kept within bounds by `max` and `min`: `clamp` panics where the bounds are crossed or NaN.

/// Logs where the board has a log.
macro_rules! log {
    ($level:ident, $($words:tt)*) => {{
        #[cfg(feature = "defmt")]
        defmt::$level!($($words)*);
    }};
}

mod alive;
mod board;
mod bus;
mod control;
pub mod device_table;
mod ears;
mod estimation;
mod free;
mod hand;
mod last_words;
mod leadership;
mod link;
mod listening;
mod margin;
mod orders;
mod provoke;
mod quiet;
mod rate;
mod return_delay;
mod scan;
mod scheduler;
mod serving;
mod servo;
mod setup;
mod shared;
pub mod steps;
mod store;
mod tasks;
mod ticks;
mod unit;
mod write;

pub use board::{Board, Boot, BusPort, Watchdog};
pub use bus::Bus;
pub use control::control;
pub use last_words::LastWords;
pub use link::{answer, send};
pub use messages::{FINGERS, ResetCause};
pub use rate::period_us;
pub use scheduler::LINK_SHARE;
pub use serving::serve;
pub use shared::Shared;

/// Version of the program.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Its room: with friction where the board has memory for what that remembers, and for up to 16 ribs where it has memory for them.
#[cfg(not(any(feature = "friction", feature = "ribs")))]
type Room = model_core::size::Reduced;
#[cfg(all(feature = "friction", not(feature = "ribs")))]
type Room = model_core::size::Rubbing;
#[cfg(all(feature = "ribs", not(feature = "friction")))]
type Room = model_core::size::Ribs;
#[cfg(all(feature = "ribs", feature = "friction"))]
type Room = model_core::size::RubbingRibs;

/// The model that runs on the microcontroller.
pub type Model = model_core::estimator::Estimator<f32, Room>;
