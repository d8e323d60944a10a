//! A port as the master of a bus wants it, and the one thread that drives it.

use std::cell::{Cell, RefCell};
use std::future::{Future, poll_fn};
use std::io;
use std::pin::pin;
use std::rc::Rc;
use std::task::{Context, Poll, Waker};
use std::time::{Duration, Instant};

use embedded_hal_async::delay::DelayNs;
use embedded_io_async::{ErrorKind, ErrorType, Read, Write};

use crate::link::Port;

/// How long nothing may happen before the future is looked at anyway.
const LONGEST: Duration = Duration::from_millis(100);

/// What the system says of a port.
#[derive(Debug)]
pub struct Fault(pub io::Error);

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.fmt(f)
    }
}

impl std::error::Error for Fault {}

impl embedded_io_async::Error for Fault {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Other
    }
}

/// The port of a bus, shared by the master and the loop that waits for it.
#[derive(Clone)]
pub(super) struct Line {
    port: Rc<RefCell<Port>>,
    /// The next deadline that somebody waits for.
    deadline: Rc<Cell<Option<Instant>>>,
}

impl Line {
    pub(super) fn new(port: Port) -> Self {
        Self { port: Rc::new(RefCell::new(port)), deadline: Rc::default() }
    }

    pub(super) fn set_baud(&self, baud: u32) -> io::Result<()> {
        self.port.borrow_mut().set_baud(baud)
    }

    /// Delays that this line's loop ends.
    pub(super) fn clock(&self) -> Clock {
        Clock(self.deadline.clone())
    }

    /// Runs to its end what waits for this line and its clock.
    pub(super) fn run<F: Future>(&self, future: F) -> F::Output {
        let mut future = pin!(future);
        let mut context = Context::from_waker(Waker::noop());
        loop {
            self.deadline.set(None);
            if let Poll::Ready(output) = future.as_mut().poll(&mut context) {
                return output;
            }
            let left = self.deadline.get().map(|end| end.saturating_duration_since(Instant::now()));
            self.port.borrow_mut().wait_for_bytes(left.unwrap_or(LONGEST).min(LONGEST));
        }
    }
}

impl ErrorType for Line {
    type Error = Fault;
}

impl Read for Line {
    async fn read(&mut self, into: &mut [u8]) -> Result<usize, Fault> {
        poll_fn(|_| match self.port.borrow_mut().receive(into, Duration::ZERO) {
            Ok(None) => Poll::Pending,
            Ok(Some(count)) => Poll::Ready(Ok(count)),
            Err(error) => Poll::Ready(Err(Fault(error))),
        })
        .await
    }
}

impl Write for Line {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Fault> {
        self.port.borrow_mut().send(bytes).map(|()| bytes.len()).map_err(Fault)
    }

    async fn flush(&mut self) -> Result<(), Fault> {
        Ok(())
    }
}

/// The wall's clock.
pub(super) struct Clock(Rc<Cell<Option<Instant>>>);

impl DelayNs for Clock {
    async fn delay_ns(&mut self, ns: u32) {
        let end = Instant::now() + Duration::from_nanos(u64::from(ns));
        poll_fn(|_| {
            if Instant::now() >= end {
                return Poll::Ready(());
            }
            self.0.set(Some(self.0.get().map_or(end, |other| other.min(end))));
            Poll::Pending
        })
        .await;
    }
}
