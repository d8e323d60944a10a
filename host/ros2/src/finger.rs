//! What of a set-up a finger's messages depend on, and the names of its frames.

use fre::urdf;
use fre_gripper::source::Setup;
use model_core::drive::Drive;

/// A finger of the source.
#[derive(Clone, Debug, PartialEq)]
pub struct Finger {
    /// Its number, from 0.
    pub number: u8,
    /// How the motor moves it.
    pub drive: Drive,
    /// The motor's axis, world frame, mm; none without a design.
    pub axis: Option<[f64; 2]>,
}

impl Finger {
    /// All fingers of a set-up.
    pub fn all(setup: &Setup) -> Vec<Self> {
        let mounts = (0..).zip(setup.settings.fingers.iter().flatten());
        let of = |(number, mount): (u8, &messages::Mount)| {
            let design = setup.models.get(usize::from(number)).and_then(|model| model.finger.as_ref());
            Self { number, drive: mount.drive, axis: design.map(|finger| finger.design.motor_axis) }
        };
        mounts.map(of).collect()
    }

    /// The frame of its forces, which stands still.
    pub fn frame(&self) -> String {
        urdf::base(self.number)
    }

    /// The joint that the motor moves.
    pub fn joint(&self) -> String {
        urdf::joint(self.number)
    }
}
