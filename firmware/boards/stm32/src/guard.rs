//! A stretch of memory that nobody may touch: below a stack that has variables below it, so that one that overflows faults.
//!
//! The memory protection unit keeps it (Armv7-M, section B3.5), with the default map for everything else. It is out of the way while a hard
//! fault is handled: the handler has the stretch for its own stack.

use core::sync::atomic::{Ordering, compiler_fence};

use cortex_m::peripheral::MPU;

/// Bytes of the stretch, a power of two.
pub const BYTES: u32 = 4096;

/// The region's number; the others are switched off.
const REGION: u32 = 0;
/// Control: on, with the default map where no region is (PRIVDEFENA), and off within hard faults.
const ON: u32 = 1 | 1 << 2;
/// Attributes: on, 2^(n + 1) bytes, no access to anyone, no instructions.
const NO_ACCESS: u32 = 1 | (BYTES.trailing_zeros() - 1) << 1 | 1 << 28;

// What the boards' memory maps say.
#[cfg(feature = "chip")]
unsafe extern "C" {
    static _stack_end: u8;
}

/// Keeps the stretch below the stack.
#[cfg(feature = "chip")]
pub fn below_stack(mpu: &mut MPU) {
    keep(mpu, (&raw const _stack_end).addr() as u32 - BYTES);
}

/// Has every access to [`BYTES`] from `start` (a multiple of them) end in a fault, from now on.
pub fn keep(mpu: &mut MPU, start: u32) {
    // SAFETY: takes access to memory that the caller says nobody uses; registers as the manual describes them.
    unsafe {
        mpu.ctrl.write(0);
        // What a boot loader may have left.
        for region in 0..mpu._type.read() >> 8 & 0xFF {
            mpu.rnr.write(region);
            mpu.rasr.write(0);
        }
        mpu.rnr.write(REGION);
        mpu.rbar.write(start & !(BYTES - 1));
        mpu.rasr.write(NO_ACCESS);
        mpu.ctrl.write(ON);
    }
    compiler_fence(Ordering::SeqCst);
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}
