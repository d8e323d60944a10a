//! Flash words that were being programmed when the power went, read without ending the program.
//!
//! Where flash corrects errors, the read of a word with more than one of them is a bus fault (STM32H7) or a non-maskable interrupt
//! (STM32G4). Both would restart the processor, which reads the word again: for ever.

use core::arch::asm;
use core::ptr::{read_volatile, write_volatile};
use core::sync::atomic::{AtomicBool, Ordering::SeqCst};

use cortex_m::peripheral::SCB;

/// Somebody reads who reckons with it.
static READING: AtomicBool = AtomicBool::new(false);
/// The word that was read is torn.
static TORN: AtomicBool = AtomicBool::new(false);

/// Bytes that are read at a time. Meanwhile no interrupt is let through, not even a line's, whose next byte comes after 2.5 µs at 4 Mbaud.
const STRETCH: usize = 16;

/// SCB's CCR: a load's bus fault is ignored by handlers of priority −1 and −2 (Armv7-M, B3.2.8).
const BFHFNMIGN: u32 = 1 << 8;
/// SCB's CFSR: the byte of bus faults; ones clear them.
const BUS_FAULTS: u32 = 0xFF00;

/// Copies what is at this address.
///
/// # Safety
/// As many bytes as `into` holds can be read from there.
pub(crate) unsafe fn copy(address: u32, into: &mut [u8]) {
    for (at, byte) in into.iter_mut().enumerate() {
        // SAFETY: the caller's promise.
        *byte = unsafe { read_volatile((address as usize + at) as *const u8) };
    }
}

/// As [`Care::read`](crate::Care::read) where flash corrects errors. A board's handler of non-maskable interrupts asks [`is_expected`].
///
/// # Safety
/// As many bytes as `into` holds can be read from there.
pub unsafe fn read(address: u32, into: &mut [u8]) -> bool {
    let (mut from, mut is_whole) = (address, true);
    for stretch in into.chunks_mut(STRETCH) {
        // SAFETY: the caller's promise, part by part.
        is_whole &= unsafe { read_stretch(from, stretch) };
        from = from.wrapping_add(STRETCH as u32);
    }
    is_whole
}

/// A few bytes at once.
///
/// # Safety
/// As of [`read`].
unsafe fn read_stretch(address: u32, into: &mut [u8]) -> bool {
    TORN.store(false, SeqCst);
    READING.store(true, SeqCst);
    // SAFETY: the processor's own registers, aligned. FAULTMASK makes this a handler of priority −1 for the time of a few loads.
    let faults = unsafe {
        let (ccr, cfsr) = (&raw mut (*SCB::PTR.cast_mut()).ccr, &raw mut (*SCB::PTR.cast_mut()).cfsr);
        write_volatile(cfsr.cast(), BUS_FAULTS);
        asm!("cpsid f");
        write_volatile(ccr.cast(), read_volatile(ccr.cast::<u32>()) | BFHFNMIGN);
        asm!("dsb", "isb");
        copy(address, into);
        asm!("dsb");
        let faults = read_volatile(cfsr.cast::<u32>()) & BUS_FAULTS;
        write_volatile(cfsr.cast(), faults);
        write_volatile(ccr.cast(), read_volatile(ccr.cast::<u32>()) & !BFHFNMIGN);
        asm!("dsb", "isb", "cpsie f");
        faults
    };
    READING.store(false, SeqCst);
    faults == 0 && !TORN.load(SeqCst)
}

/// Whether a report of the flash that a word cannot be read is somebody's who reckons with it, and is heard by that one.
pub fn is_expected() -> bool {
    TORN.store(true, SeqCst);
    READING.load(SeqCst)
}
