//! Motor, gears and finger: what a duty of the supply's voltage does against friction and load.
//!
//! The rotor's inertia is left out: the speed is the one at which torque, friction and load balance. (Position control
//! takes 45 ms with the factory's gains, the rotor about a third of that.)

use std::sync::Arc;

use super::contact::Contact;
use super::load::{Load, OnBranch};
use super::rub::Rub;
use crate::datasheet::Datasheet;

/// From encoder counts to the finger's angle.
#[derive(Clone, Debug)]
pub struct Gear {
    /// Motor and gears.
    pub data: Datasheet,
    /// Counts at which the finger's angle is 0.
    pub zero: f64,
    /// 1 if greater positions close the finger, otherwise -1.
    pub direction: f64,
    /// Radians per count.
    pub pitch: f64,
    /// Half of the play, counts.
    pub half_play: f64,
}

impl Gear {
    /// Speed without load, counts/s.
    pub fn free_speed(&self) -> f64 {
        self.data.free_speed / 60.0 * std::f64::consts::TAU / self.pitch
    }
}

/// Where motor and finger are, in counts of the encoder, and what they feel.
#[derive(Clone, Debug)]
pub struct Motor {
    /// Motor, gears and finger.
    pub gear: Gear,
    load: Arc<Load>,
    branch: OnBranch,
    /// The finger, if it has friction or memory.
    rub: Option<Rub>,
    /// Time since it was asked for its contact, s.
    waits: f64,
    /// Position of the motor, counts.
    pub position: f64,
    /// Speed, counts/s.
    pub speed: f64,
    /// The motor's torque, N·mm; positive drives towards greater positions.
    pub torque: f64,
    /// Position of the finger, counts: within the play of the motor's.
    pub finger: f64,
    /// What the finger feels.
    pub contact: Contact,
    /// Seconds for which the motor has been too weak.
    pub overloaded: f64,
}

/// What drives the motor for a moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Supply {
    /// Nothing: the gears' friction alone holds it.
    Off,
    /// A duty of the supply's voltage, −1 to 1, that falls with the speed.
    Duty {
        /// At rest.
        at_rest: f64,
        /// By how much less per count/s.
        per_speed: f64,
        /// Greatest magnitude.
        most: f64,
        /// Greatest magnitude of the torque, N·mm.
        torque: f64,
    },
    /// A torque, N·mm, as far as the voltage suffices.
    Torque(f64),
}

impl Motor {
    /// A motor at rest.
    pub fn new(gear: Gear, load: Arc<Load>, position: f64) -> Self {
        let mut motor = Self {
            gear,
            branch: OnBranch::default(),
            rub: load.rub(),
            waits: 0.0,
            position,
            speed: 0.0,
            torque: 0.0,
            finger: position,
            contact: load.at(0.0, &mut OnBranch::default()),
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

    /// Lets a moment pass, s; `volts` is the supply.
    pub fn step(&mut self, supply: Supply, volts: f64, seconds: f64) {
        let (speed, torque, is_weak) = self.balance(supply, volts / self.gear.data.volts);
        (self.speed, self.torque) = (speed, torque);
        self.overloaded = if is_weak { self.overloaded + seconds } else { 0.0 };
        self.waits += seconds;
        if speed != 0.0 {
            self.position += speed * seconds;
            self.settle();
        } else {
            self.touch();
        }
    }

    /// Speed and torque at which motor, friction and load balance, and whether the motor is too weak for its goal.
    fn balance(&self, supply: Supply, strength: f64) -> (f64, f64, bool) {
        let load = self.load_torque();
        let Datasheet { stall_torque, friction, .. } = self.gear.data;
        let stall = stall_torque * strength;
        // Torque that the full voltage leaves at a speed falls by this, N·mm per count/s.
        let back_emf = stall_torque / self.gear.free_speed();
        // Without a motor the load turns the gears against their friction, and against its own losses.
        let yielding = |torque: f64| {
            let rest = load - torque;
            -((rest.abs() - friction).max(0.0) / back_emf).copysign(rest)
        };
        match supply {
            Supply::Off => (yielding(0.0), 0.0, false),
            Supply::Torque(torque) => {
                let torque = torque.max(-stall).min(stall);
                let free = torque - load;
                if free.abs() <= friction {
                    return (0.0, torque, torque.abs() >= stall);
                }
                // It speeds up until the voltage has nothing left.
                let against = load + friction.copysign(free);
                if against * free.signum() < 0.0 {
                    return (yielding(torque), torque, false);
                }
                let most = (stall - against.abs()).max(0.0) / back_emf;
                (most.copysign(free), against, false)
            }
            Supply::Duty { at_rest, per_speed, most, torque: limit } => {
                let held = (stall * at_rest.max(-most).min(most)).max(-limit).min(limit);
                // Overload is of a motor whose voltage does not suffice, not of one whose current is limited.
                let is_weak = at_rest.abs() > most && stall * most <= limit;
                let free = held - load;
                if free.abs() <= friction {
                    return (0.0, held, is_weak);
                }
                let against = load + friction.copysign(free);
                if against.abs() > limit {
                    // The load is stronger than what the motor may give and friction together.
                    let torque = limit.copysign(against);
                    return (yielding(torque), torque, is_weak);
                }
                let unlimited = (stall * at_rest - against) / (stall * per_speed + back_emf);
                let duty = at_rest - per_speed * unlimited;
                if duty.abs() <= most {
                    return (unlimited, against, false);
                }
                let speed = (stall * most.copysign(duty) - against) / back_emf;
                // With all that it may give it is pushed back.
                (speed, against, is_weak && speed * duty <= 0.0)
            }
        }
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
        match self.rub {
            Some(_) => self.touch(),
            None => self.contact = self.load.at(self.angle(finger), &mut self.branch),
        }
    }

    /// What a finger with friction or memory feels where it is by now.
    fn touch(&mut self) {
        if let Some(rub) = &self.rub {
            self.contact = rub.at(self.angle(self.finger), std::mem::take(&mut self.waits));
        }
    }

    /// The contact if the finger were there; the branch is not changed.
    fn feel(&self, finger: f64) -> Contact {
        self.load.at(self.angle(finger), &mut self.branch.clone())
    }
}
