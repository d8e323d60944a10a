//! Asks every device on the bus what it is.

use embedded_hal_async::delay::DelayNs;
use embedded_io_async::{Read, Write};

use super::listen::Listening;
use super::{Error, Identity, Master};
use crate::packet::{Id, Instruction, Status, longest_packet_length, status_length};
use crate::timing::BROADCAST_PING_SLOT_US;

/// A device that was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Found {
    /// Its address.
    pub id: Id,
    /// What it is.
    pub identity: Identity,
    /// It has a hardware error.
    pub alert: bool,
}

impl<U, D, const N: usize> Master<U, D, N>
where
    U: Read + Write,
    D: DelayNs,
{
    /// Asks every device on the bus what it is: those that answer, in the order of their answers, as many as there is room
    /// for. Gives how many that are. Takes three quarters of a second, for devices answer in the order of their addresses.
    ///
    /// An answer that is damaged, as when two devices have one address, is left out.
    pub async fn discover(&mut self, found: &mut [Option<Found>]) -> Result<usize, Error<U::Error>> {
        found.fill(None);
        let sent = self.prepare(Id::BROADCAST, Instruction::Ping, &[])?;
        self.send(sent).await?;
        let addresses = usize::from(Id::MAX.get()) + 1;
        let slots = (addresses as u32).saturating_mul(BROADCAST_PING_SLOT_US);
        // An answer that is longer than its slot may hold up those behind it: as long as all take that there is room for.
        let answers = found.len().max(1).min(addresses).saturating_mul(status_length(3));
        let wait = slots.saturating_add(self.timing.wire_us(sent + answers));
        let wait = wait.saturating_add(self.timing.latency_us);
        let mut listening = Listening::new(sent + addresses * longest_packet_length(4), self.sent);
        let mut count = 0;
        let note = |status: &Status<'_>| {
            if let (&[low, high, firmware], None) = (status.parameters, status.error)
                && let Some(place) = found.get_mut(count)
            {
                let identity = Identity { model: u16::from_le_bytes([low, high]), firmware };
                *place = Some(Found { id: status.id, identity, alert: status.alert });
                count += 1;
            }
            // There is no last one to wait for.
            None::<()>
        };
        let result = self.listen(Id::BROADCAST, wait, &mut listening, note).await;
        self.foreign = self.foreign.saturating_add(listening.foreign);
        match result {
            Err(error @ (Error::Port(_) | Error::Closed | Error::Babble { .. })) if count == 0 => Err(error),
            _ => Ok(count),
        }
    }
}
