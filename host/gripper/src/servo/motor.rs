//! Motor, gears and finger: follows the trajectory as far as the motor's strength allows.
//!
//! Figures are those of ROBOTIS' [e-Manual](https://emanual.robotis.com/docs/en/dxl/x/xm430-w350/) at 12 V: stall torque
//! 4.1 N·m (2.3 A), 46 rev/min without load. Torque over current is a straight line in its performance graph, read at
//! (0.60 A, 0.84 N·m) and (1.50 A, 2.45 N·m) on ROBOTIS'
//! [forum](https://forum.robotis.com/t/calculation-of-torque-value-of-xm430-w350-t/5827): 1.79 N·m/A behind a dead zone of
//! 0.23 N·m. (The ratio of the two stall figures, 4.1 N·m / 2.3 A = 1.78 N·m/A, agrees.) The dead zone is the friction of
//! the gears: it adds to the load while the motor drives against it and helps to hold it afterwards.

use std::sync::Arc;

use super::load::{Contact, Load, OnBranch};
use super::profile::Profile;

/// Torque over current, N·mm/A.
pub const TORQUE_CONSTANT: f64 = (2.45 - 0.84) / (1.50 - 0.60) * 1000.0;
/// Friction, seen as a dead zone of the current, N·mm.
pub const FRICTION: f64 = TORQUE_CONSTANT * 0.60 - 840.0;
/// Stall torque at 12 V, N·mm.
pub const STALL_TORQUE: f64 = 4_100.0;
/// Speed without load at 12 V, counts/s.
pub const FREE_SPEED: f64 = 46.0 * 4096.0 / 60.0;
/// The way over which the friction turns around, counts. An assumption: one count.
const TURN_AROUND: f64 = 1.0;
/// The longest step in time, s.
const STEP: f64 = 5e-4;
/// Distance to the trajectory beyond which the servo does not follow it, counts. An assumption: about 2°.
const FOLLOWING: f64 = 24.0;

/// From encoder counts to the finger's angle.
#[derive(Clone, Debug)]
pub struct Gear {
    /// Counts at which the finger's angle is 0.
    pub zero: f64,
    /// 1 if greater positions close the finger, otherwise -1.
    pub direction: f64,
    /// Radians per count.
    pub pitch: f64,
    /// Half of the play, counts.
    pub half_play: f64,
}

/// Where motor and finger are, in counts of the encoder, and what they feel.
#[derive(Clone, Debug)]
pub struct Motor {
    gear: Gear,
    load: Arc<Load>,
    branch: OnBranch,
    /// Position of the motor, counts.
    pub position: f64,
    /// Speed, counts/s.
    pub speed: f64,
    /// Position of the finger, counts: within the play of the motor's.
    pub finger: f64,
    /// What the finger feels.
    pub contact: Contact,
    /// Direction of the friction, -1 to 1: the sign of the motion before.
    friction: f64,
    /// Seconds for which the motor has been too weak.
    pub overloaded: f64,
}

/// What the motor is told to do.
#[derive(Clone, Copy, Debug)]
pub struct Drive {
    /// Whether the motor is on.
    pub on: bool,
    /// Greatest torque of the motor, N·mm.
    pub torque: f64,
}

impl Motor {
    /// A motor at rest.
    pub fn new(gear: Gear, load: Arc<Load>, position: f64) -> Self {
        let mut motor = Self {
            gear,
            branch: OnBranch::default(),
            position,
            speed: 0.0,
            finger: position,
            contact: load.at(0.0, &mut OnBranch::default()),
            friction: 0.0,
            overloaded: 0.0,
            load,
        };
        motor.settle();
        motor
    }

    /// The motor angle α of a position, rad.
    pub fn angle(&self, counts: f64) -> f64 {
        (counts - self.gear.zero) * self.gear.pitch * self.gear.direction
    }

    /// The load in the direction of greater positions: positive holds the motor back from them, N·mm.
    pub fn load_torque(&self) -> f64 {
        self.contact.torque * self.gear.direction
    }

    /// The motor's torque: load and friction, N·mm; positive drives towards greater positions.
    pub fn torque(&self) -> f64 {
        self.load_torque() + FRICTION * self.friction
    }

    /// Whether the motor lags behind its trajectory.
    pub fn lags(&self, trajectory: f64) -> bool {
        (trajectory - self.position).abs() > FOLLOWING
    }

    /// Lets time pass while the trajectory goes on; `since` seconds of it have passed before.
    pub fn run(&mut self, profile: &Profile, since: f64, seconds: f64, drive: Drive) {
        // Equal steps: a remainder of rounding would be a step in which every speed is infinite.
        let steps = (seconds / STEP).ceil().max(1.0);
        let step = seconds / steps;
        for passed in 0..steps as u64 {
            if self.is_still(profile, since + passed as f64 * step, drive) {
                self.speed = 0.0;
                self.overloaded = 0.0;
                return;
            }
            let target = profile.after(since + (passed + 1) as f64 * step).0;
            self.step(target, step, drive);
        }
    }

    fn is_still(&self, profile: &Profile, since: f64, drive: Drive) -> bool {
        if drive.on {
            since >= profile.duration() && self.position == profile.goal() && self.load_torque().abs() <= drive.torque
        } else {
            self.load_torque().abs() <= FRICTION
        }
    }

    fn step(&mut self, target: f64, step: f64, drive: Drive) {
        let before = self.position;
        let load = self.load_torque();
        let mut reached = target;
        if drive.on {
            // The torque left over turns the motor; without load and friction at its free speed.
            let speed = (target - before) / step;
            let against = (load * speed.signum() + FRICTION).max(0.0);
            let strength = drive.torque.min(STALL_TORQUE);
            let most = if against < strength { FREE_SPEED * (1.0 - against / STALL_TORQUE) } else { 0.0 };
            if load.abs() > strength + FRICTION {
                // The load is stronger than motor and friction together.
                let yielding = FREE_SPEED * (load.abs() - strength - FRICTION) / STALL_TORQUE;
                reached = before - (yielding * step).copysign(load);
            } else if speed.abs() > most {
                reached = before + (most * step).copysign(speed);
            }
            let weak = most == 0.0 && target != before;
            self.overloaded = if weak { self.overloaded + step } else { 0.0 };
        } else {
            let yielding = FREE_SPEED * (load.abs() - FRICTION).max(0.0) / STALL_TORQUE;
            reached = before - (yielding * step).copysign(load);
            self.overloaded = 0.0;
        }
        self.position = reached;
        self.speed = (reached - before) / step;
        self.friction = (self.friction + (reached - before) / TURN_AROUND).clamp(-1.0, 1.0);
        self.settle();
    }

    /// Puts the finger where play and contact leave it.
    fn settle(&mut self) {
        let half = self.gear.half_play;
        // Without load the finger stays until the play is used up.
        let mut finger = self.finger.clamp(self.position - half, self.position + half);
        // The object pushes it to the open side of the play, or as far as it still touches.
        let open = self.position - half * self.gear.direction;
        if half > 0.0 && self.feel(finger).torque > 0.0 {
            if self.feel(open).torque > 0.0 {
                finger = open;
            } else {
                let (mut free, mut pressed) = (open, finger);
                for _ in 0..30 {
                    let middle = (free + pressed) / 2.0;
                    if self.feel(middle).torque > 0.0 {
                        pressed = middle;
                    } else {
                        free = middle;
                    }
                }
                finger = pressed;
            }
        }
        self.finger = finger;
        let angle = self.angle(finger);
        self.contact = self.load.at(angle, &mut self.branch);
    }

    /// The contact if the finger were there; the branch is not changed.
    fn feel(&self, finger: f64) -> Contact {
        self.load.at(self.angle(finger), &mut self.branch.clone())
    }
}
