//! Grips by force in a bare loop: a servo of the X series, a load cell, no executor and no interrupt.
//!
//! Everything above `main` is what a microcontroller runs. Its HAL brings the port, the delay and the cell; here [`bench`] simulates
//! them.

mod bench;

use dynamixel::blocking::Master;
use dynamixel::{Error, Id, Timing, xm430};
use embedded_hal::delay::DelayNs;
use embedded_io::{Read, ReadReady, Write};
use grip::{Calibration, Faults, Firmness, Gear, Grip, Limits, Phase, Reaction, Target, Touch};

/// Ticks per second.
const RATE_HZ: f64 = 200.0;
const LIMITS: Limits = Limits { range: [-0.2, 0.8], open_angle: 0.0, speed: 0.35, force: 15.0, current: 500.0 };
const FAULTS: Faults = Faults { reaction: Reaction::Hold, untrusted_s: 0.05, strain: Reaction::Hold };

/// A finger and its servo.
struct Finger<U, D> {
    master: Master<U, D>,
    id: Id,
    grip: Grip,
    calibration: Calibration,
}

impl<U: Read + ReadReady + Write, D: DelayNs> Finger<U, D> {
    /// Switches the torque on, where the motor is.
    fn start(port: U, delay: D, id: Id) -> Result<Self, Error<U::Error>> {
        let mut master = Master::new(port, delay, Timing::at(1_000_000));
        let (mut grip, calibration) = (Grip::REST, Calibration::new(&Gear::DIRECT));
        let position = master.get(id, xm430::PRESENT_POSITION)?.value;
        master.set(id, xm430::GOAL_POSITION, position)?;
        master.set(id, xm430::TORQUE_ENABLE, 1)?;
        grip.found(calibration.angle(position));
        Ok(Self { master, id, grip, calibration })
    }

    /// One tick: the goal goes out, position and current come in, and the grip goes by the cell's force, N.
    fn tick(&mut self, cell: impl FnOnce() -> Option<f64>) -> Phase {
        let goal = self.calibration.position(self.grip.advance(1.0 / RATE_HZ, &LIMITS));
        match self.ask(goal) {
            Ok((position, current, alert)) => {
                let current = f32::from(current) * xm430::MILLIAMPERES_PER_UNIT;
                let angle = self.calibration.angle(position);
                let touch = Touch {
                    angle,
                    force: cell(),
                    slope: None,
                    has_model: true,
                    current,
                    firmness: Firmness::XM430,
                    alert,
                    part: 1.0,
                    stop: None,
                    relaxes: false,
                };
                self.grip.feel(&touch, self.calibration.count(), 1.0 / RATE_HZ, &LIMITS, &FAULTS);
            }
            Err(_) => self.grip.miss(&LIMITS, FAULTS.reaction),
        }
        self.grip.phase()
    }

    fn ask(&mut self, goal: i32) -> Result<(i32, i16, bool), Error<U::Error>> {
        self.master.set(self.id, xm430::GOAL_POSITION, goal)?;
        let current = self.master.get(self.id, xm430::PRESENT_CURRENT)?;
        let position = self.master.get(self.id, xm430::PRESENT_POSITION)?;
        Ok((position.value, current.value, position.alert))
    }
}

fn main() {
    let reached = grip_with(5.0);
    println!("{reached}");
}

/// Grips the bench's spring; gives phase and force at the end.
fn grip_with(force: f32) -> String {
    let bench = bench::Bench::new();
    let mut finger = Finger::start(bench.port(), bench.delay(), bench::ID).expect("a servo");
    finger.grip.grip(&Target::of(force), &LIMITS);
    for _tick in 0..600 {
        finger.tick(|| bench.force());
        bench.pass(1.0 / RATE_HZ);
    }
    format!("{} {:.2} N", finger.grip.phase(), bench.force().unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_loop_grips_as_asked() {
        for force in [1.0, 5.0, 12.0] {
            let reached = grip_with(force);
            let number: f32 = reached.trim_start_matches("gripped ").trim_end_matches(" N").parse().expect(&reached);
            assert!((number - force).abs() <= 0.25, "{reached} of {force} N");
        }
    }

    #[test]
    fn a_cell_without_a_value_stops_it() {
        let bench = bench::Bench::new();
        let mut finger = Finger::start(bench.port(), bench.delay(), bench::ID).expect("a servo");
        finger.grip.grip(&Target::of(5.0), &LIMITS);
        let phase = (0..100).map(|_| finger.tick(|| None)).last();
        assert_eq!(phase, Some(Phase::Waiting(grip::Why::Estimate)));
    }
}
