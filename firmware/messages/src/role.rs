//! How the gripper takes part in the Dynamixel bus.

use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

use crate::{Outcome, Refusal, SettingsField};

/// Rates of the bus that servos of the X series and the gripper share, bits per second, the most likely first: servos are
/// looked for in this order, at those that the board's port reaches.
pub const BAUDS: [u32; 7] = [1_000_000, 57_600, 115_200, 2_000_000, 3_000_000, 4_000_000, 4_500_000];

/// Who leads the servos, and whether the gripper speaks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Role {
    /// Nobody: the gripper writes nothing on the bus, and leads no servo, until a person has said which ones.
    #[default]
    Idle,
    /// The gripper leads them: it asks and they answer.
    Master,
    /// Another master leads them. The gripper listens to what it reads of them, and never transmits.
    Tap,
    /// The same, and the gripper answers that master under an address of its own, with the forces in a control table.
    Device {
        /// Its address, 0 to 252; not that of a finger's servo.
        id: u8,
        /// Time between an instruction's end and the answer, in 2 µs, 0 to 254.
        return_delay: u8,
    },
}

impl Role {
    /// A device at its first address, which answers at once.
    pub const DEVICE: Self = Self::Device { id: 100, return_delay: 0 };

    /// Its address on the bus, if it has one.
    pub fn id(self) -> Option<u8> {
        match self {
            Self::Device { id, .. } => Some(id),
            Self::Idle | Self::Master | Self::Tap => None,
        }
    }

    /// Checks its numbers against the addresses of the servos.
    pub(crate) fn validate(self, mut servos: impl Iterator<Item = u8>) -> Outcome {
        let Self::Device { id, return_delay } = self else {
            return Ok(());
        };
        SettingsField::DeviceId.check(f32::from(id), 0.0, 252.0)?;
        SettingsField::ReturnDelay.check(f32::from(return_delay), 0.0, 254.0)?;
        if servos.any(|servo| servo == id) { Err(Refusal::OwnAddress { id }) } else { Ok(()) }
    }
}
