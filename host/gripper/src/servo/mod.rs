//! The simulated servo: a Dynamixel, an XM430-W350-T unless another model is asked for, that turns a finger against an object.
//!
//! - [`Servo`] takes the bytes heard on a bus and gives the answers: no thread, no port, no clock of its own.
//! - [`Load`] is what the finger asks of it, from the model at full resolution.
//! - [`Hub`] is a bus: every party (a pseudo-terminal, sockets, servos) hears all others. [`Hub::servo`] gives a
//!   [`Handle`] that reports the truth about the servo and makes it fail on purpose.
//!
//! The protocol is `dynamixel`'s; here are the control table, the position profile and the physics.

mod config;
mod contact;
mod control;
mod device;
mod fault;
mod hub;
mod indirect;
mod load;
mod mode;
mod motor;
mod port;
mod profile;
mod registers;
mod rub;
mod surroundings;
mod table;
mod units;

pub use config::{Clock, Config, ConfigError, simulated};
pub use contact::{Contact, LoadError};
pub use control::Gains;
pub use device::{Answer, BOOT_US, Servo, Statistics, Truth};
pub use fault::Fault;
pub use hub::{Handle, Hub, Running};
pub use load::{Load, OnBranch};
pub use port::PortError;
pub use profile::{ACCELERATION_UNIT, Kind, Limits, Profile, SPEED_UNIT};
