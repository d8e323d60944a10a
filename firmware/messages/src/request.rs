//! What the host asks and the gripper answers.

use core::fmt::{self, Write};
use heapless::String;
use model_core::design::Design;
use model_core::discretise::Discretisation;
use model_core::drive::Drive;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

use crate::role::{BAUDS, Role};
use crate::servo::ServoSetup;
use crate::{FINGERS, Reaction, Support};

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

/// Who answers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct Version {
    /// [`crate::PROTOCOL_VERSION`] of the gripper's program.
    pub protocol: u16,
    /// Version of the gripper's program.
    pub firmware: String<16>,
    /// Fingers it has room for.
    pub fingers: u8,
    /// The board it was built for.
    pub board: String<16>,
    /// Ticks per second of the clock in which costs are reported.
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

/// A way to go wrong on purpose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum Provocation {
    /// A start anew that the program asks for.
    Restart,
    /// A panic.
    Panic,
    /// A control loop that stops.
    Hang,
    /// A link that stops.
    HangLink,
    /// A stack that overflows.
    StackOverflow,
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
    /// Which fingers.
    pub fingers: Which,
    /// Motor angle, rad, within [`Mount::range`].
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

/// Which side of the object a finger is on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum Side {
    /// Its closing motion is towards greater x: the gripper's frame is the finger's world frame.
    #[default]
    Left,
    /// It is mirrored: its closing motion is towards smaller x.
    Right,
}

/// One finger of the gripper: its servo, how it is mounted, what it must not exceed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Mount {
    /// The servo's address on the bus, 0 to 252; no two fingers share one.
    pub servo_id: u8,
    /// The servo's position at motor angle 0, counts (4096 per revolution of the servo).
    pub zero: f32,
    /// Which way the counts grow.
    pub direction: Direction,
    /// Revolutions of the servo per revolution of the finger, 0.01 to 100.
    pub gear_ratio: f32,
    /// Play between the servo's position sensor and the finger, rad of the motor angle. A finger that touches is pushed to
    /// its open side: the angle of the estimate is the measured one less half of this. ROBOTIS gives 0.25° for this family.
    pub backlash: f32,
    /// Which side of the object it is on.
    pub side: Side,
    /// Motor angles that may be asked for, rad.
    pub range: [f32; 2],
    /// Motor angle of the open finger, rad, within the range.
    pub open_angle: f32,
    /// Speed of opening and closing, rad/s.
    pub speed: f32,
    /// Force (magnitude) that no motion may exceed by the estimate, N.
    pub force_limit: f32,
    /// Current above which the motor is not moved on, mA.
    pub current_limit: f32,
    /// How the motor moves the finger's base: it turns it, or it moves it along a line (parallel jaws). Everything above is of the
    /// motor's angle either way.
    pub drive: Drive,
    /// How its servo was set when it was commissioned. A servo that is set otherwise is not controlled. `None`: it was not commissioned; a
    /// known model is set up as it is found.
    #[serde(default)]
    pub servo: Option<ServoSetup>,
    /// Which calibration the zero is from: a digest of it, so that the same one is not added twice. 0: none, or the zero was set since.
    #[serde(default)]
    pub calibration: u32,
}

impl Mount {
    /// Servo 1, angle 0 in the middle of its revolution, no play, ±60°, 20°/s, at most 15 N and 0.5 A, turning the finger.
    pub const DEFAULT: Self = Self {
        servo_id: 1,
        zero: 2048.0,
        direction: Direction::Same,
        gear_ratio: 1.0,
        backlash: 0.0,
        side: Side::Left,
        range: [-core::f32::consts::FRAC_PI_3, core::f32::consts::FRAC_PI_3],
        open_angle: 0.0,
        speed: core::f32::consts::PI / 9.0,
        force_limit: 15.0,
        current_limit: 500.0,
        drive: Drive::Rotating,
        servo: None,
        calibration: 0,
    };

    fn validate(&self) -> Outcome {
        let pi = core::f32::consts::PI;
        let checks = [
            (SettingsField::ServoId, f32::from(self.servo_id), 0.0, 252.0),
            (SettingsField::Zero, self.zero, -1_044_479.0, 1_044_479.0),
            (SettingsField::GearRatio, self.gear_ratio, 0.01, 100.0),
            (SettingsField::Backlash, self.backlash, 0.0, 0.1),
            (SettingsField::RangeLow, self.range[0], -pi, pi),
            (SettingsField::RangeHigh, self.range[1], self.range[0], pi),
            (SettingsField::OpenAngle, self.open_angle, self.range[0], self.range[1]),
            (SettingsField::Speed, self.speed, SPEEDS[0], SPEEDS[1]),
            (SettingsField::ForceLimit, self.force_limit, 0.01, 1000.0),
            (SettingsField::CurrentLimit, self.current_limit, 1.0, 10_000.0),
        ];
        checks.into_iter().try_for_each(|(field, value, min, max)| field.check(value, min, max))?;
        self.drive.validate().map_err(|error| Refusal::Drive(Refusal::text(&error)))?;
        // A table says nothing beyond its ends.
        let [first, last] = self.drive.range();
        SettingsField::RangeLow.check(self.range[0], first, last)?;
        SettingsField::RangeHigh.check(self.range[1], first, last)
    }
}

impl Default for Mount {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Speeds that may be asked for, rad/s.
pub const SPEEDS: [f32; 2] = [1e-3, 20.0];

/// What becomes of a closing motion whose host has gone away.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum Silence {
    /// It goes on.
    #[default]
    GoOn,
    /// It stops.
    Hold,
    /// The finger opens.
    Release,
}

/// Of recordings that have none.
const fn untrusted_ms() -> u16 {
    Settings::DEFAULT.untrusted_ms
}

/// Of recordings that have none.
const fn silence_ms() -> u16 {
    Settings::DEFAULT.silence_ms
}

/// Of recordings that have none.
const fn heat_margin() -> u8 {
    Settings::DEFAULT.heat_margin
}

/// Of recordings that have none.
const fn supply_margin() -> f32 {
    Settings::DEFAULT.supply_margin
}

/// What belongs to the gripper rather than to a finger's design or an object.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Settings {
    /// Ticks per second wanted, 1 to 1000.
    pub rate_hz: u16,
    /// Every how many ticks the shapes are sent; 0: never.
    pub shape_every: u16,
    /// What a gripping finger does when something is wrong.
    pub on_fault: Reaction,
    /// How long a finger closes on while its estimate is untrustworthy, ms, 0 to 10,000. (A gripping one waits at once.)
    #[serde(default = "untrusted_ms")]
    pub untrusted_ms: u16,
    /// What a motion does, other than an opening, when no request has come from the host for `silence_ms`. A finger that has gripped keeps
    /// its force.
    #[serde(default)]
    pub on_silence: Silence,
    /// How long the host may be silent, ms, 500 to 60,000. (A view asks for something every second.)
    #[serde(default = "silence_ms")]
    pub silence_ms: u16,
    /// How far below its servo's Temperature Limit a finger is warned, K, 0 to 60; at half of that its force is limited. 0: the temperature
    /// is not minded.
    #[serde(default = "heat_margin")]
    pub heat_margin: u8,
    /// How far above its servo's Min Voltage Limit a finger is warned, V, 0 to 5; at half of that its force is limited. 0: the supply is
    /// not minded.
    #[serde(default = "supply_margin")]
    pub supply_margin: f32,
    /// What a gripping finger does when its servo is about to shut down.
    #[serde(default)]
    pub on_strain: Reaction,
    /// What holds the object besides the fingers.
    pub support: Support,
    /// How the gripper takes part in the bus.
    pub role: Role,
    /// Rate of the bus, one of [`BAUDS`], bits per second. A master sets a servo without torque to it as it
    /// finds it (one with torque may be holding something); `None`: it keeps the rate at which it finds them. A gripper that
    /// listens needs it; `None`: the first of them.
    pub baud: Option<u32>,
    /// Its fingers, the first ones used.
    pub fingers: [Option<Mount>; FINGERS],
}

impl Settings {
    /// One finger as [`Mount::DEFAULT`], 500 Hz, 20 shapes a second, hold when something is wrong, and idle: nothing is controlled before
    /// somebody says so.
    pub const DEFAULT: Self = Self { role: Role::Idle, ..Self::of(Mount::DEFAULT) };

    /// Of a gripper with one finger that leads its servo; the rest as in [`Self::DEFAULT`].
    pub const fn of(mount: Mount) -> Self {
        let fingers = [Some(mount), None, None, None];
        Self {
            rate_hz: 500,
            shape_every: 25,
            on_fault: Reaction::Hold,
            untrusted_ms: 50,
            on_silence: Silence::GoOn,
            silence_ms: 3000,
            heat_margin: 20,
            supply_margin: 1.0,
            on_strain: Reaction::Hold,
            support: Support::Fixed,
            role: Role::Master,
            baud: None,
            fingers,
        }
    }

    /// The finger of this number, from 0.
    pub fn finger(&self, number: u8) -> Option<&Mount> {
        self.fingers.get(usize::from(number))?.as_ref()
    }

    /// How many fingers there are.
    pub fn count(&self) -> usize {
        self.fingers.iter().flatten().count()
    }

    /// Checks every value; `room` is how many fingers the board has memory for.
    ///
    /// # Errors
    /// The first value that is not allowed.
    pub fn validate(&self, room: usize) -> Outcome {
        SettingsField::Rate.check(f32::from(self.rate_hz), 1.0, 1000.0)?;
        SettingsField::Untrusted.check(f32::from(self.untrusted_ms), 0.0, 10_000.0)?;
        SettingsField::Silence.check(f32::from(self.silence_ms), 500.0, 60_000.0)?;
        SettingsField::HeatMargin.check(f32::from(self.heat_margin), 0.0, 60.0)?;
        SettingsField::SupplyMargin.check(self.supply_margin, 0.0, 5.0)?;
        let used = self.fingers.iter().take_while(|mount| mount.is_some()).count();
        // A gap counts as one finger too many.
        let count = if used == self.count() { used } else { FINGERS + 1 };
        SettingsField::Fingers.check(count as f32, 1.0, room as f32)?;
        for (number, mount) in self.fingers.iter().flatten().enumerate() {
            mount.validate()?;
            let before = self.fingers.iter().flatten().take(number);
            if before.into_iter().any(|other| other.servo_id == mount.servo_id) {
                return Err(Refusal::SameServo { servo_id: mount.servo_id });
            }
        }
        match self.baud {
            Some(baud) if !BAUDS.contains(&baud) => return Err(Refusal::Baud { baud }),
            _ => {}
        }
        self.support.validate(used)?;
        self.role.validate(self.fingers.iter().flatten().map(|mount| mount.servo_id))
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Something for one finger.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct For<T> {
    /// Which, from 0.
    pub finger: u8,
    /// What.
    pub what: T,
}

/// A request for all fingers or one of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum Which {
    /// All.
    All,
    /// One, from 0.
    One(u8),
}

impl Which {
    /// Whether this finger is meant.
    pub fn is(self, finger: usize) -> bool {
        match self {
            Self::All => true,
            Self::One(one) => usize::from(one) == finger,
        }
    }
}

/// Close until the force is reached.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct GripTo {
    /// Which fingers.
    pub fingers: Which,
    /// Force of each (magnitude), N, positive, at most its [`Mount::force_limit`].
    pub force: f32,
    /// Greatest speed of closing, rad/s; `None`: the settings' own.
    pub speed: Option<f32>,
    /// Motor angle beyond which no finger closes, rad, within its [`Mount::range`]; `None`: the range's end.
    pub limit: Option<f32>,
}

/// Values of [`Settings`], [`Mount`], [`CloseTo`] and [`GripTo`].
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
    /// [`Settings::silence_ms`].
    Silence,
    /// [`Settings::heat_margin`], K.
    HeatMargin,
    /// [`Settings::supply_margin`], V.
    SupplyMargin,
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
            Self::ReturnDelay => "gripper's return delay in 2 µs",
            Self::Load => "load on the free object in N",
            Self::Moment => "moment on the free object in N·mm",
            Self::Untrusted => "time of closing without a trustworthy estimate in ms",
            Self::Silence => "time of the host's silence in ms",
            Self::HeatMargin => "margin below the servo's temperature limit in K",
            Self::SupplyMargin => "margin above the servo's lowest voltage in V",
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

/// What was counted since the start; all but `uptime_us`, the rates and the latencies wrap.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Counters {
    /// Time since the start, µs.
    pub uptime_us: u64,
    /// Ticks of the control loop, each with a report per finger.
    pub ticks: u32,
    /// Positions that came from a servo, each with an estimate.
    pub estimates: u32,
    /// Ticks that began more than half a period late.
    pub late_ticks: u32,
    /// Ticks of the last full second.
    pub rate_hz: f32,
    /// Ticks per second it should be, given the bus.
    pub chosen_hz: f32,
    /// Reports that found the link's queue full.
    pub dropped_reports: u32,
    /// Grasps that found the link's queue full.
    pub dropped_grasps: u32,
    /// Shapes that found the link's queue full.
    pub dropped_shapes: u32,
    /// Events that found the link's queue full.
    pub dropped_events: u32,
    /// Questions on the bus to which no whole answer came.
    pub bus_timeouts: u32,
    /// Answers that failed their CRC, or were not a packet at all.
    pub bus_damaged: u32,
    /// Instructions that the servo refused.
    pub bus_refused: u32,
    /// Other failures of the bus.
    pub bus_other: u32,
    /// Instructions of another master on the bus.
    pub bus_foreign: u32,
    /// Times the servo was lost.
    pub servo_losses: u32,
    /// Records that were ever written to this gripper's flash, which wears: 10,000 erasures of a page, each of some records, are usual.
    pub flash_writes: u32,
    /// Frames from the host that were sound.
    pub link_frames: u32,
    /// Frames from the host that were damaged or too long.
    pub link_damaged: u32,
    /// Messages too large for a frame.
    pub link_oversize: u32,
    /// From the last byte of a servo's answer (with several fingers: of the last answer) until its report was made, in ticks
    /// of the cost clock; the last one. 0: the board does not know.
    pub latency: u32,
    /// The longest one.
    pub latency_most: u32,
}
