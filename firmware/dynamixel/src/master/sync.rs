//! The same bytes of several devices.

use embedded_hal_async::delay::DelayNs;
use embedded_io_async::{Read, Write};

use super::several::Part;
use super::{Answer, Error, Master, parameter_length};
use crate::encode::Encoder;
use crate::packet::{Id, Instruction};
use crate::request::Entry;

/// One device's part in a read of `L` bytes of several.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SyncAnswer<E, const L: usize> {
    /// Who is asked.
    pub id: Id,
    /// What it answered; nothing before the read.
    pub result: Option<Result<Answer<[u8; L]>, Error<E>>>,
}

impl<E, const L: usize> SyncAnswer<E, L> {
    /// A device to be asked.
    pub const fn new(id: Id) -> Self {
        SyncAnswer { id, result: None }
    }
}

impl<E, const L: usize> Part<E> for SyncAnswer<E, L> {
    fn entry(&self) -> (Id, Entry) {
        // Whoever asks has made sure that the length has two bytes.
        (self.id, Entry { id: self.id.get(), address: 0, length: L as u16 })
    }

    fn begin(&mut self) {
        self.result = None;
    }

    fn waits(&self) -> bool {
        self.result.is_none()
    }

    fn is_good(&self) -> bool {
        matches!(self.result, Some(Ok(_)))
    }

    fn settle(&mut self, result: Result<(&[u8], bool), Error<E>>) {
        self.result = Some(result.map(|(bytes, alert)| {
            let mut value = [0; L];
            for (to, byte) in value.iter_mut().zip(bytes) {
                *to = *byte;
            }
            Answer { value, alert }
        }));
    }
}

impl<U, D, const N: usize> Master<U, D, N>
where
    U: Read + Write,
    D: DelayNs,
{
    /// Reads the same `L` bytes of several devices with one instruction; each device's result lands in its entry.
    ///
    /// A device answers only after it has heard the one before it, so one that is silent silences those behind it.
    /// An error is returned only if the question could not be asked.
    pub async fn sync_read<const L: usize>(
        &mut self,
        address: u16,
        devices: &mut [SyncAnswer<U::Error, L>],
    ) -> Result<(), Error<U::Error>> {
        let sent = self.ask_same(Instruction::SyncRead, address, devices)?;
        self.hear_each(sent, devices).await
    }

    /// As [`Master::sync_read`], but all devices answer with one packet, which saves a packet's frame and a return delay
    /// per device. For devices that know it: [`crate::Identity::reads_fast`].
    ///
    /// A device's part counts as soon as its own CRC has come, so one that is silent silences only those behind it.
    pub async fn fast_sync_read<const L: usize>(
        &mut self,
        address: u16,
        devices: &mut [SyncAnswer<U::Error, L>],
    ) -> Result<(), Error<U::Error>> {
        let sent = self.ask_same(Instruction::FastSyncRead, address, devices)?;
        self.hear_together(sent, devices).await
    }

    /// Writes `L` bytes from `address` on to several devices with one instruction. Nobody answers.
    pub async fn sync_write<const L: usize>(
        &mut self,
        address: u16,
        devices: &[(Id, [u8; L])],
    ) -> Result<(), Error<U::Error>> {
        let [a, b] = address.to_le_bytes();
        let [c, d] = parameter_length(L)?.to_le_bytes();
        let mut encoder = Encoder::new(&mut self.transmit, Id::BROADCAST, Instruction::SyncWrite).bytes(&[a, b, c, d]);
        for (id, bytes) in devices {
            encoder = encoder.byte(id.get()).bytes(bytes);
        }
        let sent = encoder.finish().map_err(Error::TooLong)?.len();
        self.send(sent).await
    }

    /// Prepares a read of the same bytes of several devices; gives the instruction's length.
    fn ask_same<const L: usize>(
        &mut self,
        instruction: Instruction,
        address: u16,
        devices: &mut [SyncAnswer<U::Error, L>],
    ) -> Result<usize, Error<U::Error>> {
        let [a, b] = address.to_le_bytes();
        let [c, d] = parameter_length(L)?.to_le_bytes();
        let mut encoder = Encoder::new(&mut self.transmit, Id::BROADCAST, instruction).bytes(&[a, b, c, d]);
        for device in devices.iter_mut() {
            if device.id.is_broadcast() {
                return Err(Error::Broadcast);
            }
            device.begin();
            encoder = encoder.byte(device.id.get());
        }
        Ok(encoder.finish().map_err(Error::TooLong)?.len())
    }
}
