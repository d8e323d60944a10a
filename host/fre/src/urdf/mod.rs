//! A gripper as URDF: links, joints and the names that its description and the node of ROS 2 have in common.

mod names;

pub use names::{base, finger, joint};
