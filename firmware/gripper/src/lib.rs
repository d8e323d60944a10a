//! The gripper's program, for any board.
//!
//! Three tasks over one [`Shared`]:
//!
//! - [`control`] leads the servo, reads its position at a fixed rate, estimates the contact force and reports every
//!   tick; it waits for the bus and for its clock, for nothing else.
//! - [`send`] writes reports, shapes, events and answers to the link. What the link cannot take in time is dropped and
//!   counted.
//! - [`answer`] hears the host's requests.
//!
//! A gripper starts without finger and object: every estimate is `out-of-range` until the host has set both.
//!
//! A board brings a bus, a link and a clock ([`Board`]) and runs the three as tasks of its executor:
//!
//! ```ignore
//! static SHARED: Shared = Shared::new();
//! static MODEL: ConstStaticCell<Model> = ConstStaticCell::new(Model::EMPTY);
//!
//! #[embassy_executor::task]
//! async fn control(model: &'static mut Model, bus: Bus) -> ! {
//!     gripper::control::<MyBoard>(&SHARED, model, bus).await
//! }
//! ```
#![cfg_attr(not(test), no_std)]
#![cfg_attr(
    not(test),
    deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::unreachable)
)]

/// Logs where the board has a log.
macro_rules! log {
    ($level:ident, $($words:tt)*) => {{
        #[cfg(feature = "defmt")]
        defmt::$level!($($words)*);
    }};
}

mod board;
mod calibration;
mod control;
mod health;
mod link;
mod motion;
mod rate;
mod servo;
mod shape;
mod shared;

pub use board::{Board, BusPort};
pub use calibration::Calibration;
pub use control::control;
pub use health::Health;
pub use link::{answer, send};
pub use motion::Motion;
pub use rate::{Meter, period_us};
pub use shared::Shared;

/// The model that runs on the microcontroller.
pub type Model = model_core::estimator::Estimator<f32, model_core::size::Reduced>;
