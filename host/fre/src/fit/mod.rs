//! Measurements and what is fitted to them.

pub mod calibrate;
pub mod measured;
#[cfg(feature = "outline")]
pub mod outline;
