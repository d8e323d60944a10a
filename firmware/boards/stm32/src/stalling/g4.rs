//! The STM32G4's of two banks: pages of 2 KB, written by two words.

use embassy_stm32::pac::FLASH;
use embassy_stm32::pac::flash::regs::Cr;
use embedded_storage::nor_flash::NorFlashErrorKind;

/// Words that are written at once.
pub(super) const WORDS: usize = 2;
/// Nothing to do.
pub(super) const IDLE: Cr = Cr(0);
/// Words are written.
pub(super) const WRITING: Cr = Cr(1);
/// Bytes of a bank.
const BANK: u32 = 0x4_0000;

/// A page is to be erased, once it is started.
pub(super) fn erasing<const SECTOR: u32>(place: u32) -> Cr {
    let mut value = IDLE;
    value.set_per(true);
    value.set_bker(place >= BANK);
    value.set_pnb((place % BANK / SECTOR) as u8);
    value
}

/// Whether the flash reports an error of the last operation.
pub(super) fn failed() -> bool {
    let status = FLASH.sr().read();
    status.progerr() || status.wrperr() || status.pgaerr() || status.sizerr() || status.pgserr()
}

/// Does something while the flash interface caches no data, and has it forget what it held.
pub(super) fn uncached(change: impl FnOnce() -> Result<(), NorFlashErrorKind>) -> Result<(), NorFlashErrorKind> {
    let was_on = FLASH.acr().read().dcen();
    FLASH.acr().modify(|w| w.set_dcen(false));
    let outcome = change();
    if was_on {
        FLASH.acr().modify(|w| w.set_dcrst(true));
        FLASH.acr().modify(|w| w.set_dcrst(false));
        FLASH.acr().modify(|w| w.set_dcen(true));
    }
    outcome
}
