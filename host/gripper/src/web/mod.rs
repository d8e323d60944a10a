//! The live page: a gripper in a browser, through a small server on this PC.
//!
//! One thread listens to the gripper (`live`) and makes a frame for the eye 30 times a second, whatever the gripper's rate; the
//! log keeps every report. Frames go to any number of pages as server-sent events. What a page asks is a request to the
//! target, and the page shows the target's answer (`command`). The page is one document without anything from outside.

mod access;
mod command;
mod lead;
mod live;
mod object;
mod page;
mod server;
mod setup;

pub use access::Access;
pub use lead::Lead;
pub use live::Live;
pub use page::page;
pub use server::{WebError, open_browser, serve};
