//! What the gripper reports unasked.

use heapless::Vec;
use model_core::estimator::Estimate;
use model_core::size::{Lists, Reduced, Size};
use model_core::status::Status;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

use crate::{Derating, Difference, Phase, ResetCause, Strain, Why};

/// Most points of a beam in a [`Shape`].
pub const POINTS: usize = 64;
/// Most lamellae in a [`Shape`]: as many as a finger's description has here.
pub const LAMELLAE: usize = Lists::HERE.lamellae as usize;
/// Most contact points in a [`Shape`]: as many as the microcontroller's model has room for, so that none is left out.
pub const CONTACTS: usize = <Reduced as Size>::CONTACTS;

/// One finger's part of one tick of the control loop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Report {
    /// Counts every report made (one per finger and tick), sent or not: a gap is what was dropped. Wraps.
    pub sequence: u32,
    /// Which finger, from 0.
    pub finger: u8,
    /// What it is doing.
    pub phase: Phase,
    /// When the servo's position came (`stale`: when it was given up for this tick), µs since the start.
    pub time_us: u64,
    /// The force and what qualifies it. `stale`: no position came from the servo in this tick; the numbers are old.
    pub estimate: Estimate,
    /// Where the motor is being moved at this tick, rad.
    pub goal: f32,
    /// The servo's Present Position, counts.
    pub position: i32,
    /// The servo's Present Current, mA; positive drives towards greater counts.
    pub current: f32,
    /// What the estimate took, in ticks of the clock of [`crate::Version::cost_hz`].
    pub cost: u32,
}

impl Report {
    /// Of a finger that holds still and of which nothing is known: `stale`.
    pub const fn blank(finger: u8) -> Self {
        Self {
            sequence: 0,
            finger,
            phase: Phase::Held(Why::Asked),
            time_us: 0,
            estimate: Estimate::blank(Status::Stale),
            goal: 0.0,
            position: 0,
            current: 0.0,
            cost: 0,
        }
    }
}

/// The whole grasp at one tick, sent behind the reports of its fingers if there are several. Gripper frame: x from left
/// to right, y along the open fingers; the finger's world frame on the left, its mirror image on the right.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Grasp {
    /// The last report of this tick.
    pub sequence: u32,
    /// Whether all estimates of this tick are trustworthy; the forces below are of no use otherwise.
    pub is_trustworthy: bool,
    /// Force of all fingers on the object, N.
    pub sum: [f32; 2],
    /// Force by which the object is pressed together across x, N: the smaller one of what the left fingers push to the right
    /// and the right fingers push to the left.
    pub squeeze: f32,
    /// How much of the fingers' forces cancels: 1 − |sum| / Σ|force|; 1 without contact.
    pub balance: f32,
    /// Where a free object has come to; nothing for one that is fixed.
    pub free: Option<FreeObject>,
    /// What the grip bears before the object slips; nothing while an estimate is not trustworthy, of an object without an end (a half-plane),
    /// and until it is known.
    pub margin: Option<GripMargin>,
}

/// What a grip bears before the object slips: the largest loads at the object's reference point (centre; of a polygon, the mean of its
/// corners) for which there are forces within the friction cones, no finger pressing harder than now. Gripper frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct GripMargin {
    /// Force in the weakest direction in the fingers' plane, N; of directions every 15°.
    pub least: f32,
    /// That direction, rad from x, counter-clockwise.
    pub direction: f32,
    /// Force across the plane, N.
    pub across: f32,
    /// Couple about the reference point, N·mm: the weaker one of both ways.
    pub couple: f32,
    /// The finger that slips first, from 0, in the weakest direction in the plane or across it; nothing where none slides, or where nothing
    /// is borne.
    pub slips: Option<u8>,
    /// Force in the direction of the weight that the fingers were asked to carry, N; nothing if they were not.
    pub carried: Option<f32>,
    /// Ticks since the contact forces behind the numbers were estimated: the search goes on over several ticks. (Those behind `carried` may
    /// be newer.)
    pub age: u16,
}

/// A free object at one tick, found from the fingers' estimates and their stiffness.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FreeObject {
    /// `converged` or `snapped`: it rests there. `no-contact`: fewer than two fingers touch it, and it stays where it is.
    /// With all others the fingers' forces are of no use, and their reports say so too. `max-iterations`: the balance was not
    /// reached in this tick, the next one goes on; `folded`: it would not stay there; `out-of-range`: the fingers' objects
    /// are not one object, it is 50 mm from where it was set, or nothing can hold its load; else why a finger has no estimate.
    pub status: Status,
    /// How far it has come from where it was set, gripper frame, mm.
    pub shift: [f32; 2],
    /// How far it has turned, rad, counter-clockwise.
    pub turn: f32,
    /// What is left of the forces and the load (a moment over the object's size), N.
    pub residual: f32,
    /// Newton iterations spent on it in this tick, all fingers together.
    pub iterations: u16,
    /// What it took, in ticks of the cost clock.
    pub cost: u32,
}

/// A contact point of a [`Shape`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Contact {
    /// Point of the beam's surface, finger frame, mm.
    pub position: [f32; 2],
    /// Force on the object, finger frame, N.
    pub force: [f32; 2],
}

/// The deformed finger behind one report. Finger frame, mm, base to tip; beams are thinned to [`POINTS`], their ends kept.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Shape {
    /// The report it belongs to.
    pub sequence: u32,
    /// Which finger, from 0.
    pub finger: u8,
    /// That report's status.
    pub status: Status,
    /// Angle by which the motor has turned the base about its axis, rad; 0 for a base that is moved along a line.
    pub motor_angle: f32,
    /// How far the base has been moved along its line, world frame, mm; 0 for one that is turned.
    pub shift: [f32; 2],
    /// Centreline of the front beam.
    pub front: Vec<[f32; 2], POINTS>,
    /// Centreline of the back beam.
    pub back: Vec<[f32; 2], POINTS>,
    /// Ends of the lamellae at the front.
    pub lamella_front: Vec<[f32; 2], LAMELLAE>,
    /// Ends of the lamellae at the back.
    pub lamella_back: Vec<[f32; 2], LAMELLAE>,
    /// Touching samples.
    pub contacts: Vec<Contact, CONTACTS>,
}

/// Something that happened.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Notice {
    /// When, µs since the start.
    pub time_us: u64,
    /// What.
    pub event: Event,
}

/// What can happen. Fingers count from 0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Event {
    /// The program started.
    Started {
        /// Why.
        cause: ResetCause,
    },
    /// What was kept in flash: how many records were read, and how many were damaged and are gone.
    Restored {
        /// Sound ones.
        records: u8,
        /// Damaged ones.
        damaged: u8,
    },
    /// A servo answers. A gripper's holds its position unless it has shut down ([`Self::ServoAlert`]).
    ServoReady {
        /// Whose.
        finger: u8,
        /// Model number, 1020 for the XM430-W350.
        model: u16,
        /// Version of its firmware.
        firmware: u8,
        /// Bits per second on the bus.
        baud: u32,
    },
    /// A servo is not what it should be: it is not controlled, and nothing is written to it.
    ServoDiffers {
        /// Whose.
        finger: u8,
        /// In what.
        difference: Difference,
    },
    /// A search of the bus has found a servo, or another device.
    DeviceFound {
        /// Its address.
        id: u8,
        /// Model number, 1020 for the XM430-W350.
        model: u16,
        /// Version of its firmware.
        firmware: u8,
        /// The rate at which it answers, bits per second.
        baud: u32,
        /// It has a hardware error.
        alert: bool,
    },
    /// The search of the bus is over; the bus has its rate again.
    ScanDone {
        /// Devices found.
        found: u16,
        /// Rates tried.
        rates: u8,
    },
    /// Another master reads the servo's position: the first one was heard.
    ServoHeard {
        /// Whose.
        finger: u8,
    },
    /// The control loop's rate; below the one wanted if the bus is too slow for it.
    Rate {
        /// Ticks per second from now on.
        hz: f32,
        /// Ticks per second that the settings ask for.
        wanted_hz: f32,
    },
    /// The loop does not keep its rate (`hz` below 95 % of `chosen_hz`), or keeps it again (98 %).
    RateReached {
        /// Ticks of the last second.
        hz: f32,
        /// Ticks per second it should have been.
        chosen_hz: f32,
    },
    /// The servo has not answered for 0.3 s, or has lost its torque (Torque Enable, Bus Watchdog) though nobody asked for that, or its master
    /// has stopped asking; estimates are stale until it is found again.
    ServoLost {
        /// Whose.
        finger: u8,
        /// Another master has spoken on the bus within the last second, which may be why.
        other_master: bool,
    },
    /// Another master speaks on the bus, although this gripper is its master: their packets collide. Reported every 10 s at most.
    OtherMaster {
        /// Instructions of others that were heard since the start.
        packets: u32,
    },
    /// The servo reports hardware errors, one bit each as in its Hardware Error Status; 0: no more.
    ServoAlert {
        /// Whose.
        finger: u8,
        /// The bits.
        hardware_error: u8,
    },
    /// The servo is hotter, or its supply lower, than it should be: what its finger may do has changed.
    Derated {
        /// Whose.
        finger: u8,
        /// What it may do from now on.
        derating: Derating,
        /// Because of what; what it was, if it may do everything again.
        strain: Strain,
        /// Temperature inside, °C.
        temperature: u8,
        /// Supply, V.
        volts: f32,
    },
    /// The servo refused a goal position.
    GoalRefused {
        /// Whose.
        finger: u8,
        /// The goal, counts.
        position: i32,
        /// The protocol's error code.
        error: u8,
    },
    /// The model was set up anew and starts from rest.
    ModelReady {
        /// Of which finger.
        finger: u8,
        /// What setting up took, in ticks of the cost clock.
        cost: u32,
    },
    /// The current rose while the finger closed: it has met something. Reported three ticks after the rise began.
    Touched {
        /// Which.
        finger: u8,
        /// Motor angle at which the current began to rise, rad.
        angle: f32,
    },
    /// The torque that the estimate demands of the motor and the one that its current shows have begun to disagree: the
    /// object is not where, or not what, the settings say. Or they agree again.
    TorquesDisagree {
        /// Of which finger.
        finger: u8,
        /// From now on.
        disagree: bool,
        /// Demanded, N·mm.
        demanded: f32,
        /// Measured current, mA.
        current: f32,
    },
    /// A finger does something else from now on.
    PhaseChanged {
        /// Which.
        finger: u8,
        /// What.
        phase: Phase,
    },
}
