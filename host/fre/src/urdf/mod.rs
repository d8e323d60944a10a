//! A finger, or a gripper of several, as URDF: links, joints and masses for simulators and rviz. Frames, names and signs are those of the
//! ROS 2 node.
//!
//! Every finger has three names: its link `finger_N_base` is the finger's world frame and does not move with the motor, `finger_N_joint`
//! is the motor's joint, and its link `finger_N` is the finger, which the joint moves.

mod gripper;
mod names;
mod solid;

pub use gripper::{EFFORT, Gripper, MOST_FINGERS, ROOT, SPEED, UrdfError};
pub use names::{base, finger, joint};
pub use solid::Solid;
