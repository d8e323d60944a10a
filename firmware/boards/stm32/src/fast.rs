//! Code that runs from RAM: the lines' interrupts with their vectors, and what writes flash ([`crate::stalling`]).
//!
//! While a bank of flash is written nothing can be fetched from it. An interrupt whose vector or handler lies there waits until a
//! sector is erased, for up to two seconds. `cargo xtask firmware BOARD` checks in the image that these paths are in RAM and leave it nowhere.

use core::ptr::copy_nonoverlapping;

use cortex_m::peripheral::SCB;

// What the linker's script `fast.x` says.
unsafe extern "C" {
    static __vector_table: u32;
    static __sifast: u32;
    static mut __sfast: u32;
    static __efast: u32;
    static mut __sfast_vectors: u32;
    static __efast_vectors: u32;
}

/// Copies code and vectors to RAM, and has the processor take its vectors there. Call it first of all, while no interrupt is let through.
pub fn load(scb: &mut SCB) {
    // SAFETY: the script gives both stretches to nobody else, aligned, and as long as what is copied into them.
    unsafe {
        copy(&raw const __sifast, &raw mut __sfast, &raw const __efast);
        copy(&raw const __vector_table, &raw mut __sfast_vectors, &raw const __efast_vectors);
        cortex_m::asm::dsb();
        scb.vtor.write((&raw const __sfast_vectors).addr() as u32);
    }
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}

/// Copies words to between two places.
///
/// # Safety
/// There are as many at `from`.
unsafe fn copy(from: *const u32, to: *mut u32, end: *const u32) {
    let words = (end.addr() - to.addr()) / size_of::<u32>();
    // SAFETY: the caller's promise.
    unsafe { copy_nonoverlapping(from, to, words) };
}
