//! The main job, shown: the firmware in QEMU estimates the contact force from the angle of a simulated servo, beside the
//! full-resolution model on this PC.
//!
//! [`run()`] boots the gripper ([`Machine`]), leads its finger ([`Lead`]) to an object and back, hands every estimate's
//! angle to the references ([`Reference`]), shows both while they come ([`Live`]), and ends with a table ([`Summary`])
//! and a folder with pictures and data (the report).

mod boot;
mod error;
mod heard;
mod lead;
mod live;
mod log;
mod machine;
#[cfg(feature = "web")]
mod page;
mod pictures;
mod reference;
mod report;
mod run;
mod sample;
mod seen;
mod summary;
mod task;

pub use error::DemoError;
pub use fre_qemu::Pace;
pub use lead::{CLOSED_DEG, Lead, OPEN_DEG, Order};
pub use live::Live;
pub use machine::Machine;
#[cfg(feature = "web")]
pub use page::live;
pub use reference::{Answer, Followed, Reference};
pub use report::{FILES, write as write_report};
pub use run::{Options, run};
pub use sample::{FLOOR_N, REFERENCES, Sample, Way};
pub use seen::Seen;
pub use summary::{Difference, Summary};
pub use task::LOG;
