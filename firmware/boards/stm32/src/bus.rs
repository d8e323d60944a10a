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
    usart: Running,
}

impl<const RX: usize, const TX: usize> Bus<RX, TX> {
    /// The bus on this line, whose USART runs.
    pub fn new(line: &'static Line<RX, TX>, usart: Running) -> Self {
        let (sender, receiver) = halves(line, usart.raise());
        Self { sender, receiver, usart }
    }
}

impl<const RX: usize, const TX: usize> BusPort for Bus<RX, TX> {
    fn set_baud(&mut self, baud: u32) -> u32 {
        self.usart.set_baud(baud)
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
