//! One question to several devices.

use embassy_futures::select::{Either, select};
use embedded_hal_async::delay::DelayNs;
use embedded_io_async::{Read, Write};

use super::listen::{CHUNK, Listening, copy};
use super::{Answer, Error, Identity, Master};
use crate::device::BROADCAST_PING_SLOT_US;
use crate::encode::{EncodeError, Encoder};
use crate::fast::{BLOCK_LENGTH, FRONT_LENGTH, FastAnswer, Step, frame_length};
use crate::packet::{ALERT, Id, Instruction, Status, StatusError, longest_packet_length, status_length};
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
        let wait = slots.saturating_add(self.timing.wire_us(sent + status_length(3)));
        let wait = wait.saturating_add(self.timing.latency_us);
        let mut listening = Listening::new(sent + addresses * longest_packet_length(4));
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
        match result {
            Err(error @ (Error::Port(_) | Error::Closed | Error::Babble { .. })) if count == 0 => Err(error),
            _ => Ok(count),
        }
    }

    /// Reads the same `L` bytes of several devices with one instruction; each device's result lands in its entry.
    ///
    /// A device answers only after it has heard the one before it, so one that is silent silences those behind it.
    /// An error is returned only if the question could not be asked.
    pub async fn sync_read<const L: usize>(
        &mut self,
        address: u16,
        devices: &mut [SyncAnswer<U::Error, L>],
    ) -> Result<(), Error<U::Error>> {
        let sent = self.ask_several(Instruction::SyncRead, address, devices)?;
        self.expect_to_fit(L)?;
        self.send(sent).await?;

        let answer = longest_packet_length(L + 1);
        let mut listening = Listening::new(sent + devices.len().saturating_mul(answer));
        // The question's time counts towards the first answer only.
        let mut wait = self.timing.wire_us(sent + answer).saturating_add(self.timing.latency_us);
        while let Some(waiting) = devices.iter().find(|device| device.result.is_none()).map(|device| device.id) {
            let accept = |status: &Status<'_>| {
                let device = devices.iter_mut().find(|device| device.result.is_none() && device.id == status.id)?;
                let mut value = [0; L];
                device.result = Some(copy(status, &mut value).map(|alert| Answer { value, alert }));
                Some(())
            };
            if let Err(error) = self.listen(waiting, wait, &mut listening, accept).await {
                give_up(devices, error, wait);
                break;
            }
            wait = self.timing.wire_us(answer).saturating_add(self.timing.latency_us);
        }
        self.unsettled |= devices.iter().any(|device| !matches!(device.result, Some(Ok(_))));
        Ok(())
    }

    /// As [`Master::sync_read`], but all devices answer with one packet, which saves a packet's frame and a return delay
    /// per device. For devices that know it: [`Identity::reads_fast`].
    ///
    /// A device's part counts as soon as its own CRC has come, so one that is silent silences only those behind it.
    pub async fn fast_sync_read<const L: usize>(
        &mut self,
        address: u16,
        devices: &mut [SyncAnswer<U::Error, L>],
    ) -> Result<(), Error<U::Error>> {
        let sent = self.ask_several(Instruction::FastSyncRead, address, devices)?;
        let total = FRONT_LENGTH + devices.len().saturating_mul(L + BLOCK_LENGTH);
        let block = super::parameter_length(L)?;
        let length = frame_length(devices.iter().map(|_| block));
        let length = length.ok_or(Error::TooLong(EncodeError::TooLong { length: total }))?;
        self.send(sent).await?;

        let wait = self.timing.wire_us(sent + total).saturating_add(self.timing.latency_us);
        let mut answer = FastAnswer::new(length);
        let listening = follow(&mut self.port, &mut answer, block, address, devices, 2 * (sent + total) + CHUNK);
        let failed = match select(listening, self.delay.delay_us(wait)).await {
            Either::First(result) => result.err(),
            Either::Second(()) => {
                let silent = devices.iter().find(|device| device.result.is_none());
                silent.map(|device| Error::Timeout { id: device.id, waited_us: wait })
            }
        };
        if let Some(error) = failed {
            give_up(devices, error, wait);
        }
        self.unsettled = devices.iter().any(|device| !matches!(device.result, Some(Ok(_))));
        Ok(())
    }

    /// Prepares a read of several devices; gives the instruction's length.
    fn ask_several<const L: usize>(
        &mut self,
        instruction: Instruction,
        address: u16,
        devices: &mut [SyncAnswer<U::Error, L>],
    ) -> Result<usize, Error<U::Error>> {
        let [a, b] = address.to_le_bytes();
        let [c, d] = super::parameter_length(L)?.to_le_bytes();
        let mut encoder = Encoder::new(&mut self.transmit, Id::BROADCAST, instruction).bytes(&[a, b, c, d]);
        for device in devices.iter_mut() {
            if device.id.is_broadcast() {
                return Err(Error::Broadcast);
            }
            device.result = None;
            encoder = encoder.byte(device.id.get());
        }
        Ok(encoder.finish().map_err(Error::TooLong)?.len())
    }

    /// Writes `L` bytes from `address` on to several devices with one instruction. Nobody answers.
    pub async fn sync_write<const L: usize>(
        &mut self,
        address: u16,
        devices: &[(Id, [u8; L])],
    ) -> Result<(), Error<U::Error>> {
        let [a, b] = address.to_le_bytes();
        let [c, d] = super::parameter_length(L)?.to_le_bytes();
        let mut encoder = Encoder::new(&mut self.transmit, Id::BROADCAST, Instruction::SyncWrite).bytes(&[a, b, c, d]);
        for (id, bytes) in devices {
            encoder = encoder.byte(id.get()).bytes(bytes);
        }
        let sent = encoder.finish().map_err(Error::TooLong)?.len();
        self.send(sent).await
    }
}

/// Whoever has not answered: the first for this reason, the others because they were not heard either.
fn give_up<E, const L: usize>(devices: &mut [SyncAnswer<E, L>], error: Error<E>, waited_us: u32) {
    let mut error = Some(error);
    for device in devices.iter_mut().filter(|device| device.result.is_none()) {
        let silence = Error::Timeout { id: device.id, waited_us };
        device.result = Some(Err(error.take().unwrap_or(silence)));
    }
}

/// Reads the answer to a fast read until it is complete, or until more than `budget` bytes have come.
async fn follow<U: Read, const L: usize>(
    port: &mut U,
    answer: &mut FastAnswer,
    length: u16,
    address: u16,
    devices: &mut [SyncAnswer<U::Error, L>],
    budget: usize,
) -> Result<(), Error<U::Error>> {
    let mut received = 0;
    let mut chunk = [0; CHUNK];
    let mut data = [0; L];
    while devices.last().is_some_and(|device| device.result.is_none()) {
        let count = port.read(&mut chunk).await.map_err(Error::Port)?;
        if count == 0 {
            return Err(Error::Closed);
        }
        received += count;
        for &byte in chunk.get(..count).unwrap_or_default() {
            let entry = |place: usize| devices.get(place).map(|device| Entry { id: device.id.get(), address, length });
            match answer.push(byte, entry, &mut data) {
                Step::More => {}
                Step::Block { place, error, .. } => {
                    if let Some(device) = devices.get_mut(place) {
                        let alert = error & ALERT != 0;
                        device.result = Some(match StatusError::from_code(error) {
                            Some(error) => Err(Error::Refused { id: device.id, error, alert }),
                            None => Ok(Answer { value: data, alert }),
                        });
                    }
                }
                Step::Broken => {
                    let silent = devices.iter().find(|device| device.result.is_none());
                    return silent.map_or(Ok(()), |device| Err(Error::Block { id: device.id }));
                }
            }
        }
        if received > budget {
            return Err(Error::Babble { bytes: received });
        }
    }
    Ok(())
}
