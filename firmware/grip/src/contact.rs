//! What the current shows about contact: when a closing finger first meets something, known to the model or not, and
//! whether the motor's torque is what the estimate demands of it.
//!
//! Current is a poor source of force (its dead zone hides 0.23 N·m) and a good witness.

/// A motor with its gears.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motor {
    /// Torque over current, N·mm/mA.
    pub torque_constant: f32,
    /// Friction, seen as a dead zone of the current, N·mm.
    pub friction: f32,
}

impl Motor {
    /// The XM430-W350 (ROBOTIS' performance graph).
    pub const XM430: Self = Self { torque_constant: 1.79, friction: 233.0 };

    /// The motor behind another gear of so many of its revolutions per revolution.
    pub fn through(self, ratio: f32) -> Self {
        Self { torque_constant: self.torque_constant * ratio, friction: self.friction * ratio }
    }
}

/// Ticks of closing motion from which the free current is learnt before anything can be detected.
const LEARNT: u16 = 10;
/// Rise of the torque above the free one that is a contact, parts of the friction: 45 N·mm of the XM430-W350 (25 mA), five times the
/// noise of its current.
const RISE: f32 = 0.192;
/// Ticks in a row that the rise has to last: the delay of the detection.
pub const DELAY_TICKS: u8 = 3;
/// What demanded and measured torque may differ by beyond the friction: part of the demanded one, and of the friction (60 N·mm of the
/// XM430-W350).
const TOLERANCE: (f32, f32) = (0.25, 0.2575);
/// Time for which they have to differ, s.
const LASTING: f32 = 0.05;

/// What one tick's current shows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Told {
    /// First contact: the motor angle at which the current began to rise, rad.
    pub touched: Option<f64>,
    /// The torques began to disagree (true), or agree again (false).
    pub disagree: Option<bool>,
}

/// Watches one motor's current.
#[derive(Clone, Copy, Debug)]
pub struct Contact {
    last: Option<f64>,
    /// Mean current of the free closing motion, mA, and over how many ticks.
    free: f32,
    learnt: u16,
    /// Ticks above, and the angle at the first of them.
    above: u8,
    began: f64,
    touching: bool,
    apart: f32,
    disagrees: bool,
}

impl Contact {
    /// Nothing seen.
    pub const NONE: Self =
        Self { last: None, free: 0.0, learnt: 0, above: 0, began: 0.0, touching: false, apart: 0.0, disagrees: false };

    /// A tick of a motor: its angle (rad; `count` is its resolution), current (mA, positive drives towards closing), the torque that
    /// a trustworthy estimate demands (N·mm).
    pub fn feel(
        &mut self,
        motor: &Motor,
        angle: f64,
        current: f32,
        count: f64,
        demanded: Option<f32>,
        seconds: f32,
    ) -> Told {
        let moved = self.last.map_or(0.0, |last| angle - last);
        if moved.abs() > 0.5 * count || self.last.is_none() {
            self.last = Some(angle);
        }
        let touched = self.touch(motor, angle, current, moved, count);
        Told { touched, disagree: self.compare(motor, current, demanded, seconds) }
    }

    fn touch(&mut self, motor: &Motor, angle: f64, current: f32, moved: f64, count: f64) -> Option<f64> {
        if moved < -0.5 * count {
            // It opens: the next closing motion is learnt anew.
            (self.learnt, self.above, self.touching) = (0, 0, false);
            return None;
        }
        let closes = moved > 0.5 * count;
        if self.touching || (!closes && self.above == 0) {
            return None;
        }
        if self.learnt < LEARNT || (current - self.free) * motor.torque_constant < RISE * motor.friction {
            self.above = 0;
            if closes {
                self.learnt = self.learnt.saturating_add(1);
                // A mean at first, then one that forgets slowly.
                self.free += (current - self.free) / f32::from(self.learnt.min(50));
            }
            return None;
        }
        if self.above == 0 {
            self.began = angle;
        }
        self.above += 1;
        self.touching = self.above >= DELAY_TICKS;
        self.touching.then_some(self.began)
    }

    fn compare(&mut self, motor: &Motor, current: f32, demanded: Option<f32>, seconds: f32) -> Option<bool> {
        let demanded = demanded?;
        let apart = (current * motor.torque_constant - demanded).abs();
        let allowed = (1.0 + TOLERANCE.1) * motor.friction + TOLERANCE.0 * demanded.abs();
        self.apart =
            if apart > allowed { (self.apart + seconds).min(LASTING) } else { (self.apart - seconds).max(0.0) };
        let disagrees = if self.disagrees { self.apart > 0.0 } else { self.apart >= LASTING };
        let changed = disagrees != self.disagrees;
        self.disagrees = disagrees;
        changed.then_some(disagrees)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COUNT: f64 = 0.001_53;
    const TICK: f32 = 0.002;
    const MOTOR: Motor = Motor::XM430;
    const FRICTION: f32 = MOTOR.friction;

    /// Current of a servo that closes a count a tick against a torque from an angle on, with some noise.
    fn close(contact: &mut Contact, from: f64, slope: f64, ticks: u32) -> Option<(f64, u32)> {
        let mut random = 7_u32;
        (0..ticks).find_map(|tick| {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let noise = (random >> 24) as f32 / 25.5 - 5.0;
            let angle = f64::from(tick) * COUNT;
            let torque = slope * (angle - from).max(0.0);
            let current = (torque as f32 + FRICTION) / MOTOR.torque_constant + noise;
            contact.feel(&MOTOR, angle, current, COUNT, None, TICK).touched.map(|at| (at, tick))
        })
    }

    #[test]
    fn first_contact_is_told_once_and_soon() {
        for slope in [4_000.0, 20_000.0] {
            let mut contact = Contact::NONE;
            let (at, tick) = close(&mut contact, 0.1, slope, 500).unwrap();
            // Rise of the torque to the threshold, and the stated delay.
            let rise = f64::from(RISE * FRICTION + 10.0) / slope;
            assert!(at >= 0.1 && at <= 0.1 + rise + COUNT, "{at}");
            let latest = (0.1 + rise) / COUNT + f64::from(DELAY_TICKS) + 2.0;
            assert!(f64::from(tick) <= latest, "tick {tick}, {latest}");
            assert_eq!(close(&mut contact, 9.0, 0.0, 1), None);
        }
    }

    #[test]
    fn free_motion_touches_nothing() {
        let mut contact = Contact::NONE;
        assert_eq!(close(&mut contact, 9.0, 0.0, 5_000), None);
    }

    #[test]
    fn opening_makes_it_ready_again() {
        let mut contact = Contact::NONE;
        assert!(close(&mut contact, 0.1, 8_000.0, 500).is_some());
        contact.feel(&MOTOR, 0.05, 100.0, COUNT, None, TICK);
        contact.feel(&MOTOR, 0.0, 100.0, COUNT, None, TICK);
        assert!(close(&mut contact, 0.2, 8_000.0, 500).is_some_and(|(at, _)| at > 0.2));
    }

    #[test]
    fn torques_that_disagree_are_told_when_it_lasts() {
        let mut contact = Contact::NONE;
        let mut tell = |torque: f32, demanded: f32, ticks: u32| {
            (0..ticks).find_map(|_| {
                let current = torque / MOTOR.torque_constant;
                contact.feel(&MOTOR, 0.1, current, COUNT, Some(demanded), TICK).disagree
            })
        };
        // A difference as large as the friction, in either direction, does not count.
        assert_eq!(tell(500.0 + FRICTION, 500.0, 1_000), None);
        assert_eq!(tell(500.0 - FRICTION, 500.0, 1_000), None);
        // The object is not where it is said to be.
        assert_eq!(tell(FRICTION, 900.0, 20), None);
        assert_eq!(tell(FRICTION, 900.0, 20), Some(true));
        assert_eq!(tell(FRICTION, 900.0, 100), None);
        assert_eq!(tell(900.0, 900.0, 100), Some(false));
    }

    /// Another motor, and one behind a gear: the same contact, by their own currents.
    #[test]
    fn every_motor_has_its_own_currents() {
        let small = Motor { torque_constant: 0.354, friction: 29.6 };
        for motor in [small, small.through(4.0), MOTOR.through(0.5)] {
            let close = |force: f32| {
                let mut contact = Contact::NONE;
                (0..200).find_map(|tick| {
                    let angle = f64::from(tick) * COUNT;
                    let torque = if tick > 100 { force * motor.friction } else { 0.0 };
                    let current = (motor.friction + torque) / motor.torque_constant;
                    contact.feel(&motor, angle, current, COUNT, None, TICK).touched.map(|_| tick)
                })
            };
            assert_eq!(close(0.18), None, "{motor:?}");
            let met = close(0.21).unwrap();
            assert_eq!(met, 100 + i32::from(DELAY_TICKS), "{motor:?}");
            let mut contact = Contact::NONE;
            let mut tell = |torque: f32, demanded: f32| {
                let mut feel = |_| {
                    let current = torque / motor.torque_constant;
                    contact.feel(&motor, 0.1, current, COUNT, Some(demanded), TICK).disagree
                };
                (0..100).find_map(&mut feel)
            };
            // A difference as large as the friction, in either direction, does not count; 1.6 times as much does.
            assert_eq!(tell(2.0 * motor.friction, motor.friction), None, "{motor:?}");
            assert_eq!(tell(0.0, motor.friction), None, "{motor:?}");
            assert_eq!(tell(2.6 * motor.friction, motor.friction), Some(true), "{motor:?}");
        }
    }
}
