//! Where a finger's motor is moved: to an angle, or until the estimated force is the one asked for, and never further than
//! its limits allow.
//!
//! A pure state machine. Every tick [`Grip::advance`] gives the motor's goal, and then either [`Grip::feel`] takes what
//! the servo's answer amounts to or [`Grip::miss`] that there was none.
//!
//! The force is controlled by integration: with ΔF what is missing and dF/dα the force's slope over the motor angle, the
//! goal moves by [`GAIN`] · ΔF / (dF/dα) a tick, by no more than the speed asked for, and never further ahead of the motor
//! than what is missing. Where the servo's next count would be too much, the finger stays below. Without an answer the goal
//! does not move, so nothing winds up.
//!
//! Under a material that relaxes the force fades while the motor rests. A finger that has gripped then goes on count by count, by the mean
//! of what is missing.
//!
//! A servo with a proportional gain only holds a load by an error: the motor stays below its goal by its sag, and follows late. Force and
//! limits are the motor's, so the goal goes beyond them by the sag that was seen when the motor was last at rest ([`Lag`]), and the rest
//! of the error counts as way that is still to come. A finger that is near goes back with its goal to stop there at once, and has
//! gripped when it is at rest. Angles in rad, forces in N.

use crate::lag::Lag;
use crate::motion::Motion;
use crate::slope::Slope;
use crate::stall::{Firmness, Stall};
use crate::{Faults, Limits, Phase, Reaction, Target, Why};

/// Part of what is missing by which the goal moves in a tick. An integrator with a delay of two ticks (the answer's and the
/// servo's) does not overshoot below 4/27.
const GAIN: f64 = 0.12;
/// What is missing at most when the force counts as reached, counts of the servo. The nearest count is within 0.5.
const REACHED: f64 = 0.6;
/// What may be missing before the finger follows again, counts, and as part of the force: neither rounding nor the ripple
/// of the estimate moves a finger that holds something.
const LEFT: (f64, f64) = (1.0, 0.03);
/// What the next count may give too much, as part of the force: the estimate's own error and its slope's come on top.
const OVER: f64 = 0.06;
/// How the goal moves in contact as long as no slope is known, counts a tick.
const CREEP: f64 = 0.1;

/// Time over which the mean of what is missing is taken under a material that relaxes, s: noise, ripple and a tick's error move nothing.
const MEAN: f64 = 0.25;
/// What may be missing in that mean before the goal goes on by a count, counts: more than half of one, or the finger would hunt.
const RELAXED: f64 = 0.6;
/// What is missing at most for which the mean counts, counts: noise is less.
const MEANT: f64 = 3.0;

/// What one tick shows about a finger.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// Measured motor angle.
    pub angle: f64,
    /// Estimated force (magnitude); nothing if it is untrustworthy.
    pub force: Option<f64>,
    /// Slope of the force over the motor angle, N/rad, if the model knows it.
    pub slope: Option<f64>,
    /// Whether there is a finger and an object to estimate a force from.
    pub has_model: bool,
    /// Current, mA; positive drives towards closing.
    pub current: f32,
    /// How firmly the servo holds.
    pub firmness: Firmness,
    /// The servo has a hardware error.
    pub alert: bool,
    /// The part of its force that the finger may use.
    pub part: f64,
    /// Why it may neither close nor grip: its servo is about to shut down.
    pub stop: Option<Why>,
    /// The force fades under a material that relaxes, while the motor rests.
    pub relaxes: bool,
}

/// Leads one finger's motor.
#[derive(Clone, Debug)]
pub struct Grip {
    phase: Phase,
    motion: Motion,
    /// What was asked for, while it grips.
    asked: Option<Asked>,
    /// It has gripped, and only waits since, if it does not hold.
    has_gripped: bool,
    /// How far the next tick leads the motor on, rad.
    stride: f64,
    /// The way that the motor has not come yet, rad: the goal goes back by it at once to stop the motor where it is.
    ahead: f64,
    /// How far the goal may go beyond the angle's limit, rad: the motor stays below it by so much.
    beyond: f64,
    slope: Slope,
    lag: Lag,
    stall: Stall,
    /// Mean of the way that was missing under a grip that relaxes, rad.
    relaxed: f64,
    /// What is left of the count by which such a grip goes on, rad.
    creep: f64,
    /// For how long it has closed without a trustworthy estimate, s.
    untrusted: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Asked {
    force: f64,
    speed: f64,
    limit: f64,
    /// The force is a step on the way to one that bears a weight.
    carries: bool,
    /// It is the last step, as far as is known.
    is_enough: bool,
    /// The force was there once: something is held, whatever the finger waits for or follows now.
    was_reached: bool,
}

impl Grip {
    /// Nowhere to go.
    pub const REST: Self = Self {
        phase: Phase::Held(Why::Asked),
        motion: Motion::REST,
        asked: None,
        has_gripped: false,
        stride: 0.0,
        ahead: 0.0,
        beyond: 0.0,
        slope: Slope::NONE,
        lag: Lag::NONE,
        stall: Stall::NONE,
        relaxed: 0.0,
        creep: 0.0,
        untrusted: 0.0,
    };

    /// The servo was found, with this goal. It keeps that whatever was asked before: nobody knows what has happened meanwhile.
    pub fn found(&mut self, goal: f64) {
        let lost = self.phase != Self::REST.phase;
        *self = Self { phase: if lost { Phase::Held(Why::ServoLost) } else { self.phase }, ..Self::REST };
        self.motion.start(goal);
    }

    /// The motor stays where it is; its angle is called otherwise now.
    pub fn renamed(&mut self, goal: f64) {
        *self = Self { phase: Phase::Held(Why::Asked), ..Self::REST };
        self.motion.start(goal);
    }

    /// Goes to an angle.
    pub fn head(&mut self, angle: f64, speed: f64) {
        self.settle(Phase::Moving);
        self.motion.head(angle, speed);
    }

    /// Closes until the force is reached. Force, speed and limit are valid.
    pub fn grip(&mut self, to: &Target, limits: &Limits) {
        self.settle(Phase::Gripping);
        self.asked = Some(Asked {
            force: f64::from(to.force),
            speed: f64::from(to.speed.unwrap_or(limits.speed)),
            limit: f64::from(to.limit.unwrap_or(limits.range[1])),
            carries: false,
            is_enough: true,
            was_reached: false,
        });
        self.slope = Slope::NONE;
    }

    /// Takes new limits while it moves or grips: it goes on within them. No motion begins by that, but for a grip beyond its angle, which opens
    /// to it.
    pub fn restrict(&mut self, limits: &Limits) {
        let [least, most] = limits.range.map(f64::from);
        if let Some(asked) = &mut self.asked {
            asked.force = asked.force.min(f64::from(limits.force));
            asked.limit = asked.limit.min(most).max(least);
        }
        self.motion.restrict(least, most);
    }

    /// Closes as for a grip, to the first of several forces: it has gripped once [`Self::keep`] has ended that. Force, speed and limit are
    /// valid.
    pub fn carry(&mut self, to: &Target, limits: &Limits) {
        self.grip(to, limits);
        if let Some(asked) = &mut self.asked {
            (asked.carries, asked.is_enough) = (true, false);
        }
    }

    /// Presses with another force from now on, while it closes for a weight.
    pub fn press(&mut self, force: f64) {
        if let Some(asked) = self.asked.as_mut().filter(|asked| asked.carries) {
            (asked.force, asked.is_enough, asked.was_reached) = (force, false, false);
            self.has_gripped = false;
        }
    }

    /// Keeps the present force: it is enough for the weight.
    pub fn keep(&mut self) {
        if let Some(asked) = &mut self.asked {
            asked.is_enough = true;
        }
    }

    /// The force is at its limit, and the weight is not borne: it stays where it is.
    pub fn give_up(&mut self) {
        self.settle(Phase::Held(Why::Force));
    }

    /// Whether it closes, or has closed, for a weight.
    pub fn carries(&self) -> bool {
        self.asked.is_some_and(|asked| asked.carries)
    }

    /// Whether it rests at the force that is asked for, be it the last one or not.
    pub fn is_there(&self) -> bool {
        self.has_gripped && matches!(self.phase, Phase::Gripping | Phase::Gripped)
    }

    /// Stays where it is.
    pub fn hold(&mut self) {
        self.settle(Phase::Held(Why::Asked));
    }

    /// Its host has gone away. A finger that has gripped, or opens, goes on with that, also where it waits or follows just now.
    pub fn leave(&mut self, limits: &Limits, reaction: Reaction) {
        let is_on_its_way = match self.phase {
            Phase::Moving => self.motion.is_moving(),
            Phase::Gripping | Phase::Waiting(_) => !self.asked.is_some_and(|asked| asked.was_reached),
            Phase::Gripped | Phase::Held(_) | Phase::Released(_) | Phase::Relaxed => false,
        };
        if is_on_its_way {
            match reaction {
                Reaction::Hold => self.settle(Phase::Held(Why::Host)),
                Reaction::Release => self.release(Why::Host, limits),
            }
        }
    }

    /// Takes note that the torque is off: the goal follows the motor.
    pub fn relax(&mut self) {
        self.settle(Phase::Relaxed);
    }

    /// Opens.
    pub fn open(&mut self, limits: &Limits) {
        self.release(Why::Asked, limits);
    }

    /// What the finger is doing.
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// Whether a force was asked for.
    pub fn is_gripping(&self) -> bool {
        self.asked.is_some()
    }

    /// Where the motor is moved now.
    pub fn goal(&self) -> f64 {
        self.motion.goal()
    }

    /// One tick of so many seconds; returns the goal.
    pub fn advance(&mut self, seconds: f64, limits: &Limits) -> f64 {
        if let Some(Asked { speed, limit, .. }) = self.asked {
            let (goal, reach) = (self.motion.goal(), speed * seconds);
            let back = self.ahead.max(reach);
            let stride = self.stride.max(-back).min(reach);
            // A finger below its range closes only as far as its force wants that; one beyond its limit opens to it.
            let least = f64::from(limits.range[0]).min(goal);
            let to = (goal + stride).max(least).min((limit + self.beyond).max(least));
            self.motion.start(to.max(goal - back));
            self.creep = (self.creep - stride.max(0.0)).max(0.0);
            // Used once: a tick without an answer does not move the goal.
            self.stride = 0.0;
        }
        self.motion.step(seconds)
    }

    /// No answer came in this tick.
    pub fn miss(&mut self, limits: &Limits, reaction: Reaction) {
        // Nobody knows how far the motor has come meanwhile.
        self.ahead = 0.0;
        self.wrong(Why::Bus, limits, reaction);
    }

    /// An answer came. `count` is one count of the servo as an angle.
    pub fn feel(&mut self, touch: &Touch, count: f64, seconds: f64, limits: &Limits, faults: &Faults) {
        let reaction = faults.reaction;
        if self.phase == Phase::Relaxed {
            return self.motion.start(touch.angle);
        }
        let closing = self.asked.is_some() || self.motion.heading() > touch.angle;
        let ahead = self.lag.ahead(self.goal(), touch.angle, count, seconds);
        let is_within = self.asked.is_some_and(|asked| touch.angle <= asked.limit);
        (self.ahead, self.beyond) = (ahead, if is_within { self.lag.sag().max(0.0) } else { 0.0 });
        if touch.alert && (closing || self.phase == Phase::Moving) {
            return self.stop(Why::Alert, limits, reaction);
        }
        if let Some(why) = touch.stop
            && closing
            && (self.asked.is_some() || self.motion.is_moving())
        {
            return self.stop(why, limits, faults.strain);
        }
        if self.stall.is_stalled(&touch.firmness, self.goal(), touch.angle, f64::from(touch.current), count, seconds)
            && self.phase != Phase::Held(Why::Stall)
        {
            // A weak motor stays behind its goal by more than its torque explains: it must not jump there when its strength comes back.
            let held = touch.firmness.explained(f64::from(touch.current), count);
            self.motion.start(touch.angle + self.lag.sag().max(-held).min(held));
            self.ahead = 0.0;
            // A finger that cannot open stays: to release it would change nothing.
            let reaction = if closing { reaction } else { Reaction::Hold };
            return self.stop(Why::Stall, limits, reaction);
        }
        // What drives against the motion is no reason to stop it: a finger that opens has held something before.
        let driving = if closing { touch.current } else { -touch.current };
        if (closing || self.motion.is_moving()) && driving > limits.current {
            return self.stop(Why::Current, limits, Reaction::Hold);
        }
        let Some(force) = touch.force else {
            self.untrusted += seconds;
            // Without finger and object there is nothing to trust: the current's limit stands alone.
            let is_blind = touch.has_model && self.untrusted > faults.untrusted_s;
            if is_blind && closing && self.asked.is_none() && self.motion.is_moving() {
                return self.stop(Why::Estimate, limits, Reaction::Hold);
            }
            return self.wrong(Why::Estimate, limits, reaction);
        };
        self.untrusted = 0.0;
        self.slope.see(touch.angle, force, count);
        // The model's is of some ticks ago and the force is mostly convex, so that secants may be steeper; they alone see
        // how the estimate ripples.
        let known = touch.slope.filter(|slope| *slope > 0.0);
        let steepest = greater(known, self.slope.steepest());
        match self.asked {
            Some(asked) => {
                let mean = greater(known, self.slope.mean());
                let asked = Asked { force: asked.force * touch.part, ..asked };
                let passed = touch.relaxes.then_some(seconds);
                self.follow(&asked, force, [mean, steepest], [touch.angle, ahead], count, passed);
            }
            None if closing => self.guard(force, steepest, ahead, count, f64::from(limits.force) * touch.part),
            None => {}
        }
    }

    /// Moves the goal by what is missing. The slopes: on the whole, and the steepest; the motor: where it is, and how far
    /// the goal is ahead of it; `relaxing`: the tick's time, s, if the force fades by itself.
    fn follow(
        &mut self,
        asked: &Asked,
        force: f64,
        slopes: [Option<f64>; 2],
        motor: [f64; 2],
        count: f64,
        relaxing: Option<f64>,
    ) {
        let [angle, ahead] = motor;
        let missing = asked.force - force;
        // Without contact the speed is the only limit.
        let [way, safe] = slopes.map(|slope| match slope {
            Some(slope) if force > 0.0 => missing / slope,
            _ if force > 0.0 => (CREEP / GAIN * count).copysign(missing),
            _ => f64::INFINITY.copysign(missing),
        });
        let (near, part) = if self.has_gripped { LEFT } else { (REACHED, 0.0) };
        let meant = match relaxing {
            Some(seconds) if self.has_gripped && way.abs() <= MEANT * count => self.mean(way, seconds),
            _ => way,
        };
        let is_near = meant.abs() <= near * count || missing.abs() <= part * asked.force;
        // It still opens to its limit.
        let is_beyond = self.goal() > asked.limit && angle > asked.limit + count;
        // Less than a count is missing, and the next one would give too much.
        let next_is_over = (0.0..count).contains(&way) && missing * (count / way - 1.0) > OVER * asked.force;
        if !is_beyond && force > 0.0 && slopes[0].is_some() && (is_near || next_is_over) {
            self.has_gripped |= ahead.abs() <= 0.5 * count;
            let is_reached = self.has_gripped && asked.is_enough;
            self.phase = if is_reached { Phase::Gripped } else { Phase::Gripping };
            if let Some(asked) = &mut self.asked {
                asked.was_reached |= is_reached;
            }
            self.stride = match relaxing {
                _ if !self.has_gripped => -ahead,
                Some(_) if !next_is_over => self.follow_slowly(count),
                _ => 0.0,
            };
        } else if !is_beyond && way > 0.0 && self.goal() >= asked.limit && angle >= asked.limit - count {
            self.settle(Phase::Held(Why::Angle));
        } else {
            // A motor that follows late gets no goal beyond the one that it is to stop at.
            let room = safe - ahead;
            let stride = GAIN * safe;
            (self.has_gripped, self.relaxed, self.creep) = (false, 0.0, 0.0);
            (self.phase, self.stride) = (Phase::Gripping, if safe < 0.0 { stride.max(room) } else { stride.min(room) });
        }
    }

    /// Mean of the way that is missing, as a further tick shows it.
    fn mean(&mut self, way: f64, seconds: f64) -> f64 {
        self.relaxed += (way - self.relaxed) * seconds / (MEAN + seconds);
        self.relaxed
    }

    /// How far a grip that relaxes goes on, at most a count at a time. It does not go back, so that friction does not work against it to and fro.
    fn follow_slowly(&mut self, count: f64) -> f64 {
        if self.creep == 0.0 && self.relaxed >= RELAXED * count {
            self.relaxed -= count;
            self.creep = count;
        }
        self.creep
    }

    /// Stops a closing motion where the force would go beyond its limit.
    fn guard(&mut self, force: f64, slope: Option<f64>, ahead: f64, count: f64, most: f64) {
        // Where the goal is that keeps the motor where it is.
        let stands = self.goal() - ahead;
        let room = match slope {
            Some(slope) if force > 0.0 => (most - force) / slope,
            _ => f64::INFINITY.copysign(most - force),
        };
        if room <= count {
            self.settle(Phase::Held(Why::Force));
            // Back to where the limit is, should the goal be ahead of the motor.
            self.motion.start(self.goal().min(stands + room.max(-count).min(count)));
        } else {
            self.motion.cap(stands + room);
        }
    }

    /// Something is wrong for now.
    fn wrong(&mut self, why: Why, limits: &Limits, reaction: Reaction) {
        // Once, as it begins: a finger that holds does not give way to what pushes it open.
        self.stride = if self.phase == Phase::Gripping { -self.ahead.max(0.0) } else { 0.0 };
        if self.asked.is_none() {
            return;
        }
        match reaction {
            Reaction::Hold => self.phase = Phase::Waiting(why),
            Reaction::Release => self.release(why, limits),
        }
    }

    /// Something is wrong that does not pass by itself.
    fn stop(&mut self, why: Why, limits: &Limits, reaction: Reaction) {
        match reaction {
            Reaction::Release if self.asked.is_some() => self.release(why, limits),
            _ => self.settle(Phase::Held(why)),
        }
    }

    fn release(&mut self, why: Why, limits: &Limits) {
        self.settle(Phase::Released(why));
        self.motion.head(f64::from(limits.open_angle), f64::from(limits.speed));
    }

    fn settle(&mut self, phase: Phase) {
        let is_on_its_way = matches!(self.phase, Phase::Moving | Phase::Gripping | Phase::Released(_));
        if is_on_its_way && !matches!(phase, Phase::Moving | Phase::Gripping) {
            self.motion.start(self.motion.goal() - self.ahead);
        }
        (self.phase, self.ahead) = (phase, 0.0);
        (self.asked, self.has_gripped, self.stride) = (None, false, 0.0);
        (self.relaxed, self.creep) = (0.0, 0.0);
        self.motion.hold();
        self.stall = Stall::NONE;
    }
}

/// The greater one of those that are known.
fn greater(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    a.into_iter().chain(b).reduce(f64::max)
}

#[cfg(test)]
mod tests;
