//! Dynamixel [Protocol 2.0](https://emanual.robotis.com/docs/en/dxl/protocol2/) without allocation.
//!
//! A half-duplex bus on which one master asks and devices with addresses answer:
//!
//! ```text
//! FF FF FD 00 | id | length (2) | instruction | parameters, stuffed | CRC-16 (2)
//! ```
//!
//! - [`Encoder`] and [`Decoder`] turn packets into bytes and back; the decoder finds its way after damage.
//! - [`Master`] asks over any `embedded-io-async` port, with a deadline for every answer; [`blocking::Master`] does so without an
//!   executor, over any `embedded-io` port.
//! - [`Tap`] listens to another master's traffic and learns from it where the servos are.
//! - [`Device`] is the other side: it answers for a [`ControlTable`].
//! - [`xm430`] lists the control table of the XM430-W350 as typed [`Register`]s; a [`Model`] says where another servo has them, in which
//!   units, and what its own table holds.
//!
//! Numbers in packets are little-endian, negative ones in two's complement.
#![no_std]
#![cfg_attr(
    not(test),
    deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::unreachable)
)]

#[cfg(test)]
extern crate std;

/// The README's examples.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct ReadMe;

pub mod blocking;
pub mod crc;
mod decode;
mod device;
mod encode;
#[cfg(any(test, feature = "examples"))]
pub mod examples;
mod fast;
mod item;
mod line;
mod master;
mod models;
mod packet;
mod request;
mod tables;
mod tap;
mod timing;
mod upkeep;
pub mod xm430;

pub use decode::{DecodeError, Decoder};
pub use device::{ControlTable, Device, Reply};
pub use encode::{EncodeError, Encoder, encode};
pub use item::{Access, Area, IndirectArea, Item, Part, Register, Value, check_read, find, writes};
pub use master::{Answer, BulkAnswer, BulkWrite, Error, Found, Identity, Master, SyncAnswer};
pub use models::{Effort, Followed, Layout, MODELS, Model, Motor, name_of};
pub use packet::{
    HEADER, Id, Instruction, Packet, Status, StatusError, StatusReturn, longest_packet_length, packet_length,
    status_length,
};
pub use tap::{Heard, Seen, Tap, Watched};
pub use timing::{BROADCAST_PING_SLOT_US, Timing};
pub use upkeep::{Backup, ResetScope};
