//! What gripper and host say to each other.
//!
//! Requests (the host asks, the gripper answers once) and topics (the gripper reports, unasked) are
//! [postcard-rpc](https://docs.rs/postcard-rpc) definitions: a message is a header (key and sequence number) and the
//! [postcard](https://docs.rs/postcard) encoding of its type. The key hashes path and type, so two programs built from
//! different definitions do not misread each other: the request is refused as unknown, the topic is ignored.
//!
//! [`frame`] carries a message over a stream of bytes: COBS between zeros, with a CRC-32.
//!
//! Units: mm, N, N·mm, rad, µs; the design, the object and the estimate are `model_core`'s own types, what a finger is doing and why
//! are `grip`'s.
#![no_std]
#![cfg_attr(
    not(test),
    deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::unreachable)
)]

pub mod frame;
mod grasp;
mod mount;
mod object;
mod refusal;
mod request;
mod role;
mod servo;
mod settings;
mod shape;
mod state;
mod support;
mod topic;
mod words;

pub use grip::{Calibration, Derating, Phase, Reaction, Strain, Why};
pub use object::Object;
pub use refusal::{Heed, Heeds, Moved, Outcome, Refusal, SettingsField, TEXT, Text};
pub use request::{CarryTo, CloseTo, Finger, For, Gravity, GripTo, Provocation, Which};
pub use role::{BAUDS, Role};
pub use servo::{Difference, ServoField, ServoSetup};
pub use settings::{Direction, Mount, SPEEDS, Settings, Side, Silence};
pub use state::{BootReport, Counters, ResetCause, Version};
pub use support::Support;
pub use topic::{CONTACTS, Contact, Event, FreeObject, Grasp, GripMargin, LAMELLAE, Notice, POINTS, Report, Shape};

use model_core::uncertainty::Uncertainty;
use postcard_rpc::{TopicDirection, endpoints, topics};

/// Version of what messages mean. (Their layout is distinguished by the keys.)
pub const PROTOCOL_VERSION: u16 = 10;

/// Most fingers of a gripper.
pub const FINGERS: usize = 4;

/// What may be in the gripper's memory.
pub type MaybeObject = Option<Object>;
/// What may be in the gripper's memory.
pub type MaybeFinger = Option<Finger>;

/// What a calibration has left uncertain of a finger; none: [`Uncertainty::DEFAULT`] counts.
pub type MaybeUncertainty = Option<Uncertainty>;

/// How a servo was found set, if it was found.
pub type MaybeServo = Option<ServoSetup>;

/// An object for a finger, in that finger's world frame.
pub type ObjectFor = For<Object>;
/// A design for a finger.
pub type FingerFor = For<Finger>;
/// The uncertainty of a finger's parameters, or none any more.
pub type UncertaintyFor = For<MaybeUncertainty>;

endpoints! {
    list = ENDPOINTS;
    | EndpointTy     | RequestTy      | ResponseTy       | Path              |
    | ----------     | ---------      | ----------       | ----              |
    | GetVersion     | ()             | Version          | "version"         |
    | GetBoot        | ()             | BootReport       | "boot"            |
    | GetObject      | u8             | MaybeObject      | "object/get"      |
    | SetObject      | ObjectFor      | Outcome          | "object/set"      |
    | PlaceObject    | ObjectFor      | Outcome          | "object/place"    |
    | GetFinger      | u8             | MaybeFinger      | "finger/get"      |
    | SetFinger      | FingerFor      | Outcome          | "finger/set"      |
    | GetUncertainty | u8             | MaybeUncertainty | "uncertainty/get" |
    | SetUncertainty | UncertaintyFor | Outcome          | "uncertainty/set" |
    | GetSettings    | ()             | Settings         | "settings/get"    |
    | GetServo       | u8             | MaybeServo       | "servo/get"       |
    | SetSettings    | Settings       | Outcome          | "settings/set"    |
    | Open           | Which          | Moved            | "open"            |
    | Close          | CloseTo        | Outcome          | "close"           |
    | Grip           | GripTo         | Outcome          | "grip"            |
    | Carry          | CarryTo        | Outcome          | "carry"           |
    | Hold           | Which          | Moved            | "hold"            |
    | Relax          | Which          | Moved            | "relax"           |
    | Scan           | ()             | Outcome          | "scan"            |
    | GetCounters    | ()             | Counters         | "counters"        |
    | Provoke        | Provocation    | Outcome          | "provoke"         |
}

topics! {
    list = TOPICS_IN;
    direction = TopicDirection::ToServer;
    | TopicTy | MessageTy | Path |
    | ------- | --------- | ---- |
}

topics! {
    list = TOPICS_OUT;
    direction = TopicDirection::ToClient;
    | TopicTy       | MessageTy | Path       |
    | -------       | --------- | ----       |
    | EstimateTopic | Report    | "estimate" |
    | GraspTopic    | Grasp     | "grasp"    |
    | ShapeTopic    | Shape     | "shape"    |
    | EventTopic    | Notice    | "event"    |
}
