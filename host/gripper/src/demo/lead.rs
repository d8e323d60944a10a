//! How the finger is moved: closing and opening, over and over, each way in the time it has.
//!
//! The gripper follows its own clock, and a simulated one may be slow: where the goal lags, the speed is raised.

/// Motor angles of the open and the closed finger, degrees.
pub const OPEN_DEG: f64 = -3.0;
/// See [`OPEN_DEG`].
pub const CLOSED_DEG: f64 = 11.0;
/// Rest at either end, s.
const REST: f64 = 0.3;
/// Time left over at the end, s.
const SPARE: f64 = 0.3;
/// A closing and opening takes about so long, s, if there is time for several.
const CYCLE: f64 = 10.0;
/// Greatest speed, degrees/s.
const FASTEST: f64 = 40.0;
/// How often the speed may be raised, s, and how much too slow it must be.
const PATIENCE: f64 = 0.25;
const TOO_SLOW: f64 = 1.15;
/// The gripper's time does not pass more slowly than this.
const SLOWEST_PACE: f64 = 0.1;
/// Distance at which the goal has arrived, degrees.
const ARRIVED: f64 = 1e-3;

/// What the gripper is sent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Order {
    /// Where to, degrees.
    pub angle_deg: f64,
    /// How fast, degrees/s.
    pub speed_deg: f64,
}

/// Leads the finger. Times in s since the beginning.
#[derive(Clone, Copy, Debug)]
pub struct Lead {
    /// Time for a way, its rest included.
    way: f64,
    /// Ways that are done.
    done: u32,
    /// Ways there are.
    ways: u32,
    speed: f64,
    /// When the last order was given, and where the goal was.
    ordered: [f64; 2],
    /// The gripper's time per ours.
    pace: f64,
    arrived: Option<f64>,
    begun: bool,
}

impl Lead {
    /// For so many seconds.
    pub fn new(seconds: f64) -> Self {
        let cycles = (seconds / CYCLE).round().max(1.0);
        let way = (seconds - SPARE) / (2.0 * cycles);
        let planned = (CLOSED_DEG - OPEN_DEG) / (way - REST);
        Self {
            way,
            done: 0,
            ways: 2 * cycles as u32,
            speed: planned,
            ordered: [0.0, OPEN_DEG],
            pace: 1.0,
            arrived: None,
            begun: false,
        }
    }

    /// Whether the finger has closed and opened once.
    pub fn is_round(&self) -> bool {
        self.done >= 2
    }

    /// Whole closings and openings so far.
    pub fn cycles(&self) -> u32 {
        self.done / 2
    }

    /// Planned closings and openings.
    pub fn planned(&self) -> u32 {
        self.ways / 2
    }

    /// Planned speed, degrees/s.
    pub fn speed_deg(&self) -> f64 {
        self.speed
    }

    /// What to tell the gripper now, if anything; `goal_deg` is where it leads its motor.
    pub fn step(&mut self, now: f64, goal_deg: f64) -> Option<Order> {
        if self.done >= self.ways {
            return None;
        }
        let target = if self.done.is_multiple_of(2) { CLOSED_DEG } else { OPEN_DEG };
        let left = (target - goal_deg).abs();
        // What is left of the way's time.
        let time = (self.way * f64::from(self.done + 1) - REST - now).max(0.1);
        if !self.begun {
            self.begun = true;
            return Some(self.order(target, [now, goal_deg], left / time));
        }
        if left <= ARRIVED {
            let since = *self.arrived.get_or_insert(now);
            if now - since >= REST {
                self.done += 1;
                self.arrived = None;
                self.begun = false;
                return self.step(now, goal_deg);
            }
            return None;
        }
        let [since, from] = self.ordered;
        if now - since < PATIENCE {
            return None;
        }
        let reached = (goal_deg - from).abs() / (now - since);
        self.pace = (reached / self.speed).clamp(SLOWEST_PACE, 1.0);
        let needed = left / time;
        (needed > TOO_SLOW * reached && self.speed < FASTEST).then(|| self.order(target, [now, goal_deg], needed))
    }

    /// To be there at a speed by our time.
    fn order(&mut self, angle_deg: f64, at: [f64; 2], speed: f64) -> Order {
        self.ordered = at;
        self.speed = (speed / self.pace).clamp(0.1, FASTEST);
        Order { angle_deg, speed_deg: self.speed }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs a gripper whose time passes at a share of ours; gives the time at which each way was done.
    fn ways(seconds: f64, pace: f64) -> Vec<f64> {
        let mut lead = Lead::new(seconds);
        let (mut goal, mut order) = (OPEN_DEG, None::<Order>);
        let mut done = Vec::new();
        let mut now = 0.0;
        while now < seconds {
            if let Some(new) = lead.step(now, goal) {
                order = Some(new);
            }
            while done.len() < lead.done as usize {
                done.push(now);
            }
            if let Some(Order { angle_deg, speed_deg }) = order {
                let reach = speed_deg * 0.01 * pace;
                goal += (angle_deg - goal).clamp(-reach, reach);
            }
            now += 0.01;
        }
        done
    }

    #[test]
    fn every_duration_has_whole_cycles() {
        for seconds in [4.0, 8.0, 20.0, 60.0, 600.0] {
            let cycles = Lead::new(seconds).planned() as usize;
            assert!(cycles >= 1);
            assert_eq!(ways(seconds, 1.0).len(), 2 * cycles, "{seconds} s");
        }
    }

    #[test]
    fn a_slow_gripper_is_led_faster() {
        for pace in [0.2, 0.5, 0.9] {
            assert_eq!(ways(20.0, pace).len(), 4, "at {pace} of our time");
            assert_eq!(ways(8.0, pace).len(), 2, "at {pace} of our time");
        }
    }

    #[test]
    fn a_gripper_that_stands_still_never_arrives() {
        assert_eq!(ways(20.0, 0.0).len(), 0);
    }
}
