//! How deep the stack went, by painting it first.

use core::ptr::{read_volatile, write_volatile};

/// Bytes below the stack pointer that are painted.
pub const WINDOW_BYTES: usize = 256 * 1024;
/// Bytes below the stack pointer that painting itself may use.
const MARGIN_BYTES: usize = 256;
const PAINT: u32 = 0xcccc_cccc;

unsafe extern "C" {
    static _stack_end: u32;
}

/// Runs `work` and returns what it returns and the bytes of stack it took, interrupts included: at least 256 (not resolved below),
/// at most [`WINDOW_BYTES`].
#[inline(never)]
pub fn peak_of<R>(work: impl FnOnce() -> R) -> (R, usize) {
    let (bottom, top) = critical_section::with(|_| paint());
    let result = work();
    (result, top + MARGIN_BYTES - deepest(bottom, top))
}

/// Paints and returns the painted range.
#[inline(never)]
fn paint() -> (usize, usize) {
    let top = (cortex_m::register::msp::read() as usize - MARGIN_BYTES) & !3;
    let end = (&raw const _stack_end) as usize;
    let bottom = top.saturating_sub(WINDOW_BYTES).max(end);
    let mut address = bottom;
    while address < top {
        // SAFETY: aligned, above all statics (`_stack_end`), and below everything this function and its callers keep on the stack:
        // nothing lives there. No interrupt comes between (critical section).
        unsafe { write_volatile(address as *mut u32, PAINT) };
        address += 4;
    }
    (bottom, top)
}

/// The lowest address whose paint is gone.
fn deepest(bottom: usize, top: usize) -> usize {
    let mut address = bottom;
    // SAFETY: aligned RAM between the statics and the stack pointer at the time of painting.
    while address < top && unsafe { read_volatile(address as *const u32) } == PAINT {
        address += 4;
    }
    address
}
