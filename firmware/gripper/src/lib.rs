//! gripper
