//! The position profile of the servo's firmware: from where the trajectory is, at the speed it has, to the goal.
//!
//! Velocity-based profiles are those of the e-Manual ("What is the Profile"): a step without Profile Velocity, a
//! rectangle of speed without Profile Acceleration, a trapezoid (or triangle) with both. A goal that arrives while the
//! servo moves starts from the present speed; where the goal lies within the stopping distance or behind, the servo stops
//! first.

/// Speed of one unit of Profile Velocity, Present Velocity and the like (0.229 rev/min), counts/s.
pub const SPEED_UNIT: f64 = 0.229 * 4096.0 / 60.0;
/// Acceleration of one unit of Profile Acceleration (214.577 rev/min²), counts/s².
pub const ACCELERATION_UNIT: f64 = 214.577 * 4096.0 / 3600.0;

/// Shape of a profile, with its bits of Moving Status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The trajectory is at the goal at once.
    Step,
    /// Full speed at once.
    Rectangular,
    /// The full speed is not reached.
    Triangular,
    /// Accelerate, keep the speed, brake.
    Trapezoidal,
}

impl Kind {
    /// Bits 4 and 5 of Moving Status.
    pub fn bits(self) -> u8 {
        match self {
            Self::Step => 0,
            Self::Rectangular => 0x10,
            Self::Triangular => 0x20,
            Self::Trapezoidal => 0x30,
        }
    }
}

/// Limits of a profile; 0 means unlimited.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Greatest speed, counts/s.
    pub speed: f64,
    /// Acceleration, counts/s².
    pub acceleration: f64,
}

impl Limits {
    /// Of a time-based profile over a distance: `total_ms` for all of it, `ramp_ms` (at most half) for the acceleration.
    pub fn timed(distance: f64, total_ms: f64, ramp_ms: f64) -> Self {
        let total = total_ms / 1000.0;
        if total <= 0.0 {
            return Self { speed: 0.0, acceleration: 0.0 };
        }
        let ramp = (ramp_ms / 1000.0).min(total / 2.0);
        let speed = distance.abs() / (total - ramp);
        Self { speed, acceleration: if ramp > 0.0 { speed / ramp } else { 0.0 } }
    }
}

/// A stretch of constant acceleration.
#[derive(Clone, Copy, Debug, Default)]
struct Piece {
    duration: f64,
    speed: f64,
    acceleration: f64,
}

/// A trajectory over time: position in counts, time in seconds from its beginning.
#[derive(Clone, Copy, Debug)]
pub struct Profile {
    start: f64,
    goal: f64,
    kind: Kind,
    pieces: [Piece; 4],
}

impl Profile {
    /// Rest at a position.
    pub fn at(position: f64) -> Self {
        Self { start: position, goal: position, kind: Kind::Step, pieces: [Piece::default(); 4] }
    }

    /// From `start` at `speed` (counts/s, signed) to `goal`.
    pub fn new(start: f64, speed: f64, goal: f64, limits: Limits) -> Self {
        let rest = Self { start, goal, ..Self::at(goal) };
        let Limits { speed: top, acceleration } = limits;
        if top <= 0.0 {
            return rest;
        }
        if acceleration <= 0.0 {
            let distance = goal - start;
            let cruise = Piece { duration: distance.abs() / top, speed: top.copysign(distance), acceleration: 0.0 };
            return Self {
                kind: Kind::Rectangular,
                pieces: [cruise, Piece::default(), Piece::default(), Piece::default()],
                ..rest
            };
        }
        // Stop first if the goal is behind, or too near to stop in time.
        let stopping = speed * speed / (2.0 * acceleration);
        let mut pieces = [Piece::default(); 4];
        let (from, speed) = if speed != 0.0 && (goal - start) * speed.signum() < stopping {
            pieces[0] =
                Piece { duration: speed.abs() / acceleration, speed, acceleration: -acceleration.copysign(speed) };
            (start + stopping.copysign(speed), 0.0)
        } else {
            (start, speed)
        };
        let distance = (goal - from).abs();
        let sign = if goal < from { -1.0 } else { 1.0 };
        let first = speed.abs();
        let peak = top.min((acceleration * distance + first * first / 2.0).sqrt());
        let ramp = (peak - first).abs() / acceleration;
        let covered = (peak + first) / 2.0 * ramp + peak * peak / (2.0 * acceleration);
        let cruise = if peak > 0.0 { ((distance - covered) / peak).max(0.0) } else { 0.0 };
        let change = if peak < first { -acceleration } else { acceleration };
        pieces[1] = Piece { duration: ramp, speed: sign * first, acceleration: sign * change };
        pieces[2] = Piece { duration: cruise, speed: sign * peak, acceleration: 0.0 };
        pieces[3] = Piece { duration: peak / acceleration, speed: sign * peak, acceleration: -sign * acceleration };
        let kind = if peak < top { Kind::Triangular } else { Kind::Trapezoidal };
        Self { kind, pieces, ..rest }
    }

    /// Its shape.
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// Where it ends, counts.
    pub fn goal(&self) -> f64 {
        self.goal
    }

    /// Seconds from beginning to end.
    pub fn duration(&self) -> f64 {
        self.pieces.iter().map(|piece| piece.duration).sum()
    }

    /// Position (counts) and speed (counts/s) after so many seconds.
    pub fn after(&self, seconds: f64) -> (f64, f64) {
        let mut position = self.start;
        let mut rest = seconds.max(0.0);
        for piece in &self.pieces {
            if rest < piece.duration {
                let speed = piece.speed + piece.acceleration * rest;
                return (position + (piece.speed + speed) / 2.0 * rest, speed);
            }
            rest -= piece.duration;
            position += (piece.speed + piece.acceleration * piece.duration / 2.0) * piece.duration;
        }
        (self.goal, 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits = Limits { speed: 400.0, acceleration: 1000.0 };

    /// Position and speed never jump, and neither limit is broken.
    fn check(profile: &Profile, first: (f64, f64), limits: Limits) {
        let step = 1e-4;
        let (mut position, mut speed) = profile.after(0.0);
        assert!((position - first.0).abs() < 1e-9 && (speed - first.1).abs() < 1e-9);
        let mut time = 0.0;
        while time < profile.duration() + 0.01 {
            time += step;
            let (next, fast) = profile.after(time);
            assert!((fast - speed).abs() <= limits.acceleration * step * 1.001, "speed jumps at {time}");
            assert!((next - position - (fast + speed) / 2.0 * step).abs() < 1e-4, "position jumps at {time}");
            (position, speed) = (next, fast);
        }
        assert_eq!((position, speed), (profile.goal(), 0.0));
    }

    #[test]
    fn a_trapezoid_takes_the_analytic_time() {
        let profile = Profile::new(100.0, 0.0, 1100.0, LIMITS);
        assert_eq!(profile.kind(), Kind::Trapezoidal);
        assert!((profile.duration() - (1000.0 / 400.0 + 400.0 / 1000.0)).abs() < 1e-12);
        check(&profile, (100.0, 0.0), LIMITS);
        let back = Profile::new(1100.0, 0.0, 100.0, LIMITS);
        assert!((back.duration() - 2.9).abs() < 1e-12);
        check(&back, (1100.0, 0.0), LIMITS);
    }

    #[test]
    fn a_short_way_is_a_triangle() {
        let profile = Profile::new(0.0, 0.0, 40.0, LIMITS);
        assert_eq!(profile.kind(), Kind::Triangular);
        assert!((profile.duration() - 2.0 * (40.0f64 / 1000.0).sqrt()).abs() < 1e-12);
        check(&profile, (0.0, 0.0), LIMITS);
    }

    #[test]
    fn a_goal_on_the_way_keeps_the_speed() {
        for (speed, goal) in [(300.0, 500.0), (300.0, 10.0), (300.0, -200.0), (-300.0, 200.0), (900.0, 900.0)] {
            check(&Profile::new(0.0, speed, goal, LIMITS), (0.0, speed), LIMITS);
        }
    }

    #[test]
    fn other_shapes() {
        let step = Profile::new(0.0, 0.0, 50.0, Limits { speed: 0.0, acceleration: 5.0 });
        assert_eq!((step.kind(), step.duration(), step.after(0.0)), (Kind::Step, 0.0, (50.0, 0.0)));
        let rectangle = Profile::new(0.0, 0.0, -50.0, Limits { speed: 100.0, acceleration: 0.0 });
        assert_eq!((rectangle.kind(), rectangle.duration()), (Kind::Rectangular, 0.5));
        assert_eq!(rectangle.after(0.25), (-25.0, -100.0));
        let timed = Profile::new(0.0, 0.0, 300.0, Limits::timed(300.0, 2000.0, 500.0));
        assert!((timed.duration() - 2.0).abs() < 1e-12);
        let nothing = Profile::new(7.0, 0.0, 7.0, LIMITS);
        assert_eq!((nothing.duration(), nothing.after(1.0)), (0.0, (7.0, 0.0)));
    }
}
