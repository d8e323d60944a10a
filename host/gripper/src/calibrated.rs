//! A calibration into a gripper's memory, and read back.

use messages::{Direction, Finger, Object};
use model_core::drive::Drive;
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
    pub object: Option<Object>,
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
    /// Its zero is from another calibration.
    #[error(
        "finger {number} has the zero of another calibration ({before:.2} counts): this one adds to it only if it was measured with that"
    )]
    OnTop {
        /// Which finger.
        number: u8,
        /// Its zero position, counts.
        before: f32,
    },
    /// What is read back is something else.
    #[error("the gripper's {0} is not what was sent: does something else set it?")]
    Differs(&'static str),
}

/// What became of a calibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sent {
    /// The finger's zero position before, counts.
    pub before: f32,
    /// The same now.
    pub now: f32,
    /// The zero was from this calibration already, and is left as it is.
    pub was_there: bool,
}

impl Calibrated {
    /// A digest of it, never 0: its zero is a difference, and must not be added twice. (Fowler, Noll and Vo's hash, of its values' shortest
    /// decimals.)
    pub fn identity(&self) -> u32 {
        let hash = format!("{self:?}")
            .bytes()
            .fold(0x811C_9DC5_u32, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193));
        hash.max(1)
    }
}

/// Sends it to a finger and reads it back; a finger that has it already keeps its zero.
///
/// The gripper keeps what it takes over a restart.
///
/// # Errors
/// No answer, a refusal, or a gripper that says something else afterwards; unless `on_top`, a finger whose zero is from another calibration.
pub fn send(link: &Link, number: u8, calibrated: &Calibrated, on_top: bool) -> Result<Sent, SendError> {
    let mut settings = link.settings()?;
    let count = settings.count();
    let place = settings.fingers.get_mut(usize::from(number)).and_then(Option::as_mut);
    let mount = place.ok_or(SendError::NoFinger { number, count })?;
    let before = mount.zero;
    let identity = calibrated.identity();
    // A zero that was not fitted says nothing about the gripper's.
    let shifts = calibrated.zero_counts != 0.0;
    if shifts && ![0, identity].contains(&mount.calibration) && !on_top {
        return Err(SendError::OnTop { number, before });
    }
    let sign = if mount.direction == Direction::Same { 1.0 } else { -1.0 };
    let was_there = shifts && mount.calibration == identity;
    if shifts && !was_there {
        mount.zero += (sign * f64::from(mount.gear_ratio) * calibrated.zero_counts) as f32;
        mount.calibration = identity;
    }
    mount.drive = calibrated.drive;
    let now = mount.zero;
    link.set_finger(number, &calibrated.finger)?;
    if let Some(object) = calibrated.object {
        link.set_object(number, object)?;
    }
    link.set_uncertainty(number, Some(calibrated.uncertainty))?;
    // Zero and identity are one record: what is sent again after a fault is not added twice.
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
    Ok(Sent { before, now, was_there })
}
