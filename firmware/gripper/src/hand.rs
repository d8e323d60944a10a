//! The fingers, as they are set.

use heapless::Vec;
use messages::{FINGERS, Refusal, Settings, SettingsField};

use crate::Model;
use crate::board::Board;
use crate::return_delay;
use crate::shared::Shared;
use crate::unit::{Torque, Unit};

/// What scheduler, estimation and leadership have in common.
pub(crate) struct Hand<'a> {
    pub(crate) shared: &'a Shared,
    pub(crate) settings: Settings,
    pub(crate) units: Vec<Unit<'a>, FINGERS>,
}

impl<'a> Hand<'a> {
    /// No finger.
    pub(crate) fn new(shared: &'a Shared) -> Self {
        Self { shared, settings: Settings::DEFAULT, units: Vec::new() }
    }

    /// Takes the fingers in, as they were kept, as far as the board has room for them. In place: they take kilobytes of the stack.
    pub(crate) fn take_in<B: Board>(&mut self, models: impl Iterator<Item = &'a mut Model>) {
        let shared = self.shared;
        // What was kept may be of a board with more room, or of a program that took any return delay.
        let mut settings = shared.setup(|setup| setup.settings);
        return_delay::drop_unkept(&mut settings, B::ANSWER_US);
        let settings = if settings.validate(B::FINGERS).is_ok() { settings } else { Settings::DEFAULT };
        shared.set(|setup| setup.settings = settings);
        self.settings = settings;
        for (number, (model, mount)) in models.zip(settings.fingers).enumerate() {
            // There are as many mounts as there is room.
            let _ = self.units.push(Unit::new(number as u8, model, mount));
        }
        self.units.iter_mut().for_each(|unit| unit.restore(shared));
    }

    /// Whether a finger's servo is there.
    pub(crate) fn is_any_present(&self) -> bool {
        self.units.iter().any(|unit| unit.health.is_present())
    }

    /// Whether a finger whose servo is there grips.
    pub(crate) fn is_any_gripping(&self) -> bool {
        self.units.iter().any(|unit| unit.health.is_present() && unit.grip.is_gripping())
    }

    /// Whether the torque of a servo that is there is still to be switched off.
    #[inline(never)]
    pub(crate) fn is_any_falling(&self) -> bool {
        self.units.iter().any(|unit| unit.health.is_present() && unit.torque == Torque::Falling)
    }

    /// The finger of this number, whether it is mounted or not.
    pub(crate) fn unit(&mut self, finger: u8) -> Result<&mut Unit<'a>, Refusal> {
        let last = self.units.len().saturating_sub(1) as f32;
        SettingsField::Finger.check(f32::from(finger), 0.0, last)?;
        self.units.get_mut(usize::from(finger)).ok_or(Refusal::NoServo)
    }
}
