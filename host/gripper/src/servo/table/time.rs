//! What time does to a servo: its trajectory, its control, its motor, its heat.

use dynamixel::xm430;

use super::super::control::{Ceiling, Gains};
use super::super::mode::Mode;
use super::super::motor::Supply;
use super::super::profile::{Limits, Profile};
use super::Table;

/// The longest step in time, s.
const STEP: f64 = 5e-4;
/// Overload is an error after so many seconds. An assumption; the manual says "persistent".
const OVERLOAD_AFTER: f64 = 1.0;
/// Microseconds of one unit of Bus Watchdog.
const WATCHDOG_US: u64 = 20_000;
/// Drive Mode: profiles are given as times.
const TIME_BASED: u8 = 1 << 2;
/// Bits of Hardware Error Status and Shutdown.
const INPUT_VOLTAGE: u8 = 1;
const OVERHEATING: u8 = 1 << 2;
const OVERLOAD: u8 = 1 << 5;

impl Table {
    pub(super) fn since_us(&self) -> f64 {
        (self.now_us - self.began_us) as f64 * 1e-6
    }

    /// Lets time pass, up to `until_us` after power-on.
    pub(in super::super) fn advance(&mut self, until_us: u64) {
        let watchdog = self.get(xm430::BUS_WATCHDOG);
        if self.torque_on() && watchdog > 0 {
            let bark_us = self.touched_us + watchdog as u64 * WATCHDOG_US;
            if bark_us < until_us {
                self.go_on(bark_us);
                self.put(xm430::BUS_WATCHDOG, -1);
                self.hold();
            }
        }
        self.go_on(until_us);
    }

    fn go_on(&mut self, until_us: u64) {
        if until_us <= self.now_us {
            return;
        }
        let (since, seconds) = (self.since_us(), (until_us - self.now_us) as f64 * 1e-6);
        // Equal steps: a remainder of rounding would be a step of no time.
        let steps = (seconds / STEP).ceil().max(1.0);
        let step = seconds / steps;
        let volts = self.surroundings.volts;
        for passed in 0..steps as u64 {
            let now = since + (passed + 1) as f64 * step;
            let supply = self.supply(now, step);
            self.motor.step(supply, volts, step);
            if self.motor.speed == 0.0 && self.is_settled(now) {
                // Nothing changes any more.
                self.motor.step(supply, volts, (steps - 1.0 - passed as f64) * step);
                break;
            }
        }
        self.now_us = until_us;
        self.surroundings.warm(self.motor.torque / self.motor.gear.data.stall_torque, seconds);
        if self.motor.overloaded > OVERLOAD_AFTER {
            self.fail(OVERLOAD);
        }
        if self.surroundings.temperature >= f64::from(self.get(xm430::TEMPERATURE_LIMIT)) {
            self.fail(OVERHEATING);
        }
        let voltage = self.surroundings.voltage();
        if voltage < self.get(xm430::MIN_VOLTAGE_LIMIT) || voltage > self.get(xm430::MAX_VOLTAGE_LIMIT) {
            self.fail(INPUT_VOLTAGE);
        }
    }

    /// Whether a motor at rest gets the same from now on.
    fn is_settled(&self, since: f64) -> bool {
        let position = Mode::of(self.get(xm430::OPERATING_MODE)).is_some_and(Mode::is_position);
        !self.torque_on()
            || (position && since >= self.profile.duration() && self.get(xm430::POSITION_I_GAIN) == 0)
            || matches!(Mode::of(self.get(xm430::OPERATING_MODE)), Some(Mode::Current | Mode::Pwm))
    }

    /// What drives the motor, so many seconds into its profile.
    fn supply(&mut self, since: f64, step: f64) -> Supply {
        if !self.torque_on() {
            return Supply::Off;
        }
        let sign = self.sign();
        let full_pwm = self.units.full_pwm;
        let torque_of = |units: i16| f64::from(units) * self.units.amperes * self.motor.gear.data.torque_constant;
        let duty = f64::from(self.get(xm430::GOAL_PWM)).abs() / full_pwm;
        let mode = Mode::of(self.get(xm430::OPERATING_MODE)).unwrap_or(Mode::Position);
        let torque = match mode {
            Mode::CurrentBasedPosition => torque_of(self.get(xm430::GOAL_CURRENT)).abs(),
            _ => f64::INFINITY,
        };
        let ceiling = Ceiling { duty, torque };
        match mode {
            Mode::Current => Supply::Torque(sign * torque_of(self.get(xm430::GOAL_CURRENT))),
            Mode::Pwm => {
                let at_rest = sign * f64::from(self.get(xm430::GOAL_PWM)) / full_pwm;
                Supply::Duty { at_rest, per_speed: 0.0, most: 1.0, torque }
            }
            Mode::Velocity => {
                let gains = Gains { p: self.get(xm430::VELOCITY_P_GAIN), i: self.get(xm430::VELOCITY_I_GAIN), d: 0 };
                let to = sign * f64::from(self.get(xm430::GOAL_VELOCITY)) * self.units.speed;
                self.control.velocity(gains, to, self.units.speed, &self.motor, ceiling, step)
            }
            Mode::Position | Mode::ExtendedPosition | Mode::CurrentBasedPosition => {
                let gains = Gains {
                    p: self.get(xm430::POSITION_P_GAIN),
                    i: self.get(xm430::POSITION_I_GAIN),
                    d: self.get(xm430::POSITION_D_GAIN),
                };
                self.control.position(gains, self.profile.after(since), &self.motor, ceiling, step)
            }
        }
    }

    /// Starts the way to Goal Position from where the trajectory is.
    pub(super) fn set_out(&mut self) {
        let (position, speed) = self.profile.after(self.since_us());
        let goal = self.position_of(self.get(xm430::GOAL_POSITION));
        let (first, second) = (self.get(xm430::PROFILE_VELOCITY), self.get(xm430::PROFILE_ACCELERATION));
        let (first, second) = (f64::from(first), f64::from(second));
        let limits = if self.get(xm430::DRIVE_MODE) & TIME_BASED != 0 {
            Limits::timed(goal - position, first, second)
        } else {
            Limits { speed: first * self.units.speed, acceleration: second * self.units.acceleration }
        };
        self.profile = Profile::new(position, speed, goal, limits);
        self.began_us = self.now_us;
    }
}
