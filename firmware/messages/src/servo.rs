//! What a servo is and how it is set: what a gripper was commissioned with, and what it finds.

use dynamixel::xm430;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Registers of a servo that decide where a goal leads it. All but the model outlive its power.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ServoSetup {
    /// Model Number.
    pub model: u16,
    /// Operating Mode; 3 is position control, 5 current-based position control.
    pub operating_mode: u8,
    /// Drive Mode.
    pub drive_mode: u8,
    /// Homing Offset, counts.
    pub homing_offset: i32,
    /// Min and Max Position Limit, counts.
    pub position_limits: [i32; 2],
    /// Startup Configuration.
    pub startup: u8,
}

/// A register of a servo that is not as it should be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ServoField {
    /// Another model, or one that the gripper does not know.
    Model,
    /// Operating Mode.
    OperatingMode,
    /// Drive Mode.
    DriveMode,
    /// Homing Offset.
    HomingOffset,
    /// Min Position Limit.
    LeastPosition,
    /// Max Position Limit.
    GreatestPosition,
    /// Startup Configuration.
    StartupConfiguration,
    /// Bus Watchdog: it has tripped, and the servo takes no goals.
    BusWatchdog,
    /// Present Position: it is outside the position limits, where the servo takes no goal.
    PresentPosition,
    /// ID: pings are answered soundly and reads are not, as by two servos at once.
    Id,
    /// Goal Current: a model without current-based position control, which [`crate::Mount::current_fence`] needs.
    GoalCurrent,
    /// Status Return Level: it answered pings only, or reads too, and was set to answer everything.
    StatusReturnLevel,
}

impl ServoField {
    /// Whether the gripper puts it right: the servo is controlled when it is found the next time.
    pub const fn is_mended(self) -> bool {
        matches!(self, Self::BusWatchdog | Self::StatusReturnLevel)
    }

    /// What the servo's manual calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Model => "Model Number",
            Self::OperatingMode => "Operating Mode",
            Self::DriveMode => "Drive Mode",
            Self::HomingOffset => "Homing Offset",
            Self::LeastPosition => "Min Position Limit",
            Self::GreatestPosition => "Max Position Limit",
            Self::StartupConfiguration => "Startup Configuration",
            Self::BusWatchdog => "Bus Watchdog",
            Self::PresentPosition => "Present Position",
            Self::Id => "ID",
            Self::GoalCurrent => "Goal Current",
            Self::StatusReturnLevel => "Status Return Level",
        }
    }
}

/// A register, what it is and what it should be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Difference {
    /// Which.
    pub field: ServoField,
    /// What was found.
    pub found: i32,
    /// What it should be.
    pub expected: i32,
}

impl ServoSetup {
    /// Of a servo whose registers were not read.
    pub const UNREAD: Self =
        Self { model: 0, operating_mode: 0, drive_mode: 0, homing_offset: 0, position_limits: [0; 2], startup: 0 };

    /// Whether it limits its current by itself: its Operating Mode is current-based position control.
    pub fn is_fenced(&self) -> bool {
        self.operating_mode == xm430::CURRENT_BASED_POSITION_CONTROL
    }

    /// The first register in which another servo differs from this one.
    pub fn difference(&self, other: &Self) -> Option<Difference> {
        use ServoField as Field;
        let pairs = [
            (Field::Model, i32::from(other.model), i32::from(self.model)),
            (Field::OperatingMode, i32::from(other.operating_mode), i32::from(self.operating_mode)),
            (Field::DriveMode, i32::from(other.drive_mode), i32::from(self.drive_mode)),
            (Field::HomingOffset, other.homing_offset, self.homing_offset),
            (Field::LeastPosition, other.position_limits[0], self.position_limits[0]),
            (Field::GreatestPosition, other.position_limits[1], self.position_limits[1]),
            (Field::StartupConfiguration, i32::from(other.startup), i32::from(self.startup)),
        ];
        let differs = pairs.into_iter().find(|(_, found, expected)| found != expected);
        differs.map(|(field, found, expected)| Difference { field, found, expected })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_register_counts() {
        let setup = ServoSetup {
            model: 1020,
            operating_mode: 3,
            drive_mode: 0,
            homing_offset: 5,
            position_limits: [0, 4095],
            startup: 0,
        };
        assert_eq!(setup.difference(&setup), None);
        let others = [
            (ServoSetup { model: 1200, ..setup }, ServoField::Model, 1200, 1020),
            (ServoSetup { operating_mode: 1, ..setup }, ServoField::OperatingMode, 1, 3),
            (ServoSetup { drive_mode: 1, ..setup }, ServoField::DriveMode, 1, 0),
            (ServoSetup { homing_offset: -9, ..setup }, ServoField::HomingOffset, -9, 5),
            (ServoSetup { position_limits: [7, 4095], ..setup }, ServoField::LeastPosition, 7, 0),
            (ServoSetup { position_limits: [0, 3000], ..setup }, ServoField::GreatestPosition, 3000, 4095),
            (ServoSetup { startup: 1, ..setup }, ServoField::StartupConfiguration, 1, 0),
        ];
        for (other, field, found, expected) in others {
            assert_eq!(setup.difference(&other), Some(Difference { field, found, expected }));
        }
    }
}
