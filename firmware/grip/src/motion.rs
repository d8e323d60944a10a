//! Where the motor is moved: a ramp towards a target, with a speed.
//!
//! It advances by ticks in which the servo answered, so it never runs ahead of a servo that does not.

/// The ramp. Angles in rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    goal: f64,
    target: Option<f64>,
    /// How far towards the target it may go for now.
    most: f64,
    speed: f64,
}

impl Motion {
    /// Nowhere to go.
    pub const REST: Self = Self { goal: 0.0, target: None, most: f64::INFINITY, speed: 0.0 };

    /// Starts, or starts again, where the motor is: a target stays, without one the motor is held there.
    pub fn start(&mut self, angle: f64) {
        self.goal = angle;
    }

    /// Heads for a target with a speed (rad/s, positive).
    pub fn head(&mut self, target: f64, speed: f64) {
        self.target = Some(target);
        (self.most, self.speed) = (f64::INFINITY, speed);
    }

    /// A target outside a new range becomes the range's end, or where the goal is, if that is beyond it.
    pub fn restrict(&mut self, least: f64, most: f64) {
        let (least, most) = (least.min(self.goal), most.max(self.goal));
        self.target = self.target.map(|target| target.min(most).max(least));
    }

    /// Goes no further than this for now; the target stays.
    pub fn cap(&mut self, most: f64) {
        self.most = most;
    }

    /// Where it ends.
    pub fn heading(&self) -> f64 {
        self.target.unwrap_or(self.goal)
    }

    /// Stays where it is.
    pub fn hold(&mut self) {
        self.target = None;
    }

    /// Advances by a time (s) and returns the goal.
    pub fn step(&mut self, seconds: f64) -> f64 {
        if let Some(target) = self.target {
            let reach = self.speed * seconds;
            let target = target.min(self.most);
            let way = target - self.goal;
            self.goal = if way > reach {
                self.goal + reach
            } else if way < -reach {
                self.goal - reach
            } else {
                target
            };
        }
        self.goal
    }

    /// Where the motor is moved now.
    pub fn goal(&self) -> f64 {
        self.goal
    }

    /// Whether the goal is still on its way.
    pub fn is_moving(&self) -> bool {
        self.target.is_some_and(|target| target != self.goal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_takes_the_time_the_speed_says() {
        let mut motion = Motion::REST;
        motion.start(0.1);
        motion.head(0.3, 0.5);
        let mut ticks = 0;
        let mut last = 0.1;
        while motion.is_moving() {
            let goal = motion.step(0.002);
            assert!(goal > last && goal - last <= 0.001 + 1e-12);
            last = goal;
            ticks += 1;
        }
        assert_eq!(last, 0.3);
        assert!((200..=201).contains(&ticks), "{ticks} ticks for 0.4 s");
        assert_eq!(motion.step(0.002), 0.3);
    }

    #[test]
    fn a_new_target_turns_it_round() {
        let mut motion = Motion::REST;
        motion.head(1.0, 1.0);
        motion.step(0.25);
        motion.head(-1.0, 2.0);
        assert_eq!(motion.step(0.25), -0.25);
        motion.hold();
        assert_eq!(motion.step(10.0), -0.25);
        assert!(!motion.is_moving());
    }

    #[test]
    fn a_new_range_turns_nothing_round() {
        for (goal, target, range, heading) in [
            (0.1, 0.3, [0.0, 0.2], 0.2),
            (0.1, 0.3, [0.0, 0.05], 0.1),
            (0.1, -0.3, [-0.2, 0.05], -0.2),
            (0.1, 0.3, [-0.5, 0.5], 0.3),
        ] {
            let mut motion = Motion::REST;
            motion.start(goal);
            motion.head(target, 1.0);
            motion.restrict(range[0], range[1]);
            assert_eq!(motion.heading(), heading, "to {target} within {range:?}");
            motion.hold();
            motion.restrict(range[0], range[1]);
            assert_eq!((motion.heading(), motion.is_moving()), (goal, false));
        }
    }

    #[test]
    fn after_a_loss_it_goes_on_from_where_the_motor_is() {
        let mut motion = Motion::REST;
        motion.head(1.0, 1.0);
        motion.step(0.9);
        motion.start(0.2);
        assert!((motion.step(0.1) - 0.3).abs() < 1e-12);
        assert!(motion.is_moving());
    }

    #[test]
    fn without_a_target_the_motor_is_held() {
        let mut motion = Motion::REST;
        motion.start(0.7);
        assert_eq!(motion.step(1.0), 0.7);
        assert!(!motion.is_moving());
    }
}
