//! The STM32F7's: one bank, sectors of different sizes, written by words.

use embassy_stm32::pac::FLASH;
use embassy_stm32::pac::flash::{regs::Cr, vals::Psize};
use embedded_storage::nor_flash::NorFlashErrorKind;

/// Words that are written at once.
pub(super) const WORDS: usize = 1;
/// By words (PSIZE at bit 8): bytes take longer.
const BY_WORDS: u32 = (Psize::PSIZE32 as u32) << 8;
/// Nothing to do.
pub(super) const IDLE: Cr = Cr(BY_WORDS);
/// Words are written.
pub(super) const WRITING: Cr = Cr(BY_WORDS | 1);

/// A sector is to be erased, once it is started; those of one size at the flash's start have the numbers from 0.
pub(super) fn erasing<const SECTOR: u32>(place: u32) -> Cr {
    let mut value = IDLE;
    value.set_ser(true);
    value.set_snb((place / SECTOR) as u8);
    value
}

/// Whether the flash reports an error of the last operation.
pub(super) fn failed() -> bool {
    let status = FLASH.sr().read();
    status.erserr() || status.pgperr() || status.pgaerr() || status.wrperr()
}

/// The flash interface caches no data; the processor's cache is [`Care::changed`](crate::Care::changed)'s.
pub(super) fn uncached(change: impl FnOnce() -> Result<(), NorFlashErrorKind>) -> Result<(), NorFlashErrorKind> {
    change()
}
