//! A servo's surroundings: its supply and its temperature.

use crate::datasheet::{NOMINAL_VOLTAGE, TORQUE_CONSTANT};

/// Temperature inside without current, °C.
const AMBIENT: f64 = 32.0;
/// What it rises by in the end with a current, K/A², and how fast, s. Assumptions.
const HEAT: f64 = 40.0;
const HEATING_TIME: f64 = 300.0;

/// Supply and temperature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surroundings {
    /// Supply, V.
    pub volts: f64,
    /// Temperature inside, °C.
    pub temperature: f64,
}

impl Default for Surroundings {
    fn default() -> Self {
        Self { volts: NOMINAL_VOLTAGE, temperature: AMBIENT }
    }
}

impl Surroundings {
    /// Lets the motor's torque (N·mm) warm it for a time, s.
    pub fn warm(&mut self, torque: f64, seconds: f64) {
        let amperes = torque / TORQUE_CONSTANT;
        let to = AMBIENT + HEAT * amperes * amperes;
        self.temperature = to + (self.temperature - to) * (-seconds / HEATING_TIME).exp();
    }

    /// The supply as registers show it, 0.1 V.
    pub fn voltage(&self) -> u16 {
        (self.volts * 10.0).round() as u16
    }
}
