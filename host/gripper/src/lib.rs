//! A gripper and its servos on a PC: the link to the gripper, the servos' bus, simulated servos, recordings, views in
//! the terminal and on a page.

pub mod bus;
pub mod calibrated;
pub mod commission;
pub mod datasheet;
pub mod demo;
pub mod estimator;
pub mod identify;
pub mod link;
pub mod loader;
pub mod probe;
pub mod record;
pub mod servo;
pub mod shown;
pub mod sim;
pub mod source;
#[cfg(feature = "terminal")]
pub mod terminal;
#[cfg(feature = "web")]
pub mod web;
