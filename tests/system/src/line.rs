//! Lines between the bench's parts: what one port writes, another reads, in one thread.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::convert::Infallible;
use std::future::poll_fn;
use std::rc::Rc;
use std::task::{Poll, Waker};

use embedded_io_async::{ErrorType, Read, Write};
use gripper::BusPort;

/// Bytes on their way.
#[derive(Default)]
pub struct Line {
    /// What nobody has read yet.
    pub bytes: VecDeque<u8>,
    /// Who waits for bytes.
    pub reader: Option<Waker>,
    /// Who waits for room.
    pub writer: Option<Waker>,
}

/// A line that both of its ends hold.
pub type Shelf = Rc<RefCell<Line>>;

/// A port: reads from one line, writes to another.
pub struct Port {
    /// The line read from.
    pub from: Shelf,
    /// The line written to.
    pub to: Shelf,
    /// Bytes that the line written to holds.
    pub room: usize,
}

impl ErrorType for Port {
    type Error = Infallible;
}

impl Read for Port {
    async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Infallible> {
        poll_fn(|context| {
            let mut line = self.from.borrow_mut();
            if line.bytes.is_empty() {
                line.reader = Some(context.waker().clone());
                return Poll::Pending;
            }
            let count = buffer.len().min(line.bytes.len());
            for (place, byte) in buffer.iter_mut().zip(line.bytes.drain(..count)) {
                *place = byte;
            }
            Poll::Ready(Ok(count))
        })
        .await
    }
}

impl Write for Port {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        poll_fn(|context| {
            let mut line = self.to.borrow_mut();
            let count = bytes.len().min(self.room.saturating_sub(line.bytes.len()));
            if count == 0 {
                line.writer = Some(context.waker().clone());
                return Poll::Pending;
            }
            line.bytes.extend(&bytes[..count]);
            Poll::Ready(Ok(count))
        })
        .await
    }

    async fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

impl BusPort for Port {
    fn set_baud(&mut self, baud: u32) -> u32 {
        baud
    }
}

/// Puts bytes on a line and wakes who waits for them.
pub fn give(line: &Shelf, bytes: &[u8]) {
    let mut line = line.borrow_mut();
    line.bytes.extend(bytes);
    line.reader.take().into_iter().for_each(Waker::wake);
}
