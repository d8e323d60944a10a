//! Grips by force: pure state machines for the motor of one finger.
//!
//! A program that reads a servo and knows the force at its finger, from a model or from a load cell, asks [`Grip`] once per tick
//! where to move the motor. Around it:
//!
//! - [`Carry`] says how hard fingers press to bear a weight, from what the grip bears.
//! - [`Contact`] finds the first contact in the motor's current, and compares current and demanded torque.
//! - [`Calibration`] converts the servo's counts into motor angles and back.
//! - [`Health`] distinguishes a lost answer from a lost servo.
//! - [`StrainWatch`] limits the force of a finger whose servo gets hot, or whose supply falls.
//! - [`Budget`] learns how many iterations of a solver fit into what is left of a period.
//! - [`Meter`] measures the rate that the loop reaches.
//!
//! Nothing here waits, allocates, reads a clock or knows a bus: time comes in as seconds, answers as numbers. Angles in rad,
//! forces in N, currents in mA.
#![cfg_attr(not(test), no_std)]
#![cfg_attr(
    not(test),
    deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::unreachable)
)]

// Floating-point numbers are kept within bounds by `max` and `min`: `clamp` panics where the bounds are crossed or NaN.

/// The README's examples.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct ReadMe;

mod budget;
mod calibration;
mod carry;
mod contact;
mod derating;
mod grip;
mod health;
mod lag;
mod limits;
mod motion;
mod phase;
mod rate;
mod slope;
mod stall;

pub use budget::Budget;
pub use calibration::{Calibration, Gear};
pub use carry::{Carry, Step};
pub use contact::{Contact, DELAY_TICKS, Motor, Told};
pub use derating::{Bounds, Derating, Margins, Strain, StrainWatch, Vitals};
pub use grip::{Grip, Touch};
pub use health::Health;
pub use lag::Lag;
pub use limits::{Faults, Limits, Target};
pub use motion::Motion;
pub use phase::{Phase, Reaction, Why};
pub use rate::{Meter, Second};
pub use slope::Slope;
pub use stall::{Firmness, Stall};
