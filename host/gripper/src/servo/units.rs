//! Units of a model's registers, in counts, seconds and amperes.

use dynamixel::{Layout, Model};

/// Units of a model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    /// One unit of velocity, counts/s.
    pub speed: f64,
    /// One unit of acceleration, counts/s².
    pub acceleration: f64,
    /// One unit of current, A; 0 if there is none.
    pub amperes: f64,
    /// PWM that is the whole voltage.
    pub full_pwm: f64,
    /// Counts of a revolution.
    pub revolution: f64,
    /// Counts of 1/4096 of a revolution.
    pub fineness: f64,
    /// What a position and the same one of a servo that is reversed are together.
    pub turned: f64,
}

impl Units {
    /// Of a model.
    pub fn of(model: &Model) -> Self {
        let revolution = f64::from(model.counts);
        // As the manual prints them: single precision is not that near.
        let printed = |unit: f32| (f64::from(unit) * 1e4).round() / 1e4;
        Self {
            speed: printed(model.velocity) * revolution / 60.0,
            acceleration: printed(model.acceleration) * revolution / 3600.0,
            amperes: model.milliamperes().map_or(0.0, f64::from) / 1000.0,
            full_pwm: f64::from(model.full_pwm),
            revolution,
            fineness: revolution / 4096.0,
            turned: match model.layout {
                Layout::X => revolution,
                Layout::P => 0.0,
            },
        }
    }
}
