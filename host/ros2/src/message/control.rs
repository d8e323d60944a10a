//! `control_msgs`.

use serde::{Deserialize, Serialize};

use super::Header;

/// `control_msgs/msg/InterfaceValue`: numbers with names.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)]
pub struct InterfaceValue {
    pub interface_names: Vec<String>,
    pub values: Vec<f64>,
}

/// `control_msgs/msg/DynamicJointState`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DynamicJointState {
    /// When; the frame has no meaning.
    pub header: Header,
    /// The joints' names.
    pub joint_names: Vec<String>,
    /// One per joint.
    pub interface_values: Vec<InterfaceValue>,
}
