//! A 32-bit count of the 25 MHz clock, to measure what a piece of code costs.
//!
//! Under QEMU's `-icount shift=N` an instruction takes 2^N ns and a tick is 40 ns, so instructions = ticks · 40 / 2^N: ticks × 0.625
//! with `shift=6` (exact to an instruction; *measured*: 40,000 instructions counted as 40,004), ticks × 10 with `shift=2`. Without `-icount` it is wall time.

use crate::registers::{CLOCK_HZ, dual_timer};

/// Ticks per second.
pub const HZ: u32 = CLOCK_HZ;

const RUN_32_BITS: u32 = 1 << 7 | 1 << 1;

pub(crate) fn start() {
    dual_timer::CONTROL.write(0);
    dual_timer::LOAD.write(u32::MAX);
    dual_timer::CONTROL.write(RUN_32_BITS);
}

/// The count now; wraps after 171 s, so take differences by `wrapping_sub`.
#[inline(always)]
pub fn now() -> u32 {
    !dual_timer::VALUE.read()
}

/// Ticks that `work` takes, interrupts included, and what it returns.
#[inline(never)]
pub fn of<R>(work: impl FnOnce() -> R) -> (R, u32) {
    let start = now();
    let result = work();
    (result, now().wrapping_sub(start))
}
