//! A gripper and its servos on a PC: the link to the gripper, the servos' bus, simulated servos, recordings, the terminal and the
//! live page.

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
pub mod terminal;
#[cfg(feature = "web")]
pub mod web;
