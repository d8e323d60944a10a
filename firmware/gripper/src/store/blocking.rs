//! The flash as the records' library wants it.

use core::future::Future;

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind};
use embedded_storage_async::nor_flash as waiting;

use crate::quiet::Quiet;

/// A flash that holds the processor until it is done, for who would wait for it.
///
/// A word whose programming or erasing lost its power cannot be read where the flash corrects errors: the board says so by an error. It
/// counts as zeros, which are part of no sound record and cannot be taken for erased.
pub(super) struct Blocking<F> {
    pub(super) flash: F,
    /// What a change waits for, if it holds more than the task that asks for it.
    pub(super) quiet: Option<&'static Quiet>,
}

impl<F> Blocking<F> {
    async fn change<R>(&mut self, mut change: impl FnMut(&mut F) -> R) -> R {
        let flash = &mut self.flash;
        match self.quiet {
            Some(quiet) => quiet.when(|| change(flash)).await,
            None => change(flash),
        }
    }
}

impl<F: NorFlash> Blocking<F> {
    fn read_torn(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), F::Error> {
        let Err(error) = self.flash.read(offset, bytes) else { return Ok(()) };
        if error.kind() == NorFlashErrorKind::OutOfBounds || error.kind() == NorFlashErrorKind::NotAligned {
            return Err(error);
        }
        let word = F::WRITE_SIZE.max(F::READ_SIZE);
        let (mut at, mut rest) = (offset, bytes);
        while !rest.is_empty() {
            let left = (word - at as usize % word).min(rest.len());
            let Some((part, behind)) = rest.split_at_mut_checked(left) else { return Err(error) };
            if self.flash.read(at, part).is_err() {
                part.fill(0);
            }
            at += part.len() as u32;
            rest = behind;
        }
        Ok(())
    }
}

impl<F: NorFlash> ErrorType for Blocking<F> {
    type Error = F::Error;
}

impl<F: NorFlash> waiting::ReadNorFlash for Blocking<F> {
    const READ_SIZE: usize = F::READ_SIZE;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> impl Future<Output = Result<(), F::Error>> {
        core::future::ready(self.read_torn(offset, bytes))
    }

    fn capacity(&self) -> usize {
        self.flash.capacity()
    }
}

impl<F: NorFlash> waiting::NorFlash for Blocking<F> {
    const WRITE_SIZE: usize = F::WRITE_SIZE;
    const ERASE_SIZE: usize = F::ERASE_SIZE;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), F::Error> {
        // A sector at a time, so that others run in between: the clock of some boards bears one of them at most.
        let sector = (F::ERASE_SIZE as u32).max(1);
        let mut at = from;
        while at < to {
            let end = at.saturating_add(sector).min(to);
            self.change(|flash| flash.erase(at, end)).await?;
            at = end;
        }
        Ok(())
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), F::Error> {
        self.change(|flash| flash.write(offset, bytes)).await
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use embassy_futures::block_on;
    use embedded_storage::nor_flash::ReadNorFlash;

    use super::*;

    /// Flash that notes what is erased.
    struct Flash(Vec<[u32; 2]>);

    impl ErrorType for Flash {
        type Error = NorFlashErrorKind;
    }

    impl ReadNorFlash for Flash {
        const READ_SIZE: usize = 1;

        fn read(&mut self, _: u32, _: &mut [u8]) -> Result<(), NorFlashErrorKind> {
            Ok(())
        }

        fn capacity(&self) -> usize {
            0x4000
        }
    }

    impl NorFlash for Flash {
        const WRITE_SIZE: usize = 4;
        const ERASE_SIZE: usize = 0x1000;

        fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
            self.0.push([from, to]);
            if from == 0x3000 { Err(NorFlashErrorKind::Other) } else { Ok(()) }
        }

        fn write(&mut self, _: u32, _: &[u8]) -> Result<(), NorFlashErrorKind> {
            Ok(())
        }
    }

    /// Flash that is not to be trusted is erased as a whole: that must not hold the processor longer than one sector does.
    #[test]
    fn a_range_is_erased_sector_by_sector() {
        let mut flash = Blocking { flash: Flash(Vec::new()), quiet: None };
        let mut erase = |from, to| block_on(waiting::NorFlash::erase(&mut flash, from, to));
        let outcomes = [erase(0x1000, 0x3000), erase(0x1000, 0x1000), erase(0x2000, 0x4000)];
        assert_eq!(outcomes, [Ok(()), Ok(()), Err(NorFlashErrorKind::Other)]);
        assert_eq!(flash.flash.0, [[0x1000, 0x2000], [0x2000, 0x3000], [0x2000, 0x3000], [0x3000, 0x4000]]);
    }
}
