//! What a finger is doing, and why.

use core::fmt::{self, Display};

/// Why a finger does what it does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Why {
    /// It was asked to.
    Asked,
    /// No sound answer came from the servo in time.
    Bus,
    /// The servo was lost, and found again.
    ServoLost,
    /// The servo reports a hardware error.
    Alert,
    /// The estimate is untrustworthy.
    Estimate,
    /// The motor does not get where it is moved.
    Stall,
    /// The current is at its limit.
    Current,
    /// The force is at its limit.
    Force,
    /// The angle is at its limit, and the force is not reached.
    Angle,
    /// The host has fallen silent.
    Host,
    /// The servo is about to be too hot.
    Heat,
    /// The servo's supply is about to be too low.
    Supply,
}

/// What a finger is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Phase {
    /// It goes to an angle, or is there.
    Moving,
    /// It closes until the force asked for is reached.
    Gripping,
    /// The force asked for is reached, and kept.
    Gripped,
    /// It grips, but stays where it is until what is wrong has passed.
    Waiting(Why),
    /// It stays where it is.
    Held(Why),
    /// It opens.
    Released(Why),
    /// Its motor is without torque: only friction holds it.
    Relaxed,
}

/// What a finger does when something is wrong with its force: an untrustworthy estimate, a silent bus, a stalled motor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Reaction {
    /// It stays where it is.
    #[default]
    Hold,
    /// It opens.
    Release,
}

impl Why {
    /// The reason, for use after a comma.
    pub fn words(self) -> &'static str {
        match self {
            Self::Asked => "as asked",
            Self::Bus => "no sound answer came from the servo in time",
            Self::ServoLost => "the servo was lost and found again",
            Self::Alert => "the servo reports a hardware error",
            Self::Estimate => "the estimate is untrustworthy",
            Self::Stall => "the motor does not reach its goal",
            Self::Current => "the current is at its limit",
            Self::Force => "the force is at its limit",
            Self::Angle => "the angle is at its limit and the force is not reached",
            Self::Host => "nothing comes from the host any more",
            Self::Heat => "the servo is too hot",
            Self::Supply => "the servo's supply is too low",
        }
    }
}

impl Phase {
    /// One word, the same in every output.
    pub fn word(self) -> &'static str {
        match self {
            Self::Moving => "moving",
            Self::Gripping => "gripping",
            Self::Gripped => "gripped",
            Self::Waiting(_) => "waiting",
            Self::Held(_) => "held",
            Self::Released(_) => "released",
            Self::Relaxed => "relaxed",
        }
    }

    /// Why, if there is something to say.
    pub fn why(self) -> Option<Why> {
        match self {
            Self::Moving | Self::Gripping | Self::Gripped | Self::Relaxed => None,
            Self::Waiting(why) | Self::Held(why) | Self::Released(why) => Some(why),
        }
    }
}

impl Display for Phase {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.word())?;
        match self.why() {
            Some(why) => write!(f, ": {}", why.words()),
            None => Ok(()),
        }
    }
}
