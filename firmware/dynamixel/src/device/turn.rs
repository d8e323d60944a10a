//! A device's turn in a read of several devices.

use crate::fast::{FastAnswer, Step};
use crate::packet::{Id, longest_packet_length};
use crate::request::{Entry, Request};
use crate::timing::Timing;

/// A read in which others answer before this device.
#[derive(Clone, Debug)]
pub(super) struct Turn<const N: usize> {
    request: Request<N>,
    /// This device's place in the list; nothing if it does not wait.
    waiting: Option<Waiting>,
    fast: FastAnswer,
}

#[derive(Clone, Copy, Debug)]
struct Waiting {
    mine: usize,
    /// Devices before this one that have answered, or need not be waited for any more.
    heard: usize,
    /// When this device answers although one before it is silent, µs.
    due_us: u64,
}

/// What a device of a list has to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Call {
    /// Nothing yet, or nothing at all.
    Wait,
    /// Answer with a packet of its own.
    Answer(Entry),
    /// Send its block.
    Block(Entry),
}

impl<const N: usize> Turn<N> {
    pub(super) const fn new() -> Self {
        Self { request: Request::NONE, waiting: None, fast: FastAnswer::new(0) }
    }

    /// A new instruction ends every read that is still waiting.
    pub(super) fn end(&mut self) {
        self.waiting = None;
    }

    /// How the block is to be written, after [`Call::Block`].
    pub(super) fn fast(&self) -> &FastAnswer {
        &self.fast
    }

    /// A read of several devices has come.
    pub(super) fn begin(&mut self, request: &crate::packet::Packet<'_>, me: Id, now_us: u64, timing: &Timing) -> Call {
        self.waiting = None;
        self.request.keep(request);
        let Some(mine) = self.request.entries(0).position(|entry| entry.id == me.get()) else {
            return Call::Wait;
        };
        if self.request.is_fast() {
            let Some(length) = self.request.fast_length() else {
                return Call::Wait;
            };
            self.fast = FastAnswer::new(length);
            if mine > 0 {
                // A packet with a hole is none: whoever is silent silences all behind it.
                self.waiting = Some(Waiting { mine, heard: 0, due_us: u64::MAX });
                return Call::Wait;
            }
            return self.request.entry(0).map_or(Call::Wait, Call::Block);
        }
        self.wait(mine, 0, now_us, timing)
    }

    /// Waits for the devices from `heard` on.
    fn wait(&mut self, mine: usize, heard: usize, now_us: u64, timing: &Timing) -> Call {
        // Numbers that no device can have are not waited for.
        let before =
            |place: usize| place < mine && self.request.entry(place).is_some_and(|it| Id::new(it.id).is_none());
        let heard = (heard..).find(|&place| !before(place)).unwrap_or(mine);
        if heard >= mine {
            self.waiting = None;
            return self.request.entry(mine).map_or(Call::Wait, Call::Answer);
        }
        let patience = |entry: Entry| {
            let longest = longest_packet_length(usize::from(entry.length) + 1);
            u64::from(timing.wire_us(longest)) + u64::from(timing.latency_us)
        };
        let total = self.request.entries(heard).take(mine - heard).map(patience).fold(now_us, u64::saturating_add);
        self.waiting = Some(Waiting { mine, heard, due_us: total });
        Call::Wait
    }

    /// Another device has answered with a packet of its own.
    pub(super) fn heard(&mut self, id: Id, now_us: u64, timing: &Timing) -> Call {
        let Some(Waiting { mine, heard, .. }) = self.waiting.filter(|_| !self.request.is_fast()) else {
            return Call::Wait;
        };
        let before = self.request.entries(heard).take(mine - heard).position(|entry| entry.id == id.get());
        before.map_or(Call::Wait, |place| self.wait(mine, heard + place + 1, now_us, timing))
    }

    /// Each byte may end the block of a fast answer before the device's own.
    pub(super) fn follows(&self) -> bool {
        self.waiting.is_some() && self.request.is_fast()
    }

    /// A byte of what may be the answer to a fast read.
    pub(super) fn follow(&mut self, byte: u8) -> Call {
        let Some(Waiting { mine, .. }) = self.waiting.filter(|_| self.request.is_fast()) else {
            return Call::Wait;
        };
        let request = &self.request;
        let step = self.fast.push(byte, |place| request.entry(place), &mut []);
        if step == Step::Broken {
            self.waiting = None;
        } else if self.fast.awaits() == Some(mine) {
            self.waiting = None;
            return self.request.entry(mine).map_or(Call::Wait, Call::Block);
        }
        Call::Wait
    }

    /// When those before count as silent, µs.
    pub(super) fn deadline(&self) -> Option<u64> {
        self.waiting.map(|waiting| waiting.due_us).filter(|&due_us| due_us < u64::MAX)
    }

    /// Those before may be silent for good.
    pub(super) fn poll(&mut self, now_us: u64) -> Call {
        match self.waiting {
            Some(Waiting { mine, due_us, .. }) if now_us >= due_us => {
                self.waiting = None;
                self.request.entry(mine).map_or(Call::Wait, Call::Answer)
            }
            _ => Call::Wait,
        }
    }
}
