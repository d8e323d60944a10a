//! Times on the bus.

use crate::packet::StatusReturn;

/// Microseconds by which a device's answer to a broadcast Ping is delayed for each address below its own.
///
/// So the answers come in the order of the addresses. ROBOTIS' SDK waits 3 ms per address.
pub const BROADCAST_PING_SLOT_US: u32 = 3_000;

/// How long bytes take, and how long others are waited for.
///
/// An answer is waited for as long as the bytes of question and answer take on the wire, plus `latency_us`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Timing {
    /// Bits per second on the wire (10 per byte); 0 counts as 1.
    pub baud_rate: u32,
    /// Microseconds beyond the wire time: the devices' return delay (factory: 500), and what port and scheduler add.
    pub latency_us: u32,
    /// Which instructions the devices answer; a write to a device that does not answer it is not waited for.
    pub status_return: StatusReturn,
}

impl Timing {
    /// Timing at `baud_rate` for devices with factory settings: 500 µs return delay and 1500 µs for port and scheduler.
    pub const fn at(baud_rate: u32) -> Self {
        Timing { baud_rate, latency_us: 2_000, status_return: StatusReturn::All }
    }

    /// Microseconds that `bytes` take on the wire, rounded up.
    pub const fn wire_us(&self, bytes: usize) -> u32 {
        let rate = if self.baud_rate == 0 { 1 } else { self.baud_rate as u64 };
        let us = (bytes as u64).saturating_mul(10_000_000).div_ceil(rate);
        if us > u32::MAX as u64 { u32::MAX } else { us as u32 }
    }

    /// When the first of so many bytes began, if the last has come at `now_us`.
    pub(crate) fn began_us(&self, now_us: u64, bytes: usize) -> u64 {
        now_us.saturating_sub(u64::from(self.wire_us(bytes)))
    }

    /// Silence after which an incomplete packet will not be completed, µs: longer than any gap within a packet.
    pub(crate) const fn pause_us(&self) -> u32 {
        self.latency_us.saturating_add(self.wire_us(16))
    }
}
