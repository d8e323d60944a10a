//! A [`Line`] as embedded-io-async reads and writes it.

use core::convert::Infallible;
use core::future::poll_fn;
use core::task::Poll;

use embedded_io_async::{ErrorType, Read, Write};

use crate::line::Line;

/// The sending half of a line.
pub struct Sender<const RX: usize, const TX: usize> {
    line: &'static Line<RX, TX>,
    /// Raises the line's interrupt.
    raise: fn(),
}

/// The receiving half of a line.
pub struct Receiver<const RX: usize, const TX: usize> {
    line: &'static Line<RX, TX>,
}

/// Both halves; `raise` raises the line's interrupt.
pub fn halves<const RX: usize, const TX: usize>(
    line: &'static Line<RX, TX>,
    raise: fn(),
) -> (Sender<RX, TX>, Receiver<RX, TX>) {
    (Sender { line, raise }, Receiver { line })
}

impl<const RX: usize, const TX: usize> ErrorType for Sender<RX, TX> {
    type Error = Infallible;
}

impl<const RX: usize, const TX: usize> ErrorType for Receiver<RX, TX> {
    type Error = Infallible;
}

impl<const RX: usize, const TX: usize> Read for Receiver<RX, TX> {
    /// Waits for a pause on the line (one byte's time), or for half a queue of bytes.
    async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Infallible> {
        if buffer.is_empty() {
            return Ok(0);
        }
        poll_fn(|context| {
            self.line.wait_received(context.waker());
            match self.line.take(buffer) {
                0 => Poll::Pending,
                taken => Poll::Ready(Ok(taken)),
            }
        })
        .await
    }
}

impl<const RX: usize, const TX: usize> Write for Sender<RX, TX> {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        if bytes.is_empty() {
            return Ok(0);
        }
        poll_fn(|context| {
            self.line.wait_sent(context.waker());
            match self.line.give(bytes) {
                0 => Poll::Pending,
                given => {
                    (self.raise)();
                    Poll::Ready(Ok(given))
                }
            }
        })
        .await
    }

    /// Waits until the last stop bit is out and the line is left.
    async fn flush(&mut self) -> Result<(), Infallible> {
        poll_fn(|context| {
            self.line.wait_sent(context.waker());
            if self.line.is_done() { Poll::Ready(Ok(())) } else { Poll::Pending }
        })
        .await
    }
}
