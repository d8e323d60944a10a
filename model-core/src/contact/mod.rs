//! Contact: samples on the front beam, the rows they make, and the law that decides which of them are equations.
//!
//! Nothing here knows a finger: a law sees a dense compliance, right-hand sides and rows.

pub(crate) mod frictionless;
mod row;
mod sample;

pub(crate) use row::{ContactState, Direction, Row};
pub use sample::Sample;
pub(crate) use sample::sample_gap;

/// A touching sample, as reported.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact<T> {
    /// Arc length from the front beam's base, mm.
    pub arc: T,
    /// Point of the beam's surface, finger frame, mm.
    pub position: [T; 2],
    /// Unit normal out of the object, towards the finger; finger frame.
    pub normal: [T; 2],
    /// Magnitude of the contact force (multiplier μ), N; the object is pushed along −normal.
    pub force: T,
}
