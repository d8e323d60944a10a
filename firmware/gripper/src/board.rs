//! What the gripper needs of a board.

use embedded_io_async::{Read, Write};

/// The Dynamixel bus.
pub trait BusPort: Read + Write {
    /// Sets the rate and returns the one reached, bits per second.
    fn set_baud(&mut self, baud: u32) -> u32;
}

/// A board.
pub trait Board {
    /// Its bus.
    type Bus: BusPort;
    /// Its name, 16 bytes at most.
    const NAME: &'static str;
    /// Rates at which the servo is looked for, bits per second, the most likely first.
    const BAUDS: &'static [u32];
    /// What port and scheduler add to a servo's answer, µs, at most.
    const BUS_LATENCY_US: u32;
    /// Ticks per second of the clock behind [`Self::cost_ticks`].
    const COST_HZ: u32;
    /// A clock that wraps, to measure what the estimate costs.
    fn cost_ticks() -> u32;
}
