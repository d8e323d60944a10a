//! Where settings live: a stretch of the board's PSRAM that behaves like NOR flash. QEMU's resets leave it alone.
//!
//! Writing only clears bits, and only erasing a whole sector sets them, as on a chip.

use core::ptr::{read_volatile, write_volatile};

use embedded_storage::nor_flash::{
    ErrorType, MultiwriteNorFlash, NorFlash, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};

/// Start of the PSRAM (Arm AN500).
const START: usize = 0x6000_0000;
/// Bytes that act as flash.
const BYTES: usize = 64 * 1024;
/// Behind them: says that they are erased or written, not what a PSRAM happens to hold at power-on.
const MARK: *mut u32 = (START + BYTES) as *mut u32;
const FORMATTED: u32 = 0x4653_4831;

/// The flash.
pub struct Flash(());

impl Flash {
    /// The one flash; erased if this is the power-on.
    pub(crate) fn start() -> Self {
        let mut flash = Self(());
        // SAFETY: aligned word of the PSRAM, used by this module only.
        if unsafe { read_volatile(MARK) } != FORMATTED {
            flash.fill(0, BYTES as u32);
            // SAFETY: as above.
            unsafe { write_volatile(MARK, FORMATTED) };
        }
        flash
    }

    fn fill(&mut self, from: u32, to: u32) {
        for at in from as usize..to as usize {
            // SAFETY: callers stay below `BYTES`; this stretch of the PSRAM is this module's, and there is one `Flash`.
            unsafe { write_volatile((START + at) as *mut u8, 0xFF) };
        }
    }
}

impl ErrorType for Flash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        check_read(self, offset, bytes.len())?;
        for (at, byte) in bytes.iter_mut().enumerate() {
            // SAFETY: inside, by the check above.
            *byte = unsafe { read_volatile((START + offset as usize + at) as *const u8) };
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        BYTES
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = 4096;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        check_erase(self, from, to)?;
        self.fill(from, to);
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        check_write(self, offset, bytes.len())?;
        for (at, byte) in bytes.iter().enumerate() {
            let place = (START + offset as usize + at) as *mut u8;
            // SAFETY: inside, by the check above.
            unsafe { write_volatile(place, read_volatile(place) & byte) };
        }
        Ok(())
    }
}

impl MultiwriteNorFlash for Flash {}
