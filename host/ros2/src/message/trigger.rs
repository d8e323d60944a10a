//! `std_srvs/srv/Trigger`.

use serde::{Deserialize, Serialize};

/// A request without content. ROS 2 has no empty messages: one byte is sent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct TriggerRequest {
    /// Anything.
    pub structure_needs_at_least_one_member: u8,
}

/// What came of it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct TriggerResponse {
    /// It is done, or has begun.
    pub success: bool,
    /// For people.
    pub message: String,
}
