//! A stretch of the chip's flash, for settings.

use core::marker::PhantomData;

use crate::torn;
use embassy_stm32::flash::{Blocking, Error, FLASH_BASE, Flash, WRITE_SIZE};
use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};

/// What a chip needs around erasing, writing and reading.
pub trait Care {
    /// Copies what flash holds from this address on; false if a word of it was torn by a loss of power, so that the chip's error
    /// correction gives up. Without error correction it is always true.
    fn read(address: u32, into: &mut [u8]) -> bool {
        // SAFETY: `Settings` asks for addresses inside the flash.
        unsafe { torn::copy(address, into) };
        true
    }
    /// Erases whole sectors, those between two places, counted from the flash's start.
    ///
    /// # Errors
    /// The flash has not done so.
    fn erase(flash: &mut Flash<'static, Blocking>, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        flash.blocking_erase(from, to).map_err(kind)
    }
    /// Writes from a place on, counted from the flash's start.
    ///
    /// # Errors
    /// The flash has not done so.
    fn write(flash: &mut Flash<'static, Blocking>, place: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        flash.blocking_write(place, bytes).map_err(kind)
    }
    /// Called after flash has changed, from this address on: caches may hold what was there.
    fn changed(_address: u32, _bytes: u32) {}
}

/// The processor's data cache forgets what it holds of changed flash. For [`Care::changed`] on a Cortex-M7.
pub fn forget_cached(address: u32, bytes: u32) {
    let first = address as usize & !31;
    let end = (address + bytes) as usize;
    // SAFETY: settings' sectors hold no variables: nothing dirty is thrown away.
    unsafe { cortex_m::Peripherals::steal().SCB.invalidate_dcache_by_address(first, end - first) };
}

/// `BYTES` of flash from `START` (counted from the flash's own start), in sectors of `SECTOR` bytes.
pub struct Settings<C, const START: u32, const BYTES: u32, const SECTOR: u32> {
    flash: Flash<'static, Blocking>,
    care: PhantomData<C>,
}

impl<C: Care, const START: u32, const BYTES: u32, const SECTOR: u32> Settings<C, START, BYTES, SECTOR> {
    /// This stretch of that flash.
    pub const fn new(flash: Flash<'static, Blocking>) -> Self {
        const { assert!(START.is_multiple_of(SECTOR) && BYTES.is_multiple_of(SECTOR) && BYTES >= 2 * SECTOR) };
        Self { flash, care: PhantomData }
    }

    /// Where a range lies in the flash, if it is inside.
    fn place(from: u32, bytes: usize) -> Result<u32, NorFlashErrorKind> {
        let inside =
            u32::try_from(bytes).ok().and_then(|bytes| from.checked_add(bytes)).is_some_and(|end| end <= BYTES);
        if inside { Ok(START + from) } else { Err(NorFlashErrorKind::OutOfBounds) }
    }
}

fn kind(error: Error) -> NorFlashErrorKind {
    error.kind()
}

impl<C: Care, const START: u32, const BYTES: u32, const SECTOR: u32> ErrorType for Settings<C, START, BYTES, SECTOR> {
    type Error = NorFlashErrorKind;
}

impl<C: Care, const START: u32, const BYTES: u32, const SECTOR: u32> ReadNorFlash
    for Settings<C, START, BYTES, SECTOR>
{
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        let place = Self::place(offset, bytes.len())?;
        if C::read(FLASH_BASE as u32 + place, bytes) { Ok(()) } else { Err(NorFlashErrorKind::Other) }
    }

    fn capacity(&self) -> usize {
        BYTES as usize
    }
}

impl<C: Care, const START: u32, const BYTES: u32, const SECTOR: u32> NorFlash for Settings<C, START, BYTES, SECTOR> {
    const WRITE_SIZE: usize = WRITE_SIZE;
    const ERASE_SIZE: usize = SECTOR as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        let start = Self::place(from, to.checked_sub(from).ok_or(NorFlashErrorKind::OutOfBounds)? as usize)?;
        if !from.is_multiple_of(SECTOR) || !to.is_multiple_of(SECTOR) {
            return Err(NorFlashErrorKind::NotAligned);
        }
        let outcome = C::erase(&mut self.flash, start, START + to);
        C::changed(FLASH_BASE as u32 + start, to - from);
        outcome
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        let place = Self::place(offset, bytes.len())?;
        let outcome = C::write(&mut self.flash, place, bytes);
        C::changed(FLASH_BASE as u32 + place, bytes.len() as u32);
        outcome
    }
}
