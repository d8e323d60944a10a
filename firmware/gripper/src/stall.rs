//! Whether a motor gets where it is led.

/// Distance of goal and motor beyond which it may have stalled, rad: a servo's own control leaves up to about a degree
/// under load.
const FAR: f64 = 0.035;
/// Time without a count of progress after which it has, s.
const LONG: f64 = 0.3;

/// Watches a motor. Angles in rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stall {
    /// Where it was last seen to move.
    at: f64,
    /// For how long it has not moved since, s.
    since: f64,
}

impl Stall {
    /// Nothing seen.
    pub const NONE: Self = Self { at: f64::INFINITY, since: 0.0 };

    /// A tick of so many seconds with an answer; whether the motor is stalled.
    pub fn is_stalled(&mut self, goal: f64, angle: f64, count: f64, seconds: f64) -> bool {
        if (goal - angle).abs() < FAR || (angle - self.at).abs() > 0.5 * count {
            *self = Self { at: angle, since: 0.0 };
            return false;
        }
        self.since += seconds;
        self.since > LONG
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COUNT: f64 = 0.0015;
    const TICK: f64 = 0.002;

    /// Ticks until a motor that moves so far a tick stalls on the way to a goal.
    fn ticks(pace: f64, stop: f64, goal: impl Fn(u32) -> f64) -> Option<u32> {
        let (mut stall, mut angle) = (Stall::NONE, 0.0_f64);
        (0..5000).find(|&tick| {
            angle = (angle + pace).min(stop).min(goal(tick));
            stall.is_stalled(goal(tick), angle, COUNT, TICK)
        })
    }

    #[test]
    fn a_blocked_motor_stalls_and_a_slow_one_does_not() {
        let stalled = ticks(0.001, 0.1, |_| 0.5).unwrap();
        assert!((240..=260).contains(&stalled), "{stalled} ticks for 0.2 s of way and 0.3 s of standing");
        assert_eq!(ticks(0.000_1, 1.0, |_| 0.4), None);
        assert_eq!(ticks(0.001, 1.0, |_| 0.4), None);
    }

    #[test]
    fn a_motor_led_against_a_stop_stalls() {
        assert!(ticks(0.001, 0.1, |tick| 0.000_7 * f64::from(tick)).is_some());
        assert_eq!(ticks(0.001, 9.0, |tick| 0.000_7 * f64::from(tick)), None);
    }

    #[test]
    fn the_rest_under_load_is_no_stall() {
        assert_eq!(ticks(0.001, 0.1, |_| 0.12), None);
    }
}
