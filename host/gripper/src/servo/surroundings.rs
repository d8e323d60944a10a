//! A servo's surroundings: its supply and its temperature.

use crate::datasheet::Datasheet;

/// Temperature inside without current, °C.
const AMBIENT: f64 = 32.0;
/// What it rises by in the end with the stall current, K, and how fast, s. Assumptions; 40 K/A² of the XM430-W350.
const HEAT: f64 = 210.0;
const HEATING_TIME: f64 = 300.0;

/// Supply and temperature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surroundings {
    /// Supply, V.
    pub volts: f64,
    /// Temperature inside, °C.
    pub temperature: f64,
}

impl Surroundings {
    /// The supply that the datasheet names, and a cold motor.
    pub fn of(data: &Datasheet) -> Self {
        Self { volts: data.volts, temperature: AMBIENT }
    }

    /// Lets the motor's torque (a part of the stall torque) warm it for a time, s.
    pub fn warm(&mut self, torque: f64, seconds: f64) {
        let to = AMBIENT + HEAT * torque * torque;
        self.temperature = to + (self.temperature - to) * (-seconds / HEATING_TIME).exp();
    }

    /// The supply as registers show it, 0.1 V.
    pub fn voltage(&self) -> u16 {
        (self.volts * 10.0).round() as u16
    }
}
