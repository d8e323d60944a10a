//! The chip's independent watchdog.

use embassy_stm32::Peri;
use embassy_stm32::wdg::{IndependentWatchdog, Instance};

/// The independent watchdog: it has a clock of its own and cannot be stopped.
pub struct Dog<T: Instance + 'static>(IndependentWatchdog<'static, T>);

impl<T: Instance + 'static> Dog<T> {
    /// Starts it: from now on it wants its food within so many ms.
    pub fn start(peripheral: Peri<'static, T>, ms: u32) -> Self {
        let mut dog = IndependentWatchdog::new(peripheral, ms * 1000);
        dog.unleash();
        Self(dog)
    }
}

impl<T: Instance + 'static> gripper::Watchdog for Dog<T> {
    fn feed(&mut self) {
        self.0.pet();
    }
}
