//! Writing flash of the bank that the program itself is fetched from: the moments in which nothing can be fetched run from RAM.
//!
//! In them only the lines' interrupts are let through, which run from RAM as well: a critical section holds back all others.

#[cfg_attr(feature = "flash-f7", path = "f7.rs")]
#[cfg_attr(feature = "flash-g4", path = "g4.rs")]
mod family;

use core::ptr::{read_volatile, write_volatile};

use embassy_stm32::flash::{FLASH_BASE, WRITE_SIZE};
use embassy_stm32::pac::{FLASH, flash::regs::Cr};
use embedded_storage::nor_flash::NorFlashErrorKind;

/// The status register's bit for an operation that goes on.
const BUSY: u32 = 1 << 16;

/// Erases sectors of `SECTOR` bytes, all of those between two places, counted from the flash's start.
///
/// # Errors
/// The flash reports that it has not done so.
pub fn erase<const SECTOR: u32>(from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
    unlocked(|| {
        (from..to).step_by(SECTOR as usize).try_for_each(|place| {
            critical_section::with(|_| {
                let value = family::erasing::<SECTOR>(place);
                FLASH.cr().write_value(value);
                let started = started(value);
                // SAFETY: the flash's own registers.
                unsafe { start(FLASH.cr().as_ptr().cast(), started.0, FLASH.sr().as_ptr().cast(), BUSY) };
                FLASH.cr().write_value(family::IDLE);
            });
            outcome()
        })
    })
}

/// Writes whole units from a place on, counted from the flash's start.
///
/// # Errors
/// Place or bytes are not of whole units, or the flash reports that it has not done so.
pub fn write(place: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
    if !(place as usize).is_multiple_of(WRITE_SIZE) || !bytes.len().is_multiple_of(WRITE_SIZE) {
        return Err(NorFlashErrorKind::NotAligned);
    }
    let mut to = (FLASH_BASE as u32 + place) as usize as *mut [u32; family::WORDS];
    unlocked(|| {
        bytes.chunks_exact(4 * family::WORDS).try_for_each(|bytes| {
            let mut unit = [0; family::WORDS];
            for (word, bytes) in unit.iter_mut().zip(bytes.chunks_exact(4)) {
                let mut one = [0; 4];
                one.copy_from_slice(bytes);
                *word = u32::from_le_bytes(one);
            }
            critical_section::with(|_| {
                FLASH.cr().write_value(family::WRITING);
                // SAFETY: `Settings` asks for places inside the flash; the flash's own register.
                unsafe { put(to, &unit, FLASH.sr().as_ptr().cast(), BUSY) };
                FLASH.cr().write_value(family::IDLE);
            });
            to = to.wrapping_add(1);
            outcome()
        })
    })
}

/// The command, begun.
fn started(mut value: Cr) -> Cr {
    value.set_strt(true);
    value
}

/// What the flash says of the last operation.
fn outcome() -> Result<(), NorFlashErrorKind> {
    if family::failed() { Err(NorFlashErrorKind::Other) } else { Ok(()) }
}

/// Does something with the flash's control register open.
fn unlocked(change: impl FnOnce() -> Result<(), NorFlashErrorKind>) -> Result<(), NorFlashErrorKind> {
    while FLASH.sr().read().bsy() {}
    if FLASH.cr().read().lock() {
        FLASH.keyr().write_value(0x4567_0123);
        FLASH.keyr().write_value(0xCDEF_89AB);
    }
    // Ones clear what the flash has reported before.
    FLASH.sr().modify(|_| {});
    let outcome = family::uncached(change);
    FLASH.cr().modify(|w| w.set_lock(true));
    outcome
}

/// Gives the flash a command and waits until it is done.
///
/// # Safety
/// The addresses of a flash's registers.
#[inline(never)]
#[unsafe(link_section = ".fast.start")]
unsafe fn start(control: *mut u32, command: u32, status: *const u32, busy: u32) {
    // SAFETY: the caller's promise.
    unsafe {
        write_volatile(control, command);
        cortex_m::asm::dsb();
        while read_volatile(status) & busy != 0 {}
    }
}

/// Puts one unit into the flash and waits until it is there.
///
/// # Safety
/// An address inside the flash, which may be written, and that of its status.
#[inline(never)]
#[unsafe(link_section = ".fast.put")]
unsafe fn put(to: *mut [u32; family::WORDS], unit: &[u32; family::WORDS], status: *const u32, busy: u32) {
    let mut at: *mut u32 = to.cast();
    for word in unit {
        // SAFETY: the caller's promise.
        unsafe { write_volatile(at, *word) };
        at = at.wrapping_add(1);
    }
    cortex_m::asm::dsb();
    // SAFETY: the caller's promise.
    while unsafe { read_volatile(status) } & busy != 0 {}
}
