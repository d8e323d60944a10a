//! What the host asks and the gripper answers.

use core::fmt::{self, Write};
use heapless::String;
use model_core::design::Design;
use model_core::discretise::Discretisation;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Longest [`Text`], bytes.
pub const TEXT: usize = 104;

/// A sentence for people.
pub type Text = String<TEXT>;

/// What a request that changes something comes to.
pub type Outcome = Result<(), Refusal>;

/// Who answers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct Version {
    /// [`crate::PROTOCOL_VERSION`] of the gripper's program.
    pub protocol: u16,
    /// Version of the gripper's program.
    pub firmware: String<16>,
    /// The board it was built for.
    pub board: String<16>,
    /// Ticks per second of the clock in which costs are told.
    pub cost_hz: u32,
}

/// Why a processor started.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ResetCause {
    /// Power came.
    PowerOn,
    /// Somebody pressed a button, or a debugger did.
    Pin,
    /// The control loop had stopped.
    Watchdog,
    /// The program itself: asked to, or after a panic or a fault, of which its last words tell.
    Software,
    /// The supply voltage was too low.
    Brownout,
    /// The processor does not say.
    Unknown,
}

/// How the gripper's program started.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct BootReport {
    /// Why.
    pub cause: ResetCause,
    /// What the program before said when it ended by a panic or a fault.
    pub last_words: Option<Text>,
}

/// A finger and how it is modelled.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Finger {
    /// The finger.
    pub design: Design,
    /// Scheme, elements, samples and physics; what fits is limited by the gripper's memory.
    pub how: Discretisation,
}

/// Close (or open) to an angle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct CloseTo {
    /// Motor angle, rad, within [`Settings::range`].
    pub angle: f32,
    /// Speed, rad/s, positive; `None`: the settings' own.
    pub speed: Option<f32>,
}

/// Which way the servo's counts grow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum Direction {
    /// Counts grow as the finger closes.
    #[default]
    Same,
    /// Counts fall as the finger closes.
    Reversed,
}

/// What belongs to the gripper rather than to finger or object.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Settings {
    /// The servo's address on the bus, 0 to 252.
    pub servo_id: u8,
    /// The servo's position at motor angle 0, counts (4096 per revolution of the servo).
    pub zero: f32,
    /// Which way the counts grow.
    pub direction: Direction,
    /// Revolutions of the servo per revolution of the finger, 0.01 to 100.
    pub gear_ratio: f32,
    /// Motor angles that may be asked for, rad.
    pub range: [f32; 2],
    /// Motor angle of the open finger, rad, within the range.
    pub open_angle: f32,
    /// Speed of opening and closing, rad/s.
    pub speed: f32,
    /// Ticks per second wanted, 1 to 1000.
    pub rate_hz: u16,
    /// Every how many ticks a shape is sent; 0: never.
    pub shape_every: u16,
}

impl Settings {
    /// Servo 1, angle 0 in the middle of its revolution, ±60°, 20°/s, 500 Hz, 20 shapes a second.
    pub const DEFAULT: Self = Self {
        servo_id: 1,
        zero: 2048.0,
        direction: Direction::Same,
        gear_ratio: 1.0,
        range: [-core::f32::consts::FRAC_PI_3, core::f32::consts::FRAC_PI_3],
        open_angle: 0.0,
        speed: core::f32::consts::PI / 9.0,
        rate_hz: 500,
        shape_every: 25,
    };

    /// Checks every value.
    ///
    /// # Errors
    /// The first value that is not allowed.
    pub fn validate(&self) -> Outcome {
        let checks = [
            (SettingsField::ServoId, f32::from(self.servo_id), 0.0, 252.0),
            (SettingsField::Zero, self.zero, -1_044_479.0, 1_044_479.0),
            (SettingsField::GearRatio, self.gear_ratio, 0.01, 100.0),
            (SettingsField::RangeLow, self.range[0], -core::f32::consts::PI, core::f32::consts::PI),
            (SettingsField::RangeHigh, self.range[1], self.range[0], core::f32::consts::PI),
            (SettingsField::OpenAngle, self.open_angle, self.range[0], self.range[1]),
            (SettingsField::Speed, self.speed, 1e-3, 20.0),
            (SettingsField::Rate, f32::from(self.rate_hz), 1.0, 1000.0),
        ];
        for (field, value, min, max) in checks {
            if !(min..=max).contains(&value) {
                return Err(Refusal::Setting { field, value, min, max });
            }
        }
        Ok(())
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Values of [`Settings`] and [`CloseTo`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum SettingsField {
    /// Address of the servo.
    ServoId,
    /// Counts at angle 0.
    Zero,
    /// Gear ratio.
    GearRatio,
    /// Least angle, rad.
    RangeLow,
    /// Greatest angle, rad.
    RangeHigh,
    /// Angle of the open finger, rad.
    OpenAngle,
    /// Speed, rad/s.
    Speed,
    /// Ticks per second.
    Rate,
    /// The angle to close to, rad.
    Angle,
}

impl SettingsField {
    /// What people call it, with its unit.
    pub fn name(self) -> &'static str {
        match self {
            Self::ServoId => "servo id",
            Self::Zero => "zero position in counts",
            Self::GearRatio => "gear ratio",
            Self::RangeLow => "least angle in rad",
            Self::RangeHigh => "greatest angle in rad",
            Self::OpenAngle => "open angle in rad",
            Self::Speed => "speed in rad/s",
            Self::Rate => "rate in Hz",
            Self::Angle => "angle in rad",
        }
    }
}

/// Why nothing was changed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub enum Refusal {
    /// The finger, or the model asked for, is at fault; the old one is gone and estimates are `out-of-range`.
    Finger(Text),
    /// The object is at fault; the old one stays.
    Object(Text),
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
    /// No servo answers on the bus.
    NoServo,
    /// The control loop has not taken the request in time.
    Busy,
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
            Self::Finger(why) | Self::Object(why) => f.write_str(why),
            Self::Setting { field, value, min, max } => {
                write!(f, "{} is {value}; allowed is {min} to {max}", field.name())
            }
            Self::NoServo => f.write_str("no servo answers on the bus"),
            Self::Busy => f.write_str("the control loop has not taken the request in time"),
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

/// What was counted since the start; all but `uptime_us`, `rate_hz` and `chosen_hz` wrap.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Counters {
    /// Time since the start, µs.
    pub uptime_us: u64,
    /// Ticks of the control loop, each with a report.
    pub ticks: u32,
    /// Ticks in which a position came from the servo and an estimate was made.
    pub estimates: u32,
    /// Ticks that began more than half a period late.
    pub late_ticks: u32,
    /// Ticks of the last full second.
    pub rate_hz: f32,
    /// Ticks per second it should be, given the bus.
    pub chosen_hz: f32,
    /// Reports that found the link's queue full.
    pub dropped_reports: u32,
    /// Shapes that found the link's queue full.
    pub dropped_shapes: u32,
    /// Events that found the link's queue full.
    pub dropped_events: u32,
    /// Questions on the bus to which no whole answer came.
    pub bus_timeouts: u32,
    /// Answers that failed their CRC, or were no packet at all.
    pub bus_damaged: u32,
    /// Instructions that the servo refused.
    pub bus_refused: u32,
    /// Other failures of the bus.
    pub bus_other: u32,
    /// Times the servo was lost.
    pub servo_losses: u32,
    /// Frames from the host that were sound.
    pub link_frames: u32,
    /// Frames from the host that were damaged or too long.
    pub link_damaged: u32,
    /// Messages too large for a frame.
    pub link_oversize: u32,
}
