//! The Dynamixel bus: both halves of a half-duplex line, and its rate.

use core::convert::Infallible;

use embedded_io_async::{ErrorType, Read, Write};
use gripper::BusPort;

use crate::line::Line;
use crate::port::{Receiver, Sender, halves};
use crate::usart::Running;

/// The Dynamixel bus.
pub struct Bus<const RX: usize, const TX: usize> {
    sender: Sender<RX, TX>,
    receiver: Receiver<RX, TX>,
    line: &'static Line<RX, TX>,
    usart: Running,
}

impl<const RX: usize, const TX: usize> Bus<RX, TX> {
    /// The bus on this line, whose USART runs.
    pub fn new(line: &'static Line<RX, TX>, usart: Running) -> Self {
        let (sender, receiver) = halves(line, usart.raise());
        Self { sender, receiver, line, usart }
    }
}

impl<const RX: usize, const TX: usize> BusPort for Bus<RX, TX> {
    fn set_baud(&mut self, baud: u32) -> u32 {
        self.usart.set_baud(baud)
    }

    /// The processor's cycle counter at the entry of the interrupt that took the last byte; echoes do not count.
    ///
    /// Every byte raises it (no FIFO, no DMA), at the highest priority. The USART does so at the middle of the stop bit, so
    /// that this is half a bit before the byte's end (0.5 µs at 1 Mbaud, 8.7 µs at 57,600), and the entry of the interrupt
    /// after that, well below a microsecond (see the crate's README). The pause of a byte's time after which the line counts
    /// as idle and the program hears of the answer comes behind it: it is a part of the latency, not taken off.
    fn heard_ticks(&self) -> Option<u32> {
        Some(self.line.heard())
    }
}

impl<const RX: usize, const TX: usize> ErrorType for Bus<RX, TX> {
    type Error = Infallible;
}

impl<const RX: usize, const TX: usize> Read for Bus<RX, TX> {
    async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Infallible> {
        self.receiver.read(buffer).await
    }
}

impl<const RX: usize, const TX: usize> Write for Bus<RX, TX> {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        self.sender.write(bytes).await
    }

    async fn flush(&mut self) -> Result<(), Infallible> {
        self.sender.flush().await
    }
}
