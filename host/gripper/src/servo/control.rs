//! The servo's own control: the duty or torque that its gains and goals make, as the e-Manual's block diagrams have it.
//!
//! Position: PWM = P/128 · error + I/65536 · Σ error + D/16 · change of the error, with counts and units of PWM (885 are the full
//! voltage of the X series). Velocity: PWM = P/128 · error + I/65536 · Σ error, with units of velocity. The manual does not say how often that
//! is: a millisecond is assumed. The position's error is not rounded to counts here.

use dynamixel::{Layout, Model, Register, xm430};

use super::motor::{Motor, Supply};

/// Milliseconds per second: the sums' clock.
const PER_SECOND: f64 = 1000.0;

/// Gains as in the control table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gains {
    /// Proportional.
    pub p: u16,
    /// Integral.
    pub i: u16,
    /// Derivative; none in velocity control.
    pub d: u16,
}

impl Gains {
    /// As the XM430-W350 comes from the factory: 29 N·mm per count.
    pub const FACTORY: Self = Self { p: 800, i: 0, d: 0 };
    /// The greatest that there are: within a second or two the goal's very count.
    pub const GREATEST: Self = Self { p: 16_383, i: 16_383, d: 0 };

    /// As a model comes from the factory. The manual does not say it of the P series: there they are assumed to be as firm, by angle, as
    /// the XM430-W350's.
    pub fn of(model: &Model) -> Self {
        let of = |register: Register<u16>| {
            let address = model.at(register).address();
            let item = model.items().and_then(|mut items| items.find(|item| item.address == address));
            item.and_then(|item| u16::try_from(item.default).ok()).unwrap_or(0)
        };
        match model.layout {
            Layout::X => {
                Self { p: of(xm430::POSITION_P_GAIN), i: of(xm430::POSITION_I_GAIN), d: of(xm430::POSITION_D_GAIN) }
            }
            Layout::P => Self { p: 14, i: 0, d: 0 },
        }
    }
}

/// What the output may not exceed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ceiling {
    /// Part of the voltage, 0 to 1.
    pub duty: f64,
    /// Torque, N·mm.
    pub torque: f64,
}

/// What control remembers from moment to moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Control {
    /// Units of PWM that are the whole voltage.
    full_pwm: f64,
    /// Sum of the errors, units times milliseconds.
    sum: f64,
}

impl Control {
    /// Of a model.
    pub fn of(model: &Model) -> Self {
        Self { full_pwm: f64::from(model.full_pwm), sum: 0.0 }
    }

    /// Forgets: the torque came on, or the mode changed.
    pub fn clear(&mut self) {
        self.sum = 0.0;
    }

    /// Towards a trajectory's position (counts) at its speed (counts/s), for a moment of so many seconds.
    pub fn position(&mut self, gains: Gains, to: (f64, f64), motor: &Motor, ceiling: Ceiling, seconds: f64) -> Supply {
        let error = to.0 - motor.position;
        let damping = f64::from(gains.d) / 16.0 / PER_SECOND;
        self.control(gains, error, damping * to.1, damping, ceiling, seconds)
    }

    /// Towards a speed, counts/s; `unit` is one unit of velocity, counts/s.
    pub fn velocity(
        &mut self,
        gains: Gains,
        to: f64,
        unit: f64,
        motor: &Motor,
        ceiling: Ceiling,
        seconds: f64,
    ) -> Supply {
        let gains = Gains { d: 0, ..gains };
        // The error of a speed falls with the speed as a derivative's does: that part is solved with the motor.
        let slope = f64::from(gains.p) / 128.0 / unit;
        let integrated = (to - motor.speed) / unit;
        let proportional = slope * to;
        self.control(Gains { p: 0, ..gains }, integrated, proportional, slope, ceiling, seconds)
    }

    fn control(
        &mut self,
        gains: Gains,
        error: f64,
        extra: f64,
        per_speed: f64,
        ceiling: Ceiling,
        seconds: f64,
    ) -> Supply {
        let integral = f64::from(gains.i) / 65_536.0;
        let output = |sum: f64| f64::from(gains.p) / 128.0 * error + integral * sum + extra;
        let sum = self.sum + error * seconds * PER_SECOND;
        // It does not wind up: what would only saturate the output is not added.
        if output(sum).abs() <= ceiling.duty * self.full_pwm || output(sum).abs() < output(self.sum).abs() {
            self.sum = sum;
        }
        Supply::Duty {
            at_rest: output(self.sum) / self.full_pwm,
            per_speed: per_speed / self.full_pwm,
            most: ceiling.duty,
            torque: ceiling.torque,
        }
    }
}
