//! Contact: samples on the front beam, the rows they make, and the law that decides which of them are equations.
//!
//! Nothing here knows a finger: a law sees a dense compliance, right-hand sides and rows.

pub(crate) mod coulomb;
pub(crate) mod frictionless;
mod row;
mod sample;

use crate::real::Real;
pub(crate) use row::{ContactState, Direction, Row, cell_of, own_rows};
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
    /// Normal part of the contact force (multiplier μ), N; the object is pushed along −normal.
    pub force: T,
    /// Tangential part τ that the object exerts on the finger, N, positive towards the finger's tip; 0 without friction.
    pub tangential: T,
    /// How it moves along the object; none without friction.
    pub slip: Option<SlipState>,
}

impl<T: Real> Contact<T> {
    /// Force on the object, finger frame, N.
    pub fn on_object(&self) -> [T; 2] {
        let [x, y] = self.normal;
        [-(self.force * x + self.tangential * y), -(self.force * y - self.tangential * x)]
    }
}

/// How a touching sample moves along the object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SlipState {
    /// It does not.
    Stick,
    /// It slips, and the object pulls the finger towards its tip.
    Up,
    /// It slips, and the object pulls the finger towards its base.
    Down,
}
