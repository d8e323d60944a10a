//! What the finger feels at one angle, and why it cannot be known.

use model_core::bounds::OutOfBounds;
use model_core::discretise::DiscretiseError;
use model_core::drive::DriveError;
use model_core::status::Status;

/// Two branches are the same where torque and force differ by less than this, N·mm and N.
const SAME: [f64; 2] = [0.05, 1e-3];

/// Why no table could be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LoadError {
    /// The finger cannot be discretised so.
    #[error("the finger cannot be discretised: {0}")]
    Discretise(DiscretiseError),
    /// The motor cannot move it so.
    #[error("the drive: {0}")]
    Drive(DriveError),
    /// A coefficient of friction that is not one.
    #[error("object.{0}")]
    Friction(OutOfBounds),
    /// Terms of a material with memory that are none.
    #[error("finger.material.{0}")]
    Memory(OutOfBounds),
    /// A drive's table leaves angle 0 out, where the servo's zero is.
    #[error("the drive's table has no distance at motor angle 0°")]
    NoZero,
    /// The object is in the way of the open finger too.
    #[error("the finger touches the object at every motor angle up to 0°: it has nowhere to start from")]
    NoRoom,
    /// The range of angles is empty.
    #[error(
        "the table's highest angle is {highest_deg}°; allowed is from {lowest_deg}° (where the open finger is) to 180°"
    )]
    Range {
        /// What was asked for.
        highest_deg: f64,
        /// Where nothing touches yet.
        lowest_deg: f64,
    },
}

/// The contact at one angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Torque that the contact demands of the motor, N·mm; positive pushes the finger open.
    pub torque: f64,
    /// Force of the finger on the object, world frame, N.
    pub force: [f64; 2],
    /// `no-contact`, `converged`, `snapped` on a branch that the finger has snapped to, `out-of-range` beyond the table.
    pub status: Status,
}

impl Contact {
    pub(super) const NONE: Self = Self { torque: 0.0, force: [0.0; 2], status: Status::NoContact };

    /// The same place of the same branch.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        (self.torque - other.torque).abs() < SAME[0]
            && (self.force[0] - other.force[0]).abs() < SAME[1]
            && (self.force[1] - other.force[1]).abs() < SAME[1]
    }
}
