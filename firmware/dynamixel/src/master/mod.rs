//! The asking side of the bus: one instruction at a time, a deadline for every answer.

mod error;
mod listen;
mod values;

pub use error::Error;

use embassy_futures::poll_once;
use embassy_futures::select::{Either, select};
use embedded_hal_async::delay::DelayNs;
use embedded_io_async::{Read, Write};

use listen::{CHUNK, Inbox, Listening, copy, hear};

use crate::decode::Decoder;
use crate::encode::{EncodeError, Encoder};
use crate::packet::{Id, Instruction, Status, StatusReturn, longest_packet_length, packet_length};

/// How long the master waits.
///
/// The deadline of an answer is the time the bytes of question and answer take on the wire plus `latency_us`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Timing {
    /// Bits per second on the wire (10 per byte); 0 counts as 1.
    pub baud_rate: u32,
    /// Microseconds beyond the wire time: the devices' return delay (factory: 500), and what port and scheduler add.
    pub latency_us: u32,
    /// Which instructions the devices answer; a write to a device that does not answer it is not waited for.
    pub status_return: StatusReturn,
}

impl Timing {
    /// Timing at `baud_rate` for devices with factory settings: 500 µs return delay and 1500 µs for port and scheduler.
    pub const fn at(baud_rate: u32) -> Self {
        Timing { baud_rate, latency_us: 2_000, status_return: StatusReturn::All }
    }

    /// Microseconds that `bytes` take on the wire, rounded up.
    pub const fn wire_us(&self, bytes: usize) -> u32 {
        let rate = if self.baud_rate == 0 { 1 } else { self.baud_rate as u64 };
        let us = (bytes as u64).saturating_mul(10_000_000).div_ceil(rate);
        if us > u32::MAX as u64 { u32::MAX } else { us as u32 }
    }
}

/// What a device answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Answer<T> {
    /// What was asked for.
    pub value: T,
    /// A hardware error is present in the device; [`crate::xm430::HARDWARE_ERROR_STATUS`] tells which.
    pub alert: bool,
}

/// What a device says to Ping.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Identity {
    /// Model number, 1020 for the XM430-W350.
    pub model: u16,
    /// Version of the device's firmware.
    pub firmware: u8,
}

/// One device's part in a Sync Read of `L` bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
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

/// The master of a bus. `N` bounds instructions and answers in bytes, stuffing included.
///
/// - `U` is the port; its future may be dropped while it waits for bytes. Own bytes that the wiring echoes are ignored.
/// - `D` measures the deadlines: `embassy_time::Delay` on a target.
///
/// Before it asks, the master discards what has arrived meanwhile; after a failed transaction it also waits for
/// `latency_us` of silence, so that a late answer is not taken for the next one. (The protocol has no sequence numbers:
/// an answer still later than that cannot be told from the right one.)
#[derive(Debug)]
pub struct Master<U, D, const N: usize = 128> {
    port: U,
    delay: D,
    timing: Timing,
    decoder: Decoder<N>,
    transmit: [u8; N],
    inbox: Inbox,
    unsettled: bool,
}

impl<U, D, const N: usize> Master<U, D, N>
where
    U: Read + Write,
    D: DelayNs,
{
    /// A master on this port.
    pub const fn new(port: U, delay: D, timing: Timing) -> Self {
        Master {
            port,
            delay,
            timing,
            decoder: Decoder::new(),
            transmit: [0; N],
            inbox: Inbox { bytes: [0; CHUNK], start: 0, end: 0 },
            // Who knows what was on the bus before.
            unsettled: true,
        }
    }

    /// How long the master waits.
    pub fn timing(&self) -> Timing {
        self.timing
    }

    /// Changes how long the master waits, as after a change of the baud rate.
    pub fn set_timing(&mut self, timing: Timing) {
        self.timing = timing;
    }

    /// The port, to change its baud rate for instance.
    pub fn port_mut(&mut self) -> &mut U {
        &mut self.port
    }

    /// Gives the port back.
    pub fn into_port(self) -> U {
        self.port
    }

    /// Asks a device what it is.
    pub async fn ping(&mut self, id: Id) -> Result<Answer<Identity>, Error<U::Error>> {
        let mut identity = [0; 3];
        let alert = self.ask(id, Instruction::Ping, &[], &mut identity).await?;
        let [low, high, firmware] = identity;
        Ok(Answer { value: Identity { model: u16::from_le_bytes([low, high]), firmware }, alert })
    }

    /// Reads the bytes from `address` on, as many as `bytes` holds.
    pub async fn read(&mut self, id: Id, address: u16, bytes: &mut [u8]) -> Result<Answer<()>, Error<U::Error>> {
        let length = parameter_length(bytes.len())?;
        let [a, b] = address.to_le_bytes();
        let [c, d] = length.to_le_bytes();
        let alert = self.ask(id, Instruction::Read, &[&[a, b, c, d]], bytes).await?;
        Ok(Answer { value: (), alert })
    }

    /// Writes bytes from `address` on. A broadcast is not answered; its alert is always false.
    pub async fn write(&mut self, id: Id, address: u16, bytes: &[u8]) -> Result<Answer<()>, Error<U::Error>> {
        let address = address.to_le_bytes();
        if id.is_broadcast() || !self.timing.status_return.answers(Instruction::Write.code()) {
            self.tell(id, Instruction::Write, &[&address, bytes]).await?;
            return Ok(Answer { value: (), alert: false });
        }
        let alert = self.ask(id, Instruction::Write, &[&address, bytes], &mut []).await?;
        Ok(Answer { value: (), alert })
    }

    /// Restarts a device. It does not answer further instructions for a while.
    pub async fn reboot(&mut self, id: Id) -> Result<Answer<()>, Error<U::Error>> {
        if id.is_broadcast() || !self.timing.status_return.answers(Instruction::Reboot.code()) {
            self.tell(id, Instruction::Reboot, &[]).await?;
            return Ok(Answer { value: (), alert: false });
        }
        let alert = self.ask(id, Instruction::Reboot, &[], &mut []).await?;
        Ok(Answer { value: (), alert })
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
        let [a, b] = address.to_le_bytes();
        let [c, d] = parameter_length(L)?.to_le_bytes();
        let mut encoder = Encoder::new(&mut self.transmit, Id::BROADCAST, Instruction::SyncRead).bytes(&[a, b, c, d]);
        for device in devices.iter_mut() {
            if device.id.is_broadcast() {
                return Err(Error::Broadcast);
            }
            device.result = None;
            encoder = encoder.byte(device.id.get());
        }
        let sent = encoder.finish().map_err(Error::TooLong)?.len();
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
                let mut error = Some(error);
                for device in devices.iter_mut().filter(|device| device.result.is_none()) {
                    let silence = Error::Timeout { id: device.id, waited_us: wait };
                    device.result = Some(Err(error.take().unwrap_or(silence)));
                }
                break;
            }
            wait = self.timing.wire_us(answer).saturating_add(self.timing.latency_us);
        }
        self.unsettled |= devices.iter().any(|device| !matches!(device.result, Some(Ok(_))));
        Ok(())
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

    /// One instruction to one device, and its answer; gives the alert.
    async fn ask(
        &mut self,
        id: Id,
        instruction: Instruction,
        parts: &[&[u8]],
        answer: &mut [u8],
    ) -> Result<bool, Error<U::Error>> {
        if id.is_broadcast() {
            return Err(Error::Broadcast);
        }
        self.expect_to_fit(answer.len())?;
        let sent = self.prepare(id, instruction, parts)?;
        self.send(sent).await?;
        let longest = longest_packet_length(answer.len() + 1);
        let wait = self.timing.wire_us(sent + longest).saturating_add(self.timing.latency_us);
        let mut listening = Listening::new(sent + longest);
        let accept = |status: &Status<'_>| (status.id == id).then(|| copy(status, answer));
        let result = self.listen(id, wait, &mut listening, accept).await;
        // A refusal is an answer like any other: the bus is as it should be.
        self.unsettled = !matches!(result, Ok(Ok(_) | Err(Error::Refused { .. })));
        result?
    }

    /// One instruction that nobody answers.
    async fn tell(&mut self, id: Id, instruction: Instruction, parts: &[&[u8]]) -> Result<(), Error<U::Error>> {
        let sent = self.prepare(id, instruction, parts)?;
        self.send(sent).await
    }

    fn prepare(&mut self, id: Id, instruction: Instruction, parts: &[&[u8]]) -> Result<usize, Error<U::Error>> {
        let encoder = Encoder::new(&mut self.transmit, id, instruction);
        let packet = parts.iter().fold(encoder, |encoder, part| encoder.bytes(part)).finish();
        packet.map(<[u8]>::len).map_err(Error::TooLong)
    }

    /// Whether an answer of so many parameter bytes fits whatever its bytes are.
    fn expect_to_fit(&self, parameters: usize) -> Result<(), Error<U::Error>> {
        let needed = longest_packet_length(parameters + 1);
        if needed > N {
            return Err(Error::TooLong(EncodeError::BufferTooSmall { needed, capacity: N }));
        }
        Ok(())
    }

    /// Makes the line quiet and sends the first `length` bytes prepared.
    async fn send(&mut self, length: usize) -> Result<(), Error<U::Error>> {
        self.discard().await?;
        let Master { port, delay, timing, transmit, .. } = self;
        let limit = timing.wire_us(length).saturating_add(timing.latency_us);
        let transmission = async {
            let mut rest = transmit.get(..length).unwrap_or_default();
            while !rest.is_empty() {
                match port.write(rest).await.map_err(Error::Port)? {
                    0 => return Err(Error::Closed),
                    sent => rest = rest.get(sent..).unwrap_or_default(),
                }
            }
            port.flush().await.map_err(Error::Port)
        };
        let result = match select(transmission, delay.delay_us(limit)).await {
            Either::First(result) => result,
            Either::Second(()) => Err(Error::Closed),
        };
        self.unsettled |= result.is_err();
        result
    }

    /// Throws away what has arrived; after a failure also what still arrives, until the line is silent.
    async fn discard(&mut self) -> Result<(), Error<U::Error>> {
        self.decoder.reset();
        self.inbox.start = 0;
        self.inbox.end = 0;
        let mut bytes = 0;
        let limit = 4 * N;
        loop {
            let reading = self.port.read(&mut self.inbox.bytes);
            let count = if self.unsettled {
                match select(reading, self.delay.delay_us(self.timing.latency_us)).await {
                    Either::First(count) => count,
                    Either::Second(()) => break,
                }
            } else {
                match poll_once(reading) {
                    core::task::Poll::Ready(count) => count,
                    core::task::Poll::Pending => break,
                }
            };
            // What the port could not read (noise, an overrun while nobody listened) is thrown away as well.
            let fault = match count {
                Ok(0) => return Err(Error::Closed),
                Ok(count) => {
                    bytes += count;
                    None
                }
                Err(error) => {
                    bytes += CHUNK;
                    Some(error)
                }
            };
            if bytes > limit {
                self.unsettled = true;
                return Err(fault.map_or(Error::Babble { bytes }, Error::Port));
            }
        }
        self.unsettled = false;
        Ok(())
    }

    /// Waits for a status packet that `accept` takes, until the deadline or until the bytes run out.
    async fn listen<T>(
        &mut self,
        id: Id,
        wait_us: u32,
        listening: &mut Listening<U::Error>,
        accept: impl FnMut(&Status<'_>) -> Option<T>,
    ) -> Result<T, Error<U::Error>> {
        let Master { port, delay, decoder, inbox, .. } = self;
        let hearing = hear(port, decoder, inbox, id, listening, accept);
        match select(hearing, delay.delay_us(wait_us)).await {
            Either::First(result) => result,
            Either::Second(()) => Err(match listening.fault.take() {
                Some(fault) => fault,
                None if decoder.pending() > 0 => Error::Truncated { id, received: decoder.pending() },
                None => Error::Timeout { id, waited_us: wait_us },
            }),
        }
    }
}

fn parameter_length<E>(bytes: usize) -> Result<u16, Error<E>> {
    u16::try_from(bytes).map_err(|_| Error::TooLong(EncodeError::TooLong { length: packet_length(bytes) }))
}
