//! The link to a gripper: its estimates as a stream, its requests as functions.
//!
//! ```no_run
//! use fre_gripper::link::{Address, Link, Told};
//! use messages::Which;
//! # fn main() -> Result<(), fre_gripper::link::LinkError> {
//! let link = Link::open(&"unix:link".parse::<Address>()?)?;
//! let told = link.listen();
//! link.close(Which::All, 0.19, None)?;
//! for told in told {
//!     if let Told::Report(report) = told {
//!         println!("{:.2} N {}", report.estimate.force_magnitude(), report.estimate.status);
//!     }
//! }
//! # Ok(())
//! # }
//! ```
//!
//! A gripper's port has one user. [`Lasting`], the link of a program that shows a gripper, lets others in: [`Link::open`] finds it.
//!
//! One thread reads. A listener that does not keep up loses the newest messages, which is counted; the gripper and other
//! listeners do not notice. A damaged frame costs itself only.

mod address;
mod client;
mod error;
mod keys;
mod lasting;
mod place;
mod port;
mod ports;
mod requests;
mod share;
#[cfg(test)]
mod tests;

pub use address::{Address, BadAddress};
pub use client::Link;
pub use error::LinkError;
pub(crate) use keys::whole;
pub use keys::{KeyError, pairs, set};
pub use lasting::{Ends, Lasting};
pub(crate) use port::Port;
pub use ports::ports;

pub use crate::source::{SIGN_OF_LIFE, Told, alive};
