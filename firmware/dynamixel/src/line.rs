//! Bytes as they are heard on a bus: packet by packet, and what a pause means.

use crate::decode::{DecodeError, Decoder};
use crate::packet::Packet;

/// A decoder that gives up an incomplete packet when the line has been silent.
#[derive(Clone, Debug)]
pub(crate) struct Line<const N: usize> {
    decoder: Decoder<N>,
    /// When something was last heard, µs.
    heard_us: u64,
}

impl<const N: usize> Line<N> {
    pub(crate) const fn new() -> Self {
        Self { decoder: Decoder::new(), heard_us: 0 }
    }

    /// Time passes; what is heard from here on comes at this time.
    pub(crate) fn at(&mut self, now_us: u64, pause_us: u32) {
        if self.deadline(pause_us).is_some_and(|deadline| now_us >= deadline) {
            self.decoder.pause();
        }
    }

    /// When the packet that is incomplete will be given up, µs.
    pub(crate) fn deadline(&self, pause_us: u32) -> Option<u64> {
        (self.decoder.pending() > 0).then(|| self.heard_us.saturating_add(u64::from(pause_us)))
    }

    /// What needs no further byte. To be called until there is nothing, before the next [`Line::byte`].
    pub(crate) fn settle(&mut self) -> Option<Spoken<'_>> {
        self.decoder.next(&mut &[][..]).map(Spoken::from)
    }

    /// Takes bytes until they say something; nothing means that all are taken.
    pub(crate) fn take(&mut self, now_us: u64, input: &mut &[u8]) -> Option<Spoken<'_>> {
        if !input.is_empty() {
            self.heard_us = now_us;
        }
        self.decoder.next(input).map(Spoken::from)
    }

    /// Takes a byte.
    pub(crate) fn byte(&mut self, now_us: u64, byte: u8) -> Option<Spoken<'_>> {
        self.heard_us = now_us;
        self.decoder.next(&mut &[byte][..]).map(Spoken::from)
    }

    /// Bytes so far that belonged to no packet; wraps.
    pub(crate) fn skipped(&self) -> u32 {
        self.decoder.skipped()
    }

    pub(crate) fn reset(&mut self) {
        self.decoder.reset();
    }
}

/// A packet, or what is left of one.
pub(crate) struct Spoken<'a> {
    pub(crate) packet: Result<Packet<'a>, DecodeError>,
    /// [`Line::skipped`] at its end.
    pub(crate) skipped: u32,
}

impl<'a> From<(Result<Packet<'a>, DecodeError>, u32)> for Spoken<'a> {
    fn from((packet, skipped): (Result<Packet<'a>, DecodeError>, u32)) -> Self {
        Self { packet, skipped }
    }
}
