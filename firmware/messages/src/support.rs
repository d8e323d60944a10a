//! What holds the object besides the fingers.

use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

use crate::{Outcome, SettingsField};

/// What holds the object besides the fingers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Support {
    /// Everything: it stays where it was set.
    #[default]
    Fixed,
    /// Nothing. From where it is when this is set (two fingers at least touch it) it goes to where their forces balance
    /// the load, with the object's friction if it has any, and follows them from then on. All fingers have the same object.
    Free {
        /// Force at its centre (of a polygon: the mean of the corners), N, gripper frame; its weight, for instance.
        load: [f32; 2],
        /// Moment, N·mm, counter-clockwise; 0 for a circle without friction, which nothing holds against one.
        moment: f32,
    },
}

impl Support {
    /// Checks its numbers against how many fingers there are.
    pub(crate) fn validate(self, fingers: usize) -> Outcome {
        let Self::Free { load, moment } = self else {
            return Ok(());
        };
        // One finger holds nothing.
        SettingsField::Fingers.check(fingers as f32, 2.0, crate::FINGERS as f32)?;
        load.into_iter().try_for_each(|part| SettingsField::Load.check(part, -1000.0, 1000.0))?;
        SettingsField::Moment.check(moment, -1e5, 1e5)
    }
}
