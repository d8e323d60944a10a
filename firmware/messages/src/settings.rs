//! What is set of a gripper: its fingers' mounts, its rates, and what it does on faults.

use model_core::drive::Drive;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

use crate::refusal::{Outcome, Refusal, SettingsField};
use crate::role::{BAUDS, Role};
use crate::servo::ServoSetup;
use crate::{FINGERS, Reaction, Support};

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
    /// Current above which the motor is not moved on, mA. On a servo that shows a load instead (XL430), the load is that part of its
    /// current at stall.
    pub current_limit: f32,
    /// Whether the servo itself limits its current, too: by current-based position control with a Goal Current from `force_limit` and
    /// `current_limit`. It is chosen when the servo is commissioned, and allows a `range` within one revolution of the servo (counts 0 to
    /// 4095).
    #[serde(default)]
    pub current_fence: bool,
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
        current_fence: false,
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
        if self.servo.is_some_and(|servo| servo.is_fenced() != self.current_fence) {
            return Err(Refusal::Fence);
        }
        if self.current_fence {
            // In that mode the servo counts several turns, and forgets them with its power: a finger out there would be elsewhere then.
            let [first, last] = self.revolution();
            SettingsField::RangeLow.check(self.range[0], first, last)?;
            SettingsField::RangeHigh.check(self.range[1], first, last)?;
        }
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

    /// The rate at which a gripper listens to another master, bits per second: it searches for none.
    pub fn baud_heard(&self) -> u32 {
        let [first, ..] = BAUDS;
        self.baud.unwrap_or(first)
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
