//! One question to several devices, and their answers: one packet each, or one that all of them write.

use embassy_futures::select::{Either, select};
use embedded_hal_async::delay::DelayNs;
use embedded_io_async::{Read, Write};

use super::listen::{CHUNK, Listening, checked};
use super::{Error, Master};
use crate::encode::EncodeError;
use crate::fast::{FRONT_LENGTH, FastAnswer, Step};
use crate::packet::{ALERT, BLOCK_LENGTH, Id, Status, StatusError, fast_length, longest_packet_length};
use crate::request::Entry;

/// A device's part in a read of several.
pub(super) trait Part<E> {
    /// Who is asked, for what.
    fn entry(&self) -> (Id, Entry);
    /// Forgets an earlier result.
    fn begin(&mut self);
    /// Whether there is no result yet.
    fn waits(&self) -> bool;
    /// Whether there is a good one.
    fn is_good(&self) -> bool;
    /// Takes the result: as many bytes as were asked for, and the alert.
    fn settle(&mut self, result: Result<(&[u8], bool), Error<E>>);
}

impl<U, D, const N: usize> Master<U, D, N>
where
    U: Read + Write,
    D: DelayNs,
{
    /// Sends the first `sent` bytes prepared and waits for an answer of each device, in their order.
    pub(super) async fn hear_each<P: Part<U::Error>>(
        &mut self,
        sent: usize,
        parts: &mut [P],
    ) -> Result<(), Error<U::Error>> {
        let answer = |part: &P| longest_packet_length(usize::from(part.entry().1.length) + 1);
        for part in &*parts {
            self.expect_to_fit(usize::from(part.entry().1.length))?;
        }
        self.send(sent).await?;
        let all = parts.iter().map(answer).fold(sent, usize::saturating_add);
        let mut listening = Listening::new(all, self.sent);
        // The question's time counts towards the first answer only.
        let mut asked = sent;
        while let Some(part) = parts.iter().find(|part| part.waits()) {
            let waiting = part.entry().0;
            let wait = self.timing.wire_us(asked + answer(part)).saturating_add(self.timing.latency_us);
            asked = 0;
            let accept = |status: &Status<'_>| {
                let part = parts.iter_mut().find(|part| part.waits() && part.entry().0 == status.id)?;
                let length = usize::from(part.entry().1.length);
                part.settle(checked(status, length));
                Some(())
            };
            if let Err(error) = self.listen(waiting, wait, &mut listening, accept).await {
                give_up(parts, error, wait);
                break;
            }
        }
        self.foreign = self.foreign.saturating_add(listening.foreign);
        self.unsettled |= parts.iter().any(|part| !part.is_good());
        Ok(())
    }

    /// Sends the first `sent` bytes prepared and follows the one packet with which all devices answer.
    pub(super) async fn hear_together<P: Part<U::Error>>(
        &mut self,
        sent: usize,
        parts: &mut [P],
    ) -> Result<(), Error<U::Error>> {
        let lengths = || parts.iter().map(|part| part.entry().1.length);
        let total = lengths().fold(FRONT_LENGTH, |sum, length| sum + usize::from(length) + BLOCK_LENGTH);
        let length = fast_length(lengths()).ok_or(Error::TooLong(EncodeError::TooLong { length: total }))?;
        let longest = lengths().max().map_or(0, usize::from);
        if longest > N {
            return Err(Error::TooLong(EncodeError::BufferTooSmall { needed: longest, capacity: N }));
        }
        self.send(sent).await?;

        let wait = self.timing.wire_us(sent + total).saturating_add(self.timing.latency_us);
        let mut answer = FastAnswer::new(length);
        // What was sent is not needed any more: the blocks' data take its place.
        let following = follow(&mut self.port, &mut answer, &mut self.transmit, parts, 2 * (sent + total) + CHUNK);
        let failed = match select(following, self.delay.delay_us(wait)).await {
            Either::First(result) => result.err(),
            Either::Second(()) => {
                let silent = parts.iter().find(|part| part.waits());
                silent.map(|part| Error::Timeout { id: part.entry().0, waited_us: wait })
            }
        };
        if let Some(error) = failed {
            give_up(parts, error, wait);
        }
        self.unsettled = parts.iter().any(|part| !part.is_good());
        Ok(())
    }
}

/// Whoever has not answered: the first for this reason, the others because they were not heard either.
fn give_up<E, P: Part<E>>(parts: &mut [P], error: Error<E>, waited_us: u32) {
    let mut error = Some(error);
    for part in parts.iter_mut().filter(|part| part.waits()) {
        let silence = Error::Timeout { id: part.entry().0, waited_us };
        part.settle(Err(error.take().unwrap_or(silence)));
    }
}

/// Reads the answer to a fast read until it is complete, or until more than `budget` bytes have come.
async fn follow<U: Read, P: Part<U::Error>>(
    port: &mut U,
    answer: &mut FastAnswer,
    data: &mut [u8],
    parts: &mut [P],
    budget: usize,
) -> Result<(), Error<U::Error>> {
    let mut received = 0;
    let mut chunk = [0; CHUNK];
    while parts.last().is_some_and(|part| part.waits()) {
        let count = port.read(&mut chunk).await.map_err(Error::Port)?;
        if count == 0 {
            return Err(Error::Closed);
        }
        received += count;
        for &byte in chunk.get(..count).unwrap_or_default() {
            match answer.push(byte, |place| parts.get(place).map(|part| part.entry().1), data) {
                Step::More => {}
                Step::Block { place, error, length } => {
                    if let Some(part) = parts.get_mut(place) {
                        let (id, alert) = (part.entry().0, error & ALERT != 0);
                        part.settle(match StatusError::from_code(error) {
                            Some(error) => Err(Error::Refused { id, error, alert }),
                            None => Ok((data.get(..length).unwrap_or_default(), alert)),
                        });
                    }
                }
                Step::Broken => {
                    let silent = parts.iter().find(|part| part.waits());
                    return silent.map_or(Ok(()), |part| Err(Error::Block { id: part.entry().0 }));
                }
            }
        }
        if received > budget {
            return Err(Error::Babble { bytes: received });
        }
    }
    Ok(())
}
