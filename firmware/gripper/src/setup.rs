//! What is set, and by which records it is kept.

use messages::{FINGERS, Finger, Object, ServoSetup, Settings};
use model_core::uncertainty::Uncertainty;

/// What is set.
#[derive(Clone, Debug)]
pub(crate) struct Setup {
    pub(crate) settings: Settings,
    pub(crate) fingers: [Option<Finger>; FINGERS],
    pub(crate) objects: [Option<Object>; FINGERS],
    pub(crate) uncertainties: [Option<Uncertainty>; FINGERS],
    /// How the servos were found set; not kept.
    pub(crate) servos: [Option<ServoSetup>; FINGERS],
}

impl Setup {
    /// Default settings, no finger, no object.
    pub(crate) const DEFAULT: Self = Self {
        settings: Settings::DEFAULT,
        fingers: [const { None }; FINGERS],
        objects: [None; FINGERS],
        uncertainties: [None; FINGERS],
        servos: [None; FINGERS],
    };
}

/// Where what is set lies: looked at and changed in place, as a copy takes kilobytes of the stack.
pub(crate) trait Place {
    fn look<R>(&self, look: impl FnOnce(&Setup) -> R) -> R;

    fn change(&mut self, change: impl FnOnce(&mut Setup));
}

impl Place for Setup {
    fn look<R>(&self, look: impl FnOnce(&Setup) -> R) -> R {
        look(self)
    }

    fn change(&mut self, change: impl FnOnce(&mut Setup)) {
        change(self);
    }
}

/// Which record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Key {
    Settings,
    Finger(u8),
    Object(u8),
    Uncertainty(u8),
}

impl Key {
    /// Every record; the settings, without which the gripper is idle, last.
    pub(crate) fn all() -> impl Iterator<Item = Self> {
        let of = |finger| [Self::Finger(finger), Self::Object(finger), Self::Uncertainty(finger)];
        (0..FINGERS as u8).flat_map(of).chain([Self::Settings])
    }

    /// Its number in flash.
    pub(crate) fn number(self) -> u8 {
        match self {
            Self::Settings => 0,
            Self::Finger(finger) => 0x10 + finger,
            Self::Object(finger) => 0x20 + finger,
            Self::Uncertainty(finger) => 0x30 + finger,
        }
    }
}
