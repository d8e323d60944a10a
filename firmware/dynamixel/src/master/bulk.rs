//! Different bytes of several devices.

use embedded_hal_async::delay::DelayNs;
use embedded_io_async::{Read, Write};

use super::several::Part;
use super::{Answer, Error, Master, parameter_length};
use crate::encode::Encoder;
use crate::packet::{Id, Instruction};
use crate::request::Entry;

/// One device's part in a read of different bytes of several.
#[derive(Debug, PartialEq, Eq)]
pub struct BulkAnswer<'b, E> {
    /// Who is asked.
    pub id: Id,
    /// From which address on.
    pub address: u16,
    /// Where the bytes go, as many as are read.
    pub bytes: &'b mut [u8],
    /// How it went; nothing before the read. The bytes are as they were where it went wrong.
    pub result: Option<Result<Answer<()>, Error<E>>>,
}

impl<'b, E> BulkAnswer<'b, E> {
    /// A device to be asked for the bytes from `address` on, as many as `bytes` holds.
    pub const fn new(id: Id, address: u16, bytes: &'b mut [u8]) -> Self {
        BulkAnswer { id, address, bytes, result: None }
    }
}

impl<E> Part<E> for BulkAnswer<'_, E> {
    fn entry(&self) -> (Id, Entry) {
        // Whoever asks has made sure that the length has two bytes.
        (self.id, Entry { id: self.id.get(), address: self.address, length: self.bytes.len() as u16 })
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
            for (to, byte) in self.bytes.iter_mut().zip(bytes) {
                *to = *byte;
            }
            Answer { value: (), alert }
        }));
    }
}

/// One device's part in a write to several.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BulkWrite<'b> {
    /// Who is written to.
    pub id: Id,
    /// From which address on.
    pub address: u16,
    /// What.
    pub bytes: &'b [u8],
}

impl<U, D, const N: usize> Master<U, D, N>
where
    U: Read + Write,
    D: DelayNs,
{
    /// Reads different bytes of several devices with one instruction; each device's result lands in its entry. A device may be named
    /// once only.
    ///
    /// A device answers only after it has heard the one before it, so one that is silent silences those behind it.
    /// An error is returned only if the question could not be asked.
    pub async fn bulk_read(&mut self, devices: &mut [BulkAnswer<'_, U::Error>]) -> Result<(), Error<U::Error>> {
        let sent = self.ask_different(Instruction::BulkRead, devices)?;
        self.hear_each(sent, devices).await
    }

    /// As [`Master::bulk_read`], but all devices answer with one packet. For devices that know it: [`crate::Identity::reads_fast`].
    pub async fn fast_bulk_read(&mut self, devices: &mut [BulkAnswer<'_, U::Error>]) -> Result<(), Error<U::Error>> {
        let sent = self.ask_different(Instruction::FastBulkRead, devices)?;
        self.hear_together(sent, devices).await
    }

    /// Writes different bytes to several devices with one instruction. Nobody answers. A device may be named once only.
    pub async fn bulk_write(&mut self, devices: &[BulkWrite<'_>]) -> Result<(), Error<U::Error>> {
        once(devices.iter().map(|device| device.id))?;
        let mut encoder = Encoder::new(&mut self.transmit, Id::BROADCAST, Instruction::BulkWrite);
        for device in devices {
            encoder = encoder.bytes(&head(device.id, device.address, device.bytes)?).bytes(device.bytes);
        }
        let sent = encoder.finish().map_err(Error::TooLong)?.len();
        self.send(sent).await
    }

    fn ask_different(
        &mut self,
        instruction: Instruction,
        devices: &mut [BulkAnswer<'_, U::Error>],
    ) -> Result<usize, Error<U::Error>> {
        once(devices.iter().map(|device| device.id))?;
        let mut encoder = Encoder::new(&mut self.transmit, Id::BROADCAST, instruction);
        for device in devices.iter_mut() {
            device.begin();
            encoder = encoder.bytes(&head(device.id, device.address, device.bytes)?);
        }
        Ok(encoder.finish().map_err(Error::TooLong)?.len())
    }
}

/// What an instruction says of one device.
fn head<E>(id: Id, address: u16, bytes: &[u8]) -> Result<[u8; 5], Error<E>> {
    if id.is_broadcast() {
        return Err(Error::Broadcast);
    }
    let ([a, b], [c, d]) = (address.to_le_bytes(), parameter_length(bytes.len())?.to_le_bytes());
    Ok([id.get(), a, b, c, d])
}

/// Whether no device is named twice.
fn once<E>(ids: impl Iterator<Item = Id> + Clone) -> Result<(), Error<E>> {
    let mut rest = ids;
    while let Some(id) = rest.next() {
        if rest.clone().any(|other| other == id) {
            return Err(Error::Twice { id });
        }
    }
    Ok(())
}
