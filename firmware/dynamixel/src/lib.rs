//! dynamixel
