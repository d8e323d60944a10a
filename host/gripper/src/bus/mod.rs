//! Servos on a bus of this PC, by a USB adapter (U2D2, USB2Dynamixel) or a socket: the gripper's estimator runs here.
//!
//! The servos are only read: no goal and no setting is written, so that the bus may be shared in time with whatever moves them. The
//! one exception is [`Order::Relax`](crate::source::Order::Relax), which switches their torque off.

mod address;
mod error;
mod fingers;
mod handle;
mod options;
mod port;
mod search;
mod shared;
mod ticks;

pub use address::BusAddress;
pub use error::BusError;
pub use handle::Bus;
pub use options::BusOptions;
