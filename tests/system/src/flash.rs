//! The bench's flash: bytes in memory, erased and written as a microcontroller's are.

use std::cell::RefCell;
use std::rc::Rc;

use embedded_storage::nor_flash::{
    self, NorFlash, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};

/// Flash that outlives a bench.
#[derive(Clone)]
pub struct Flash(Rc<RefCell<Vec<u8>>>);

impl Flash {
    /// Erased.
    #[allow(clippy::new_without_default)]
    pub fn new() -> Self {
        Self(Rc::new(RefCell::new(vec![0xFF; 16 * 1024])))
    }

    /// Overwrites one byte.
    pub fn damage(&self, at: usize, byte: u8) {
        let mut bytes = self.0.borrow_mut();
        let length = bytes.len();
        bytes[at % length] = byte;
    }
}

impl nor_flash::ErrorType for Flash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        check_read(self, offset, bytes.len())?;
        bytes.copy_from_slice(&self.0.borrow()[offset as usize..][..bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.0.borrow().len()
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = 8;
    const ERASE_SIZE: usize = 2048;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        check_erase(self, from, to)?;
        self.0.borrow_mut()[from as usize..to as usize].fill(0xFF);
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        check_write(self, offset, bytes.len())?;
        for (place, byte) in self.0.borrow_mut()[offset as usize..].iter_mut().zip(bytes) {
            *place &= byte;
        }
        Ok(())
    }
}
