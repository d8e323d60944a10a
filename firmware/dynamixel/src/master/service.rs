//! Instructions that change what a device is, or when it does what it was asked for.

use embedded_hal_async::delay::DelayNs;
use embedded_io_async::{Read, Write};

use super::{Answer, Error, Master};
use crate::packet::{Id, Instruction};
use crate::upkeep::{BACKUP_KEY, Backup, CLEAR_KEY, ResetScope};

impl<U, D, const N: usize> Master<U, D, N>
where
    U: Read + Write,
    D: DelayNs,
{
    /// Keeps a write from `address` on until [`Master::action`]: one at a time per device, a later one replaces it.
    pub async fn reg_write(&mut self, id: Id, address: u16, bytes: &[u8]) -> Result<Answer<()>, Error<U::Error>> {
        self.order(id, Instruction::RegWrite, &[&address.to_le_bytes(), bytes]).await
    }

    /// Carries out the write that was kept; to every device at once by broadcast, which is not answered.
    pub async fn action(&mut self, id: Id) -> Result<Answer<()>, Error<U::Error>> {
        self.order(id, Instruction::Action, &[]).await
    }

    /// Restarts a device. It does not answer further instructions for a while.
    pub async fn reboot(&mut self, id: Id) -> Result<Answer<()>, Error<U::Error>> {
        self.order(id, Instruction::Reboot, &[]).await
    }

    /// Returns a device's control table to the factory's values and restarts it. With [`ResetScope::All`] its address becomes 1 and its
    /// baud rate 57,600.
    ///
    /// # Errors
    /// [`Error::Broadcast`] for everything of every device at once: afterwards all of them would have one address. Devices refuse it as
    /// well (ROBOTIS e-Manual, Protocol 2.0, "Factory Reset").
    pub async fn factory_reset(&mut self, id: Id, scope: ResetScope) -> Result<Answer<()>, Error<U::Error>> {
        if id.is_broadcast() && scope == ResetScope::All {
            return Err(Error::Broadcast);
        }
        self.order(id, Instruction::FactoryReset, &[&[scope.code()]]).await
    }

    /// Forgets the number of turns: Present Position becomes 0 to 4095. A servo that moves refuses.
    pub async fn clear_turns(&mut self, id: Id) -> Result<Answer<()>, Error<U::Error>> {
        self.order(id, Instruction::Clear, &[&[1], &CLEAR_KEY]).await
    }

    /// Stores the control table's EEPROM, gains, profile and indirect addresses, or restores them. A servo with torque refuses.
    pub async fn backup(&mut self, id: Id, what: Backup) -> Result<Answer<()>, Error<U::Error>> {
        self.order(id, Instruction::ControlTableBackup, &[&[what.code()], &BACKUP_KEY]).await
    }
}
