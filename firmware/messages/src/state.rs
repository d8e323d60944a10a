//! What a gripper says of itself: its version, how it started, what it counted.

use heapless::String;
use model_core::size::Lists;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

use crate::refusal::Text;

/// Who answers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct Version {
    /// [`crate::PROTOCOL_VERSION`] of the gripper's program.
    pub protocol: u16,
    /// Version of the gripper's program.
    pub firmware: String<16>,
    /// Fingers it has room for.
    pub fingers: u8,
    /// The board it was built for.
    pub board: String<16>,
    /// Ticks per second of the clock in which costs are reported.
    pub cost_hz: u32,
    /// How long the lists of a finger's or an object's description may be.
    pub lists: Lists,
}

/// Why a processor started.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ResetCause {
    /// Power came.
    PowerOn,
    /// Somebody pressed a button, or a debugger did.
    Pin,
    /// The control loop had stopped.
    Watchdog,
    /// The program itself: asked to, or after a panic or a fault, of which its last words tell.
    Software,
    /// The supply voltage was too low.
    Brownout,
    /// The processor does not say.
    Unknown,
}

/// How the gripper's program started.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct BootReport {
    /// Why.
    pub cause: ResetCause,
    /// What the program before said when it ended by a panic or a fault.
    pub last_words: Option<Text>,
}

/// What was counted since the start; all but `uptime_us`, the rates and the latencies wrap.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, Schema)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Counters {
    /// Time since the start, µs.
    pub uptime_us: u64,
    /// Ticks of the control loop, each with a report per finger.
    pub ticks: u32,
    /// Positions that came from a servo, each with an estimate.
    pub estimates: u32,
    /// Ticks that began more than half a period late; one whose question was asked ahead may wait for its answer first.
    pub late_ticks: u32,
    /// Ticks of the last full second.
    pub rate_hz: f32,
    /// Ticks per second it should be, given the bus.
    pub chosen_hz: f32,
    /// Reports that found the link's queue full.
    pub dropped_reports: u32,
    /// Grasps that found the link's queue full.
    pub dropped_grasps: u32,
    /// Shapes that found the link's queue full.
    pub dropped_shapes: u32,
    /// Events that found the link's queue full.
    pub dropped_events: u32,
    /// Questions on the bus to which no whole answer came.
    pub bus_timeouts: u32,
    /// Answers that failed their CRC, or were not a packet at all.
    pub bus_damaged: u32,
    /// Instructions that the servo refused.
    pub bus_refused: u32,
    /// Other failures of the bus.
    pub bus_other: u32,
    /// Instructions of another master on the bus.
    pub bus_foreign: u32,
    /// Times the servo was lost.
    pub servo_losses: u32,
    /// Records that were ever written to this gripper's flash, which wears: 10,000 erasures of a page, each of some records, are usual.
    pub flash_writes: u32,
    /// Frames from the host that were sound.
    pub link_frames: u32,
    /// Frames from the host that were damaged or too long.
    pub link_damaged: u32,
    /// Messages too large for a frame.
    pub link_oversize: u32,
    /// From the last byte of a servo's answer (with several fingers: of the last answer) until its report was made, in ticks
    /// of the cost clock; the last one. 0: the board does not know.
    pub latency: u32,
    /// The longest one.
    pub latency_most: u32,
    /// From the last byte of another master's question until this gripper's answer to it was ready, in ticks of the cost clock; the last
    /// one. 0: there was none, or the board does not know.
    pub answer: u32,
    /// The longest one.
    pub answer_most: u32,
    /// Answers that were ready only after the return delay that the control table states, if that is more than 0.
    pub late_answers: u32,
}
