//! The status that qualifies every number which leaves the solver.

/// Outcome of a solve or of an estimator's tick. The words are the same in every output of the project.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Status {
    /// All residuals within tolerance on a stable branch.
    Converged,
    /// One-iteration mode, residual within its stated bound.
    Tracking,
    /// The finger does not touch the object.
    NoContact,
    /// Converged after a snap-through (in one-iteration mode: within its bound): the branch has ended and another was found beyond, or
    /// the force has changed as much within as short a way on a branch that goes on.
    Snapped,
    /// The iterations allowed were not enough.
    MaxIterations,
    /// The residual stopped falling above the tolerance.
    Stagnated,
    /// The branch ended, as the stability test says, and no other was found.
    Folded,
    /// More samples touch than the model has room for.
    ContactCapacity,
    /// The motor angle (or distance) is outside the range that can be followed; or the object is, or came on the way, against
    /// the finger's clamped base, which cannot give way; or the finger has slipped past the object.
    OutOfRange,
    /// Older than the present measurement.
    Stale,
    /// The residual stays above the tolerance while the steps are as small as rounding: a matter of the precision, not of the finger.
    Precision,
    /// Which samples touch did not settle, so that nothing can be said about the branch.
    Unsettled,
    /// The work is spread over ticks: the numbers are the present measurement's, but only within 1 % or 0.05 N of the force,
    /// whichever is more. What has no such bound is [`Self::MaxIterations`].
    Updating,
}

impl Status {
    /// True if the numbers that come with this status may be used.
    pub fn is_trustworthy(self) -> bool {
        matches!(self, Self::Converged | Self::Tracking | Self::NoContact | Self::Snapped)
    }

    /// The word used in files, messages and on screens.
    pub fn word(self) -> &'static str {
        match self {
            Self::Converged => "converged",
            Self::Tracking => "tracking",
            Self::NoContact => "no-contact",
            Self::Snapped => "snapped",
            Self::MaxIterations => "max-iterations",
            Self::Stagnated => "stagnated",
            Self::Folded => "folded",
            Self::ContactCapacity => "contact-capacity",
            Self::OutOfRange => "out-of-range",
            Self::Stale => "stale",
            Self::Precision => "precision",
            Self::Unsettled => "unsettled",
            Self::Updating => "updating",
        }
    }
}

impl core::fmt::Display for Status {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(self.word())
    }
}
