//! A gripper, a bus or a recording as a node of ROS 2, without a ROS installation.
//!
//! [`Telling`] turns what a source reports into messages; it needs no network. With the feature `dds` there is the node that sends them
//! and offers services and parameters. `docs/ros2.md` lists the topics.

mod certainty;
mod diagnostics;
mod finger;
mod joint;
mod marker;
pub mod message;
#[cfg(feature = "dds")]
mod node;
#[cfg(feature = "dds")]
mod options;
#[cfg(feature = "dds")]
mod parameters;
#[cfg(feature = "dds")]
mod run;
#[cfg(feature = "dds")]
mod server;
#[cfg(feature = "dds")]
mod services;
mod telling;
mod wrench;

pub use certainty::NAMES;
#[cfg(feature = "dds")]
pub use node::{Node, NodeError};
#[cfg(feature = "dds")]
pub use options::{Mapping, Options, Qos};
#[cfg(feature = "dds")]
pub use run::{RunError, linger, live, replay, wait_for_subscribers};
pub use telling::{Message, Telling};
pub use wrench::DESCRIPTION;
