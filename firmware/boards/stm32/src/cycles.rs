//! The processor's cycle counter.
//!
//! It stands still while the processor sleeps without a clock. embassy-stm32 leaves the clock on in sleep mode (DBG_SLEEP, its
//! `enable_debug_during_sleep`, on by default), so that it counts on between a servo's last byte and the pause behind it.

use cortex_m::peripheral::{DCB, DWT};

/// Starts it.
pub fn start(dcb: &mut DCB, dwt: &mut DWT) {
    dcb.enable_trace();
    // A Cortex-M7 locks it until a debugger comes; Cortex-M4 ignores this.
    DWT::unlock();
    dwt.enable_cycle_counter();
}

/// The count now; it wraps, so take differences by `wrapping_sub`.
#[inline(always)]
pub fn now() -> u32 {
    DWT::cycle_count()
}
