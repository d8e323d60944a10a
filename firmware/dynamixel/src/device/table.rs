//! What a device holds: the side of a device that differs from one to the next.

use crate::packet::{Id, StatusError, StatusReturn};
use crate::upkeep::{Backup, ResetScope};

/// What a device holds, and what becomes of a write.
///
/// A write to address, return delay or status return level takes effect after the answer to that write.
pub trait ControlTable {
    /// The device's address.
    fn id(&self) -> Id;
    /// A second address, to which the device listens without answering.
    fn secondary_id(&self) -> Option<Id> {
        None
    }
    /// Whether `bytes` may be written from `address` on under the second address: RAM only.
    fn is_shared(&self, address: u16, bytes: &[u8]) -> bool {
        let _ = (address, bytes);
        false
    }
    /// Model number, in the answer to Ping.
    fn model_number(&self) -> u16;
    /// Version of the firmware, in the answer to Ping.
    fn firmware_version(&self) -> u8;
    /// Whether a hardware error is present; sets the alert bit of every answer.
    fn alert(&self) -> bool {
        false
    }
    /// Which instructions are answered.
    fn status_return(&self) -> StatusReturn {
        StatusReturn::All
    }
    /// Microseconds between an instruction's end and the answer.
    fn return_delay_us(&self) -> u32 {
        0
    }
    /// Fills `bytes`, which is never empty, with the contents from `address` on.
    ///
    /// Errors: [`StatusError::Access`] where there is nothing to read.
    fn read(&mut self, address: u16, bytes: &mut [u8]) -> Result<(), StatusError>;
    /// Writes `bytes`, which is never empty, from `address` on: all of it or, on an error, nothing.
    ///
    /// Errors: [`StatusError::Access`], [`StatusError::DataLength`], [`StatusError::DataRange`],
    /// [`StatusError::DataLimit`]; [`crate::writes`] finds all but the last.
    fn write(&mut self, address: u16, bytes: &[u8]) -> Result<(), StatusError>;
    /// Whether `bytes`, which is never empty, could be written from `address` on now: a Reg Write is refused if not.
    fn check(&self, address: u16, bytes: &[u8]) -> Result<(), StatusError> {
        let _ = (address, bytes);
        Ok(())
    }
    /// Whether the device knows Fast Sync Read and Fast Bulk Read, which older firmware ignores.
    fn fast_reads(&self) -> bool {
        true
    }
    /// Whether a Reg Write waits for its Action (item Registered Instruction).
    fn registered(&mut self, waiting: bool) {
        let _ = waiting;
    }
    /// Restarts the device.
    fn reboot(&mut self) -> Result<(), StatusError> {
        Err(StatusError::Instruction)
    }
    /// Returns to the factory's values.
    fn factory_reset(&mut self, scope: ResetScope) -> Result<(), StatusError> {
        let _ = scope;
        Err(StatusError::Instruction)
    }
    /// Forgets the number of turns.
    fn clear_turns(&mut self) -> Result<(), StatusError> {
        Err(StatusError::Instruction)
    }
    /// Stores the control table, or restores it and restarts the device.
    ///
    /// Errors: [`StatusError::ResultFail`] with torque on, and where nothing was stored.
    fn backup(&mut self, what: Backup) -> Result<(), StatusError> {
        let _ = what;
        Err(StatusError::Instruction)
    }
}
