//! How far a goal is ahead of its motor: what of the way is still to come, without what the load keeps back for good.

/// Time without a motion after which the motor has arrived, s: longer than a servo takes to begin one.
const STILL: f64 = 0.02;
/// ... and readings, for slow loops.
const READINGS: u8 = 3;

/// Watches goal and motor. Angles in rad.
#[derive(Clone, Copy, Debug)]
pub struct Lag {
    /// What the load keeps back: goal less angle when the motor last was still.
    sag: f64,
    goal: f64,
    angle: f64,
    since: f64,
    readings: u8,
}

impl Lag {
    /// Nothing seen; a motor that is held where it is.
    pub const NONE: Self = Self { sag: 0.0, goal: f64::NAN, angle: f64::NAN, since: 0.0, readings: 0 };

    /// What the load kept back when the motor was last at rest, rad; positive if it pushes the motor open.
    pub fn sag(&self) -> f64 {
        self.sag
    }

    /// A reading, so many seconds after the last one: what of the way to the goal is still to come.
    pub fn ahead(&mut self, goal: f64, angle: f64, count: f64, seconds: f64) -> f64 {
        let same = |a: f64, b: f64| (a - b).abs() <= 0.5 * count;
        if same(goal, self.goal) && same(angle, self.angle) {
            self.since += seconds;
            self.readings = self.readings.saturating_add(1);
            if self.since >= STILL && self.readings >= READINGS {
                self.sag = goal - angle;
            }
        } else {
            (self.goal, self.angle, self.since, self.readings) = (goal, angle, 0.0, 0);
        }
        goal - angle - self.sag
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const COUNT: f64 = 0.0015;
    const TICK: f64 = 0.002;

    #[test]
    fn what_the_load_keeps_back_is_not_to_come() {
        let mut lag = Lag::NONE;
        for step in 0..100 {
            let goal = f64::from(step) * COUNT;
            let ahead = lag.ahead(goal, goal - 6.0 * COUNT, COUNT, TICK);
            assert!((ahead - 6.0 * COUNT).abs() < 1e-9, "a motor that moves may still get there: {ahead}");
        }
        let goal = 99.0 * COUNT;
        let last = (0..20).map(|_| lag.ahead(goal, goal - 4.0 * COUNT, COUNT, TICK)).last();
        assert_eq!(last, Some(0.0));
        assert!((lag.ahead(goal + 2.0 * COUNT, goal - 4.0 * COUNT, COUNT, TICK) - 2.0 * COUNT).abs() < 1e-9);
    }

    #[test]
    fn a_motor_that_has_not_begun_is_not_still() {
        let mut lag = Lag::NONE;
        lag.ahead(0.0, 0.0, COUNT, TICK);
        let ahead = (0..5).map(|_| lag.ahead(3.0 * COUNT, 0.0, COUNT, TICK)).last();
        assert_eq!(ahead, Some(3.0 * COUNT));
    }
}
