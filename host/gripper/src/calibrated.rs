//! A calibration into a gripper's memory, and read back.

use messages::{Direction, Finger};
use model_core::drive::Drive;
use model_core::object::ObjectDesign;
use model_core::uncertainty::Uncertainty;

use crate::link::{Link, LinkError};

/// What a calibration gives one finger of a gripper.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibrated {
    /// The fitted design, and how it is modelled there.
    pub finger: Finger,
    /// What is added to the zero position of a servo without a gear whose counts grow on closing, counts.
    pub zero_counts: f64,
    /// How the motor moves the base, as fitted.
    pub drive: Drive,
    /// What the fit leaves uncertain, which the standard deviations of the gripper's forces follow.
    pub uncertainty: Uncertainty,
    /// The fitted object, if it goes with it.
    pub object: Option<ObjectDesign>,
}

/// Why a gripper has not taken a calibration.
#[derive(Debug, thiserror::Error)]
pub enum SendError {
    /// The link, or what the gripper refuses.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// It has fewer fingers.
    #[error("the gripper has no finger {number}: it has {count}, counted from 0")]
    NoFinger {
        /// Which was meant.
        number: u8,
        /// How many it has.
        count: usize,
    },
    /// What is read back is something else.
    #[error("the gripper's {0} is not what was sent: does something else set it?")]
    Differs(&'static str),
}

/// Sends it to a finger and reads it back; gives the zero position before and now, counts.
///
/// The gripper keeps what it takes over a restart.
///
/// # Errors
/// No answer, a refusal, or a gripper that says something else afterwards.
pub fn send(link: &Link, number: u8, calibrated: &Calibrated) -> Result<[f32; 2], SendError> {
    let mut settings = link.settings()?;
    let count = settings.count();
    let place = settings.fingers.get_mut(usize::from(number)).and_then(Option::as_mut);
    let mount = place.ok_or(SendError::NoFinger { number, count })?;
    let before = mount.zero;
    let sign = if mount.direction == Direction::Same { 1.0 } else { -1.0 };
    mount.zero += (sign * f64::from(mount.gear_ratio) * calibrated.zero_counts) as f32;
    mount.drive = calibrated.drive;
    let now = mount.zero;
    link.set_finger(number, &calibrated.finger)?;
    if let Some(object) = calibrated.object {
        link.set_object(number, object)?;
    }
    link.set_uncertainty(number, Some(calibrated.uncertainty))?;
    // Last: a zero that was sent twice would be added twice.
    link.set_settings(&settings)?;
    if link.finger(number)?.as_ref() != Some(&calibrated.finger) {
        return Err(SendError::Differs("finger"));
    }
    if link.uncertainty(number)? != Some(calibrated.uncertainty) {
        return Err(SendError::Differs("uncertainty"));
    }
    if calibrated.object.is_some() && link.object(number)? != calibrated.object {
        return Err(SendError::Differs("object"));
    }
    if link.settings()? != settings {
        return Err(SendError::Differs("settings"));
    }
    Ok([before, now])
}
