//! The processor's cycle counter.

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
