//! `sensor_msgs`.

use serde::{Deserialize, Serialize};

use super::Header;

/// `sensor_msgs/msg/JointState`: an empty list says that nothing is known of any joint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct JointState {
    /// When; the frame has no meaning.
    pub header: Header,
    /// The joints' names.
    pub name: Vec<String>,
    /// rad or m.
    pub position: Vec<f64>,
    /// rad/s or m/s.
    pub velocity: Vec<f64>,
    /// N·m or N.
    pub effort: Vec<f64>,
}
