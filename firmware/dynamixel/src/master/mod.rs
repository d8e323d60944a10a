//! The asking side of the bus: one instruction at a time, a deadline for every answer.

mod bulk;
mod discover;
mod error;
mod listen;
mod service;
mod several;
mod sync;
mod values;

pub use bulk::{BulkAnswer, BulkWrite};
pub use discover::Found;
pub use error::Error;
pub use sync::SyncAnswer;

use embassy_futures::poll_once;
use embassy_futures::select::{Either, select};
use embedded_hal_async::delay::DelayNs;
use embedded_io_async::{Read, Write};

use listen::{CHUNK, Inbox, Listening, Own, copy, hear};

use crate::decode::Decoder;
use crate::encode::{EncodeError, Encoder};
use crate::packet::{Id, Instruction, Status, longest_packet_length, packet_length};
use crate::timing::Timing;

/// What a device answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Answer<T> {
    /// What was asked for.
    pub value: T,
    /// A hardware error is present in the device; [`crate::xm430::HARDWARE_ERROR_STATUS`] says which.
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

/// The master of a bus. `N` bounds instructions and answers in bytes, stuffing included.
///
/// - `U` is the port; its future may be dropped while it waits for bytes. Own bytes that the wiring echoes are ignored.
/// - `D` measures the deadlines: `embassy_time::Delay` on a target.
///
/// Before it asks, the master discards what has arrived meanwhile; after a failed transaction it also waits for
/// `latency_us` of silence, so that a late answer is not taken for the next one. (The protocol has no sequence numbers:
/// an answer still later than that cannot be distinguished from the right one.)
#[derive(Debug)]
pub struct Master<U, D, const N: usize = 128> {
    port: U,
    delay: D,
    timing: Timing,
    decoder: Decoder<N>,
    transmit: [u8; N],
    inbox: Inbox,
    unsettled: bool,
    /// What was last sent.
    sent: Own,
    /// Instructions of another master, since they were last asked for.
    foreign: u32,
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
            sent: Own::NONE,
            foreign: 0,
        }
    }

    /// How many instructions of another master were heard since this was last called. (One that equals the own one that was last sent, as
    /// far as its first bytes go, is taken for the wiring's echo.)
    pub fn take_foreign(&mut self) -> u32 {
        core::mem::take(&mut self.foreign)
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

    /// What measures the deadlines.
    pub(crate) fn delay_mut(&mut self) -> &mut D {
        &mut self.delay
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
        self.order(id, Instruction::Write, &[&address.to_le_bytes(), bytes]).await
    }

    /// An instruction without an answer's data: not waited for if nobody answers it.
    async fn order(
        &mut self,
        id: Id,
        instruction: Instruction,
        parts: &[&[u8]],
    ) -> Result<Answer<()>, Error<U::Error>> {
        if id.is_broadcast() || !self.timing.status_return.answers(instruction.code()) {
            self.tell(id, instruction, parts).await?;
            return Ok(Answer { value: (), alert: false });
        }
        let alert = self.ask(id, instruction, parts, &mut []).await?;
        Ok(Answer { value: (), alert })
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
        let mut listening = Listening::new(sent + longest, self.sent);
        let accept = |status: &Status<'_>| (status.id == id).then(|| copy(status, answer));
        let result = self.listen(id, wait, &mut listening, accept).await;
        self.foreign = self.foreign.saturating_add(listening.foreign);
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
        self.sent = Own::of(&self.transmit);
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
        // Behind the last answer, in the same chunk.
        let left = core::mem::take(&mut self.inbox.start)..core::mem::take(&mut self.inbox.end);
        self.overhear(left);
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
                    self.overhear(0..count);
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
        self.decoder.reset();
        self.unsettled = false;
        Ok(())
    }

    /// Counts the instructions of others in bytes of the inbox that nobody has asked for.
    fn overhear(&mut self, range: core::ops::Range<usize>) {
        let Self { inbox, decoder, sent, foreign, .. } = self;
        let mut bytes = inbox.bytes.get(range).unwrap_or_default();
        while let Some(event) = decoder.feed(&mut bytes) {
            *foreign = foreign.saturating_add(u32::from(event.is_ok_and(|packet| sent.is_foreign(&packet))));
        }
    }

    /// Waits for a status packet that `accept` takes, until the deadline or until the bytes run out.
    async fn listen<T>(
        &mut self,
        id: Id,
        wait_us: u32,
        listening: &mut Listening<U::Error>,
        mut accept: impl FnMut(&Status<'_>) -> Option<T>,
    ) -> Result<T, Error<U::Error>> {
        let Master { port, delay, decoder, inbox, .. } = self;
        let hearing = hear(port, decoder, inbox, id, listening, &mut accept);
        match select(hearing, delay.delay_us(wait_us)).await {
            Either::First(result) => result,
            Either::Second(()) => {
                let received = decoder.pending();
                // Noise that began like a packet may have hidden the answer.
                decoder.pause();
                while let Some(event) = decoder.feed(&mut &[][..]) {
                    if let Some(answer) = event.ok().and_then(|packet| packet.status()).and_then(|it| accept(&it)) {
                        return Ok(answer);
                    }
                }
                Err(match listening.fault.take() {
                    Some(fault) => fault,
                    None if received > 0 => Error::Truncated { id, received },
                    None => Error::Timeout { id, waited_us: wait_us },
                })
            }
        }
    }
}

fn parameter_length<E>(bytes: usize) -> Result<u16, Error<E>> {
    u16::try_from(bytes).map_err(|_| Error::TooLong(EncodeError::TooLong { length: packet_length(bytes) }))
}
