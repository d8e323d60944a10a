//! Waiting for an answer among whatever else is on the line.

use embedded_io_async::Read;

use super::Error;
use crate::decode::Decoder;
use crate::packet::{Id, Packet, Status};

/// Bytes taken from the port at once.
pub(super) const CHUNK: usize = 32;

/// Bytes received and not yet decoded.
#[derive(Debug)]
pub(super) struct Inbox {
    pub(super) bytes: [u8; CHUNK],
    pub(super) start: usize,
    pub(super) end: usize,
}

/// What a transaction collects while it waits.
pub(super) struct Listening<E> {
    /// What went wrong first, should nothing better come.
    pub(super) fault: Option<Error<E>>,
    /// Instructions of another master.
    pub(super) foreign: u32,
    own: Own,
    /// Bytes that may still arrive.
    budget: usize,
    received: usize,
}

/// First bytes of the own instruction, which the wiring may echo: others are another master's.
#[derive(Clone, Copy, Debug)]
pub(super) struct Own {
    id: u8,
    code: u8,
}

impl Own {
    /// Nothing was sent yet.
    pub(super) const NONE: Self = Self { id: 0, code: 0 };

    /// Of the packet that was last sent.
    pub(super) fn of(transmit: &[u8]) -> Self {
        let at = |place: usize| transmit.get(place).copied().unwrap_or_default();
        Self { id: at(4), code: at(7) }
    }

    /// Whether a packet is an instruction that somebody else has sent.
    pub(super) fn is_foreign(self, packet: &Packet<'_>) -> bool {
        packet.status().is_none() && (packet.id.get(), packet.code) != (self.id, self.code)
    }
}

/// Reads and decodes until `accept` takes a status packet, or more has come than any answer explains.
pub(super) async fn hear<U: Read, T, const N: usize>(
    port: &mut U,
    decoder: &mut Decoder<N>,
    inbox: &mut Inbox,
    id: Id,
    listening: &mut Listening<U::Error>,
    mut accept: impl FnMut(&Status<'_>) -> Option<T>,
) -> Result<T, Error<U::Error>> {
    loop {
        let mut bytes = inbox.bytes.get(inbox.start..inbox.end).unwrap_or_default();
        while let Some(event) = decoder.feed(&mut bytes) {
            if event.as_ref().is_ok_and(|packet| listening.own.is_foreign(packet)) {
                listening.foreign = listening.foreign.saturating_add(1);
            }
            let fault = match event.map(|packet| packet.status()) {
                Ok(Some(status)) => {
                    if let Some(answer) = accept(&status) {
                        inbox.start = inbox.end - bytes.len();
                        return Ok(answer);
                    }
                    Error::WrongId { expected: id, received: status.id }
                }
                // An instruction: the wiring's echo, or another master's.
                Ok(None) => continue,
                Err(error) => Error::Damaged(error),
            };
            listening.fault.get_or_insert(fault);
        }
        inbox.start = 0;
        inbox.end = 0;
        if listening.received > listening.budget {
            return Err(match listening.fault.take() {
                Some(Error::Port(error)) => Error::Port(error),
                _ => Error::Babble { bytes: listening.received },
            });
        }
        match port.read(&mut inbox.bytes).await {
            Ok(0) => return Err(Error::Closed),
            Ok(count) => {
                inbox.end = count.min(CHUNK);
                listening.received += inbox.end;
            }
            // Noise before an answer must not lose it; the budget bounds a port that keeps failing.
            Err(error) => {
                listening.fault.get_or_insert(Error::Port(error));
                listening.received += CHUNK;
            }
        }
    }
}

impl<E> Listening<E> {
    /// Twice what echo and answers take, and one chunk: room for noise, and an end to it.
    pub(super) fn new(bytes: usize, own: Own) -> Self {
        Listening { fault: None, foreign: 0, own, budget: bytes.saturating_mul(2).saturating_add(CHUNK), received: 0 }
    }
}

/// The answer's parameters and its alert, if it is one and has this many.
pub(super) fn checked<'s, E>(status: &Status<'s>, length: usize) -> Result<(&'s [u8], bool), Error<E>> {
    let Status { id, alert, error, parameters } = *status;
    if let Some(error) = error {
        return Err(Error::Refused { id, error, alert });
    }
    if parameters.len() != length {
        return Err(Error::Length { id, expected: length, received: parameters.len() });
    }
    Ok((parameters, alert))
}

/// As [`checked`]; the parameters go to `into`.
pub(super) fn copy<E>(status: &Status<'_>, into: &mut [u8]) -> Result<bool, Error<E>> {
    let (parameters, alert) = checked(status, into.len())?;
    into.copy_from_slice(parameters);
    Ok(alert)
}
