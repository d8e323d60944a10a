//! One report of the gripper, and what the references say at the same angle.

use messages::Report;
use model_core::status::Status;

/// The references, as they are called and ordered everywhere.
pub const REFERENCES: [&str; 2] = ["trapezoid", "paper"];
/// Percentages are of the reference's force, and of this where it is smaller, N.
pub const FLOOR_N: f64 = 5.0;

/// Which way the finger has moved last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// To greater angles.
    Closing,
    /// To smaller ones.
    Opening,
}

impl Way {
    /// Both, in the order in which they happen.
    pub const BOTH: [Self; 2] = [Self::Closing, Self::Opening];

    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Closing => "closing",
            Self::Opening => "opening",
        }
    }
}

/// One report of the gripper, and what the references say at the same angle.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// The report.
    pub report: Report,
    /// Seconds since the first one, by the gripper's clock.
    pub time_s: f64,
    /// Motor angle of the report's position, degrees, as exact as the position.
    pub angle_deg: f64,
    /// Which way the finger has moved last.
    pub way: Way,
    /// Closings begun so far.
    pub cycle: u32,
    /// Forces of the references, world frame, N.
    pub references: [Option<[f64; 2]>; 2],
}

impl Sample {
    /// Whether the force may be used.
    pub fn is_trustworthy(&self) -> bool {
        self.report.estimate.status.is_trustworthy()
    }

    /// Whether an estimate was made in this tick.
    pub fn is_fresh(&self) -> bool {
        self.report.estimate.status != Status::Stale
    }

    /// Force on the target, world frame, N.
    pub fn force(&self) -> [f64; 2] {
        self.report.estimate.force.map(f64::from)
    }

    /// Its magnitude, N.
    pub fn magnitude(&self) -> f64 {
        let [x, y] = self.force();
        x.hypot(y)
    }

    /// A reference's magnitude, N.
    pub fn reference(&self, which: usize) -> Option<f64> {
        self.references[which].map(|[x, y]| x.hypot(y))
    }

    /// How much greater the target's magnitude is than a reference's, N.
    pub fn excess(&self, which: usize) -> Option<f64> {
        Some(self.magnitude() - self.reference(which)?)
    }

    /// The same in percent.
    pub fn excess_percent(&self, which: usize) -> Option<f64> {
        Some(100.0 * self.excess(which)? / self.reference(which)?.max(FLOOR_N))
    }

    /// Length of the difference of the force vectors, N, and the same in percent; only for a trustworthy estimate in
    /// contact.
    pub fn difference(&self, which: usize) -> Option<[f64; 2]> {
        let reference = self.references[which]?;
        let force = self.force();
        let size = reference[0].hypot(reference[1]);
        if !self.is_trustworthy() || (size == 0.0 && self.magnitude() == 0.0) {
            return None;
        }
        let off = (force[0] - reference[0]).hypot(force[1] - reference[1]);
        Some([off, 100.0 * off / size.max(FLOOR_N)])
    }
}
