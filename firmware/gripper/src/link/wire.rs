//! postcard-rpc's wires: answers go to the writing task's queue, requests come out of a stream of bytes.

use core::fmt::Arguments;
use core::future::poll_fn;

use embedded_io_async::Read;
use messages::frame::{self, Decoder, FrameError};
use postcard_rpc::Topic;
use postcard_rpc::header::{VarHeader, VarKey, VarKeyKind, VarSeq};
use postcard_rpc::server::{WireRx, WireRxErrorKind, WireTx, WireTxErrorKind};
use postcard_rpc::standard_icd::LoggingTopic;
use serde::Serialize;

use crate::shared::{Frame, Shared};

/// Frames a message.
// Two buffers of a frame's size: they are on the stack in here only, not once per kind of message in every task that sends some.
#[inline(never)]
pub(super) fn framed<T: Serialize + ?Sized>(header: &VarHeader, body: &T) -> Result<Frame, FrameError> {
    let mut message = [0; frame::MESSAGE];
    framed_raw(frame::message(header, body, &mut message)?)
}

#[inline(never)]
fn framed_raw(message: &[u8]) -> Result<Frame, FrameError> {
    let mut frame = Frame::new();
    frame.resize_default(frame::FRAME).map_err(|_| FrameError::TooLong)?;
    let used = frame::encode(message, &mut frame)?.len();
    frame.truncate(used);
    Ok(frame)
}

/// Answers to the host.
#[derive(Clone, Copy)]
pub struct Answers(pub(super) &'static Shared);

/// What became of an answer.
enum Queued {
    Yes,
    /// The queue is full.
    NotYet,
    /// It is too long for a frame.
    Never,
}

impl Answers {
    /// Queues the frame that `make` makes. It is made when there is room for it, and no future holds it.
    async fn queue(&self, make: impl Fn() -> Result<Frame, FrameError>) -> Result<(), WireTxErrorKind> {
        loop {
            poll_fn(|context| self.0.answers.poll_ready_to_send(context)).await;
            match self.offer(&make) {
                Queued::Yes => return Ok(()),
                Queued::NotYet => {}
                Queued::Never => {
                    self.0.add(|counters| &mut counters.link_oversize);
                    return Err(WireTxErrorKind::Other);
                }
            }
        }
    }

    // As [`framed`]: the frame stays out of the tasks' own.
    #[inline(never)]
    fn offer(&self, make: &impl Fn() -> Result<Frame, FrameError>) -> Queued {
        let Ok(frame) = make() else { return Queued::Never };
        if self.0.answers.try_send(frame).is_ok() { Queued::Yes } else { Queued::NotYet }
    }
}

impl WireTx for Answers {
    type Error = WireTxErrorKind;

    async fn send<T: Serialize + ?Sized>(&self, header: VarHeader, message: &T) -> Result<(), WireTxErrorKind> {
        self.queue(|| framed(&header, message)).await
    }

    async fn send_raw(&self, message: &[u8]) -> Result<(), WireTxErrorKind> {
        self.queue(|| framed_raw(message)).await
    }

    async fn send_log_str(&self, kind: VarKeyKind, words: &str) -> Result<(), WireTxErrorKind> {
        let mut key = VarKey::Key8(LoggingTopic::TOPIC_KEY);
        key.shrink_to(kind);
        self.queue(|| framed(&VarHeader { key, seq_no: VarSeq::Seq1(0) }, words)).await
    }

    async fn send_log_fmt<'a>(&self, kind: VarKeyKind, words: Arguments<'a>) -> Result<(), WireTxErrorKind> {
        self.send_log_str(kind, &messages::Refusal::text(&words)).await
    }
}

/// Requests of the host.
pub(super) struct Requests<R> {
    shared: &'static Shared,
    port: R,
    decoder: Decoder,
    chunk: [u8; 64],
    start: usize,
    end: usize,
}

impl<R: Read> Requests<R> {
    pub(super) fn new(shared: &'static Shared, port: R) -> Self {
        Self { shared, port, decoder: Decoder::new(), chunk: [0; 64], start: 0, end: 0 }
    }
}

impl<R: Read> WireRx for &mut Requests<R> {
    type Error = WireRxErrorKind;

    async fn receive<'a>(&mut self, buffer: &'a mut [u8]) -> Result<&'a mut [u8], WireRxErrorKind> {
        loop {
            let mut bytes = self.chunk.get(self.start..self.end).unwrap_or_default();
            let event = self.decoder.feed(&mut bytes);
            self.start = self.end - bytes.len();
            match event {
                Some(Ok(message)) => {
                    self.shared.add(|counters| &mut counters.link_frames);
                    self.shared.heard_host();
                    let room = buffer.get_mut(..message.len()).ok_or(WireRxErrorKind::ReceivedMessageTooLarge)?;
                    room.copy_from_slice(message);
                    return Ok(room);
                }
                Some(Err(error)) => {
                    log!(debug, "link: {}", error);
                    let _ = error;
                    self.shared.add(|counters| &mut counters.link_damaged);
                }
                None => {
                    self.start = 0;
                    self.end = 0;
                    match self.port.read(&mut self.chunk).await {
                        Ok(0) => return Err(WireRxErrorKind::ConnectionClosed),
                        Ok(count) => self.end = count.min(self.chunk.len()),
                        Err(_) => return Err(WireRxErrorKind::ConnectionClosed),
                    }
                }
            }
        }
    }
}
