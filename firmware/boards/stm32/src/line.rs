//! A serial line served by one interrupt, which alone touches the USART's registers: it fills and empties two [`Ring`]s
//! and turns the direction of a half-duplex bus round.
//!
//! # Direction
//!
//! The line is driven from before the first byte goes to the USART until the USART says that the last stop bit is out
//! (transmission complete). [`Line::service`] takes no lock and is meant to run at a priority that no critical section
//! masks: then the line is turned round one interrupt entry after the last stop bit, whatever the program does. What is
//! heard while the line is driven is one's own echo and is dropped.
//!
//! On a chip all of it runs from RAM: whatever [`Line::service`] calls is a part of it.
//!
//! Wakers need a lock; so the interrupt notes who is to be woken and has a second interrupt, of ordinary priority, call
//! [`Line::wake`].

use core::sync::atomic::{AtomicBool, AtomicU8, AtomicU32, Ordering};
use core::task::Waker;

use embassy_sync::waitqueue::AtomicWaker;

use crate::ring::Ring;

/// What a USART says of itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Status {
    /// A byte waits to be read.
    pub received: bool,
    /// The line is idle after a byte.
    pub idle: bool,
    /// A byte was lost, or came damaged.
    pub damaged: bool,
    /// The next byte can be given.
    pub ready: bool,
    /// The last stop bit is out.
    pub complete: bool,
}

/// For what the transmitter raises its interrupt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Until {
    /// For nothing.
    Never,
    /// When the next byte can be given.
    Ready,
    /// When the last stop bit is out.
    Complete,
}

/// A USART, with the line that gives its direction.
pub trait Usart {
    /// Its flags.
    fn status(&self) -> Status;
    /// The received byte.
    fn take(&self) -> u8;
    /// Clears the flags for an idle line and for damage.
    fn clear(&self);
    /// Sends a byte; it is not complete any more.
    fn give(&self, byte: u8);
    /// Chooses the transmitter's interrupt.
    fn interrupt(&self, until: Until);
    /// Takes or leaves the line.
    fn drive(&self, on: bool);
    /// Whether what is sent is heard as well.
    fn is_half_duplex(&self) -> bool;
}

/// Somebody waits for received bytes.
const RECEIVED: u8 = 1;
/// Somebody waits for room, or for the end.
const SENT: u8 = 2;

/// The queues of a line. All zeros at first.
pub struct Line<const RX: usize, const TX: usize> {
    receive: Ring<RX>,
    transmit: Ring<TX>,
    driving: AtomicBool,
    due: AtomicU8,
    /// When the last byte was heard, by the clock that is passed to [`Self::service`].
    heard: AtomicU32,
    received: AtomicWaker,
    sent: AtomicWaker,
}

impl<const RX: usize, const TX: usize> Default for Line<RX, TX> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const RX: usize, const TX: usize> Line<RX, TX> {
    /// A line at rest.
    pub const fn new() -> Self {
        Self {
            receive: Ring::new(),
            transmit: Ring::new(),
            driving: AtomicBool::new(false),
            due: AtomicU8::new(0),
            heard: AtomicU32::new(0),
            received: AtomicWaker::new(),
            sent: AtomicWaker::new(),
        }
    }

    /// The interrupt's work, begun at `now` (of any clock that wraps); returns whether [`Self::wake`] has to be called.
    #[inline(always)]
    pub fn service(&self, usart: &impl Usart, now: u32) -> bool {
        let status = usart.status();
        let driving = self.driving.load(Ordering::Relaxed);
        let mut due = 0;
        if status.received {
            let byte = usart.take();
            let echo = driving && usart.is_half_duplex();
            if !echo {
                // Without room it is lost, and whoever reads next misses it: checksums tell.
                let _ = self.receive.push(byte);
                self.heard.store(now, Ordering::Relaxed);
            }
            if self.receive.is_half_full() {
                due |= RECEIVED;
            }
        }
        if status.idle {
            due |= RECEIVED;
        }
        if status.idle || status.damaged {
            usart.clear();
        }
        if status.ready {
            due |= self.send(usart, status, driving);
        }
        if due != 0 {
            self.due.fetch_or(due, Ordering::Release);
        }
        due != 0
    }

    #[inline(always)]
    fn send(&self, usart: &impl Usart, status: Status, driving: bool) -> u8 {
        if let Some(byte) = self.transmit.pop() {
            if !driving {
                self.driving.store(true, Ordering::Relaxed);
                usart.drive(true);
            }
            usart.give(byte);
            usart.interrupt(Until::Ready);
            // Room again, told once per half a queue.
            return if self.transmit.len() == TX / 2 { SENT } else { 0 };
        }
        if !driving {
            usart.interrupt(Until::Never);
            return 0;
        }
        if !status.complete {
            usart.interrupt(Until::Complete);
            return 0;
        }
        usart.drive(false);
        self.driving.store(false, Ordering::Relaxed);
        usart.interrupt(Until::Never);
        SENT
    }

    /// Wakes who has waited.
    pub fn wake(&self) {
        let due = self.due.swap(0, Ordering::Acquire);
        if due & RECEIVED != 0 {
            self.received.wake();
        }
        if due & SENT != 0 {
            self.sent.wake();
        }
    }

    /// Moves received bytes; returns how many.
    pub fn take(&self, buffer: &mut [u8]) -> usize {
        let mut taken = 0;
        for (slot, byte) in buffer.iter_mut().zip(core::iter::from_fn(|| self.receive.pop())) {
            *slot = byte;
            taken += 1;
        }
        taken
    }

    /// Queues what fits; returns how much. The interrupt has to be raised then.
    pub fn give(&self, bytes: &[u8]) -> usize {
        bytes.iter().take_while(|byte| self.transmit.push(**byte)).count()
    }

    /// Whether everything is out and the line is left.
    pub fn is_done(&self) -> bool {
        self.transmit.is_empty() && !self.driving.load(Ordering::Relaxed)
    }

    /// When the last byte came that was not an echo: the `now` of the interrupt that it raised. 0 if none came yet.
    pub fn heard(&self) -> u32 {
        self.heard.load(Ordering::Relaxed)
    }

    pub(crate) fn wait_received(&self, waker: &Waker) {
        self.received.register(waker);
    }

    pub(crate) fn wait_sent(&self, waker: &Waker) {
        self.sent.register(waker);
    }
}
