//! What the tests of the Dynamixel bus have in common.

mod python;

pub use python::python;
