//! What a request comes to: done, or refused and why.

use core::fmt::{self, Write};
use heapless::String;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

use crate::FINGERS;
use crate::role::BAUDS;

/// Longest [`Text`], bytes.
pub const TEXT: usize = 104;

/// A sentence for people.
pub type Text = String<TEXT>;

/// What a request that changes something comes to.
pub type Outcome = Result<(), Refusal>;

/// What an order to move comes to for one finger.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum Heed {
    /// It obeys.
    Done,
    /// Its servo does not answer: nothing was done.
    NoServo,
}

/// The same for every finger; `None`: not meant, or not mounted.
pub type Heeds = [Option<Heed>; FINGERS];

/// What an order comes to that each finger obeys as far as it can. Refused if none of them can.
pub type Moved = Result<Heeds, Refusal>;

/// Values of [`crate::Settings`], [`crate::Mount`], [`crate::CloseTo`] and [`crate::GripTo`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum SettingsField {
    /// Address of the servo.
    ServoId,
    /// Counts at angle 0.
    Zero,
    /// Gear ratio.
    GearRatio,
    /// Play, rad.
    Backlash,
    /// Least angle, rad.
    RangeLow,
    /// Greatest angle, rad.
    RangeHigh,
    /// Angle of the open finger, rad.
    OpenAngle,
    /// Speed, rad/s.
    Speed,
    /// Force limit, N.
    ForceLimit,
    /// Current limit, mA.
    CurrentLimit,
    /// Ticks per second.
    Rate,
    /// Number of fingers, without gaps.
    Fingers,
    /// The angle to close to, rad.
    Angle,
    /// The force to grip with, N.
    Force,
    /// The angle limit of a grip, rad.
    Limit,
    /// The finger's number.
    Finger,
    /// The gripper's own address on the bus.
    DeviceId,
    /// Its return delay, 2 µs.
    ReturnDelay,
    /// A part of the load on a free object, N.
    Load,
    /// The moment on a free object, N·mm.
    Moment,
    /// How long a finger closes on without a trustworthy estimate, ms.
    Untrusted,
    /// [`crate::Settings::silence_ms`].
    Silence,
    /// [`crate::Settings::heat_margin`], K.
    HeatMargin,
    /// [`crate::Settings::supply_margin`], V.
    SupplyMargin,
    /// The weight to carry, N.
    Weight,
    /// Where it pulls, rad.
    Gravity,
    /// How many times the weight is to be borne.
    Safety,
}

impl SettingsField {
    /// Whether the message has radians where people are shown degrees.
    fn is_angular(self) -> bool {
        matches!(
            self,
            Self::Backlash
                | Self::RangeLow
                | Self::RangeHigh
                | Self::OpenAngle
                | Self::Speed
                | Self::Angle
                | Self::Limit
                | Self::Gravity
        )
    }

    /// What people call it, with the unit in which they are shown it.
    pub fn name(self) -> &'static str {
        match self {
            Self::ServoId => "servo id",
            Self::Zero => "zero position in counts",
            Self::GearRatio => "gear ratio",
            Self::Backlash => "backlash in degrees",
            Self::RangeLow => "least angle in degrees",
            Self::RangeHigh => "greatest angle in degrees",
            Self::OpenAngle => "open angle in degrees",
            Self::Speed => "speed in degrees per second",
            Self::ForceLimit => "force limit in N",
            Self::CurrentLimit => "current limit in mA",
            Self::Rate => "rate in Hz",
            Self::Fingers => "number of fingers (without gaps)",
            Self::Angle => "angle in degrees",
            Self::Force => "force in N",
            Self::Limit => "limit of the angle in degrees",
            Self::Finger => "finger's number",
            Self::DeviceId => "gripper's own id on the bus",
            Self::ReturnDelay => "gripper's return delay (0: at once) in 2 µs",
            Self::Load => "load on the free object in N",
            Self::Moment => "moment on the free object in N·mm",
            Self::Untrusted => "time of closing without a trustworthy estimate in ms",
            Self::Silence => "time of the host's silence in ms",
            Self::HeatMargin => "margin below the servo's temperature limit in K",
            Self::SupplyMargin => "margin above the servo's lowest voltage in V",
            Self::Weight => "weight to carry in N",
            Self::Gravity => "direction of the weight in degrees",
            Self::Safety => "safety factor of the weight",
        }
    }

    /// Refuses a value outside its range, NaN included.
    ///
    /// # Errors
    /// [`Refusal::Setting`].
    pub fn check(self, value: f32, min: f32, max: f32) -> Outcome {
        let allowed = (min..=max).contains(&value);
        if allowed { Ok(()) } else { Err(Refusal::Setting { field: self, value, min, max }) }
    }
}

/// Why nothing was changed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub enum Refusal {
    /// The finger, or the model asked for, is at fault; the old one is gone and estimates are `out-of-range`.
    Finger(Text),
    /// The object is at fault; the old one stays.
    Object(Text),
    /// An uncertainty is at fault; the old one stays.
    Uncertainty(Text),
    /// A number is outside its range.
    Setting {
        /// Which.
        field: SettingsField,
        /// The number.
        value: f32,
        /// Least allowed.
        min: f32,
        /// Greatest allowed.
        max: f32,
    },
    /// How a motor moves its finger is at fault.
    Drive(Text),
    /// Two fingers would have the same servo.
    SameServo {
        /// Its address.
        servo_id: u8,
    },
    /// The gripper itself would have the address of a servo.
    OwnAddress {
        /// The address.
        id: u8,
    },
    /// A rate of the bus that its servos do not have.
    Baud {
        /// Bits per second.
        baud: u32,
    },
    /// Another master leads the servos.
    NotMaster,
    /// Nobody has said which servos the gripper leads.
    Idle,
    /// The force cannot be controlled without finger and object.
    NoModel,
    /// No servo answers on the bus.
    NoServo,
    /// A finger grips: its ticks are not given away.
    Gripping,
    /// The bus is being searched: the servos are not controlled meanwhile.
    Scanning,
    /// Only programs built for tests go wrong on purpose.
    NotProvokable,
    /// The settings are in force, but the flash does not take them: they are lost with the power.
    NotKept,
    /// The control loop has not taken the request in time.
    Busy,
    /// A servo was commissioned with another Operating Mode than [`crate::Mount::current_fence`] needs.
    Fence,
}

impl Refusal {
    /// The words of an error, cut to what fits.
    pub fn text(error: &impl fmt::Display) -> Text {
        let mut text = Text::new();
        // Cut is better than nothing.
        let _ = write!(Cut(&mut text), "{error}");
        text
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Finger(why) | Self::Object(why) | Self::Uncertainty(why) | Self::Drive(why) => f.write_str(why),
            Self::Setting { field, value, min, max } => {
                let name = field.name();
                if field.is_angular() {
                    let [value, min, max] = [value, min, max].map(|radians| radians.to_degrees());
                    write!(f, "{name} is {value:.3}; allowed is {min:.3} to {max:.3}")
                } else {
                    write!(f, "{name} is {value}; allowed is {min} to {max}")
                }
            }
            Self::SameServo { servo_id } => write!(f, "servo {servo_id} is given to two fingers"),
            Self::OwnAddress { id } => write!(f, "id {id} would be the gripper's own and a servo's"),
            Self::Baud { baud } => write!(f, "baud is {baud}; allowed are {BAUDS:?}"),
            Self::NotMaster => f.write_str("another master leads the servos: the gripper's role is to listen"),
            Self::Idle => {
                f.write_str("the gripper is idle: `fre gripper commission` finds its servos and makes it their master")
            }
            Self::NoModel => f.write_str("the force cannot be controlled before finger and object are set"),
            Self::NoServo => f.write_str("no servo answers on the bus"),
            Self::Gripping => f.write_str("a finger grips: the bus is not searched meanwhile"),
            Self::Scanning => f.write_str("the bus is being searched: ask again in some seconds"),
            Self::NotProvokable => f.write_str("only a program built for tests goes wrong on purpose"),
            Self::NotKept => f.write_str("in force, but not kept: the flash does not take it"),
            Self::Busy => f.write_str("the control loop has not taken the request in time"),
            Self::Fence => f.write_str(
                "current_fence is chosen when servos are commissioned: `fre gripper commission`, with or without --current-fence",
            ),
        }
    }
}

impl core::error::Error for Refusal {}

/// Takes as many characters as there is room for.
struct Cut<'a>(&'a mut Text);

impl Write for Cut<'_> {
    fn write_str(&mut self, words: &str) -> fmt::Result {
        for letter in words.chars() {
            self.0.push(letter).map_err(|_| fmt::Error)?;
        }
        Ok(())
    }
}
