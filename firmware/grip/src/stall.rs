//! Whether a motor gets where it is moved.

/// How firmly a servo's position control holds a load, which it does by its error: counts of the servo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Firmness {
    /// Error at which it gives all it has. Below that a motor at rest may just hold its load by the error.
    pub all: f64,
    /// Error per mA of its current.
    pub per_milliampere: f64,
    /// Error that makes up for its friction.
    pub friction: f64,
}

impl Firmness {
    /// The XM430-W350 with the factory's gain: 29 N·mm per count, 1.79 N·mm/mA, 233 N·mm.
    pub const XM430: Self = Self { all: 141.6, per_milliampere: 1.79 / 29.0, friction: 233.0 / 29.0 };

    /// Distance of goal and motor that makes this current (mA), rad.
    pub(crate) fn explained(&self, current: f64, count: f64) -> f64 {
        self.per_milliampere * current.abs() * count
    }
}

/// How much further away the goal may go while the motor does not move, errors of the friction: twice the friction alone when the motion
/// turns round.
const FAR: f64 = 2.85;
/// The same in counts, at least: a firm servo overcomes its friction within a count, but goal and position are whole counts, and the goal is
/// a tick ahead.
const LEAST: f64 = 4.0;
/// Time without a count of progress after which it has, s.
const LONG: f64 = 0.3;

/// Watches a motor. Angles in rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stall {
    /// Where it was last seen to move, and the least distance of the goal since.
    at: f64,
    away: f64,
    /// For how long it has not moved since, s.
    since: f64,
}

impl Stall {
    /// Nothing seen.
    pub const NONE: Self = Self { at: f64::INFINITY, away: 0.0, since: 0.0 };

    /// A tick of so many seconds with an answer and a current, mA; whether the motor is stalled.
    pub fn is_stalled(
        &mut self,
        firmness: &Firmness,
        goal: f64,
        angle: f64,
        current: f64,
        count: f64,
        seconds: f64,
    ) -> bool {
        let away = (goal - angle).abs();
        if (angle - self.at).abs() > 0.5 * count {
            *self = Self { at: angle, away, since: 0.0 };
            return false;
        }
        self.away = self.away.min(away);
        let far = (FAR * firmness.friction).max(LEAST) * count;
        let explained = far + 1.5 * firmness.explained(current, count);
        if away < explained.min(firmness.all * count) && away - self.away < far {
            self.since = 0.0;
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
        ticks_at(0.0, pace, stop, goal)
    }

    /// The same with a current, mA.
    fn ticks_at(current: f64, pace: f64, stop: f64, goal: impl Fn(u32) -> f64) -> Option<u32> {
        let (mut stall, mut angle) = (Stall::NONE, 0.0_f64);
        (0..5000).find(|&tick| {
            angle = (angle + pace).min(stop).min(goal(tick));
            stall.is_stalled(&Firmness::XM430, goal(tick), angle, current, COUNT, TICK)
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

    /// With the factory's gain a servo holds 3 N·m by 110 counts.
    #[test]
    fn the_rest_under_load_is_no_stall() {
        assert_eq!(ticks(0.001, 0.1, |_| 0.12), None);
        assert_eq!(ticks_at(1_800.0, 0.001, 0.1, |_| 0.1 + 110.0 * COUNT), None);
        assert!(ticks_at(1_800.0, 0.001, 0.1, |_| 0.1 + 150.0 * COUNT).is_some(), "all it has, and no motion");
        assert!(ticks_at(300.0, 0.001, 0.1, |_| 0.1 + 110.0 * COUNT).is_some(), "a motor that is kept weak");
    }

    /// With its greatest gain a servo holds 3 N·m by 5 counts, and stays up to two away from its goal where it is let rest.
    #[test]
    fn a_firm_servo_may_rest_beside_its_goal() {
        let firm = Firmness { all: 6.9, per_milliampere: 1.79 / 594.0, friction: 0.39 };
        let stalls = |away: f64, tick: u32| {
            let mut stall = Stall::NONE;
            (0..tick).any(|_| stall.is_stalled(&firm, 0.1 + away * COUNT, 0.1, 200.0, COUNT, TICK))
        };
        assert!(!stalls(1.5, 5000) && !stalls(3.0, 5000));
        assert!(stalls(6.0, 200));
    }

    /// A goal that turns round has to go through the friction before the motor follows.
    #[test]
    fn friction_is_no_stall() {
        let (mut stall, mut goal) = (Stall::NONE, 0.1);
        for tick in 0..2000 {
            goal += if tick < 160 { -0.1 * COUNT } else { 0.0 };
            assert!(!stall.is_stalled(&Firmness::XM430, goal, 0.085, 0.0, COUNT, TICK));
        }
    }
}
