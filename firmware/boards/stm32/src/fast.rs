//! Code that runs from RAM: the lines' interrupts with their vectors, what writes flash ([`crate::stalling`]), and the hot functions of a
//! board's `hot.txt`, which are only faster there.
//!
//! While a bank of flash is written nothing can be fetched from it. An interrupt whose vector or handler lies there waits until a
//! sector is erased, for up to two seconds. `cargo xtask firmware BOARD` checks in the image that these paths are in RAM and leave it nowhere.

use cortex_m::peripheral::SCB;

// What the linker's scripts `fast.x` and `hot.x` say.
unsafe extern "C" {
    static __vector_table: u32;
    static __sifast: u32;
    static mut __sfast: u32;
    static __efast: u32;
    static mut __sfast_vectors: u32;
    static __efast_vectors: u32;
    static __sihot: u32;
    static mut __shot: u32;
    static __ehot: u32;
}

/// Copies code and vectors to RAM, and has the processor take its vectors there. Call it first of all, while no interrupt is let through.
pub fn load(scb: &mut SCB) {
    // SAFETY: the scripts give all stretches to nobody else, aligned, and as long as what is copied into them.
    unsafe {
        copy(&raw const __sifast, &raw mut __sfast, &raw const __efast);
        copy(&raw const __sihot, &raw mut __shot, &raw const __ehot);
        copy(&raw const __vector_table, &raw mut __sfast_vectors, &raw const __efast_vectors);
        cortex_m::asm::dsb();
        scb.vtor.write((&raw const __sfast_vectors).addr() as u32);
    }
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}

/// Copies words to between two places, by double words: memory with error correction is then never read before it is written.
///
/// # Safety
/// There are as many at `from`, and `to` and `end` are aligned to double words.
unsafe fn copy(from: *const u32, to: *mut u32, end: *const u32) {
    let (mut from, mut to) = (from, to.cast::<u64>());
    while to.cast_const() < end.cast() {
        // SAFETY: the caller's promise.
        unsafe {
            let [low, high] = [from.read(), from.add(1).read()];
            to.write_volatile(u64::from(high) << 32 | u64::from(low));
            (from, to) = (from.add(2), to.add(1));
        }
    }
}
