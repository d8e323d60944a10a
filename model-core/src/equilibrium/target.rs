//! Where a call of the follower goes, and how much time passes on the way.

/// A coordinate, and the time in which the motion comes there.
///
/// Time passes evenly along the way. It matters where something remembers: a follower of a finger without memory gives the same at any speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// Coordinate of the motion, rad or mm.
    pub coordinate: f64,
    /// Time since the last call, s, not negative; 0 for a jump. The time of calls that did not get there is added.
    pub time_step_s: f64,
}

impl Target {
    /// A coordinate and a time can be followed to.
    pub(super) fn is_valid(self) -> bool {
        self.coordinate.is_finite() && self.time_step_s.is_finite() && self.time_step_s >= 0.0
    }
}

/// A coordinate that is reached at once.
impl From<f64> for Target {
    fn from(coordinate: f64) -> Self {
        Self { coordinate, time_step_s: 0.0 }
    }
}
