//! The asking side of the bus without an executor: every call returns when it is done.
//!
//! The port is one of `embedded-io` that can say whether bytes are ready, the delay is one of `embedded-hal`. Deadlines are counted in
//! the time that is spent in this delay, half a byte at a time, so that a wait is never shorter than [`Timing`] says, and longer by
//! what reading and decoding take. A write blocks for as long as the port does.
//!
//! The port must keep what arrives meanwhile: one byte at least, more where other code interrupts for longer than a byte takes.
//!
//! ```
//! # use dynamixel::{blocking::Master, Id, Timing, xm430};
//! # fn example<U: embedded_io::Read + embedded_io::ReadReady + embedded_io::Write>(
//! #     port: U, delay: impl embedded_hal::delay::DelayNs,
//! # ) -> Result<(), dynamixel::Error<U::Error>> {
//! let mut master = Master::<_, _>::new(port, delay, Timing::at(1_000_000));
//! # let Some(id) = Id::new(1) else { return Ok(()) };
//! let position = master.get(id, xm430::PRESENT_POSITION)?.value;
//! master.set(id, xm430::GOAL_POSITION, position + 100)?;
//! # Ok(())
//! # }
//! ```

use core::future::Future;
use core::pin::pin;
use core::task::{Context, Poll, Waker};

use embedded_hal::delay::DelayNs;
use embedded_io::{ErrorType, Read, ReadReady, Write};

use crate::item::{Register, Value};
use crate::master::{self, Answer, BulkAnswer, BulkWrite, Error, Found, Identity, SyncAnswer};
use crate::packet::Id;
use crate::timing::Timing;
use crate::upkeep::{Backup, ResetScope};

/// The master of a bus, as [`crate::Master`] is; each method does what the one of the same name does there.
///
/// `N` bounds instructions and answers in bytes, stuffing included.
#[derive(Debug)]
pub struct Master<U, D, const N: usize = 128> {
    inner: master::Master<Port<U>, Steps<D>, N>,
}

/// A port that is asked again and again.
#[derive(Debug)]
struct Port<U>(U);

/// A delay that is spent step by step, between two looks at the port.
#[derive(Debug)]
struct Steps<D> {
    delay: D,
    step_ns: u32,
}

impl<U: ErrorType> ErrorType for Port<U> {
    type Error = U::Error;
}

impl<U: Read + ReadReady> embedded_io_async::Read for Port<U> {
    async fn read(&mut self, into: &mut [u8]) -> Result<usize, U::Error> {
        core::future::poll_fn(|_| match self.0.read_ready() {
            Ok(true) => Poll::Ready(self.0.read(into)),
            Ok(false) => Poll::Pending,
            Err(error) => Poll::Ready(Err(error)),
        })
        .await
    }
}

impl<U: Write> embedded_io_async::Write for Port<U> {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, U::Error> {
        self.0.write(bytes)
    }

    async fn flush(&mut self) -> Result<(), U::Error> {
        self.0.flush()
    }
}

impl<D: DelayNs> embedded_hal_async::delay::DelayNs for Steps<D> {
    async fn delay_ns(&mut self, ns: u32) {
        let mut rest = ns;
        core::future::poll_fn(|_| {
            if rest == 0 {
                return Poll::Ready(());
            }
            let step = rest.min(self.step_ns);
            self.delay.delay_ns(step);
            rest -= step;
            Poll::Pending
        })
        .await
    }
}

/// Half of what a byte takes, at least 1 µs.
fn step_ns(timing: &Timing) -> u32 {
    timing.wire_us(1).saturating_mul(500).max(1_000)
}

/// Looks at a future until it is done. It always comes to an end: whatever the master waits for has a deadline.
fn run<F: Future>(future: F) -> F::Output {
    let mut future = pin!(future);
    let mut context = Context::from_waker(Waker::noop());
    loop {
        if let Poll::Ready(output) = future.as_mut().poll(&mut context) {
            return output;
        }
    }
}

impl<U, D, const N: usize> Master<U, D, N>
where
    U: Read + ReadReady + Write,
    D: DelayNs,
{
    /// A master on this port.
    pub fn new(port: U, delay: D, timing: Timing) -> Self {
        Master { inner: master::Master::new(Port(port), Steps { delay, step_ns: step_ns(&timing) }, timing) }
    }

    /// How long the master waits.
    pub fn timing(&self) -> Timing {
        self.inner.timing()
    }

    /// Changes how long the master waits, as after a change of the baud rate.
    pub fn set_timing(&mut self, timing: Timing) {
        self.inner.set_timing(timing);
        self.inner.delay_mut().step_ns = step_ns(&timing);
    }

    /// The port, to change its baud rate for instance.
    pub fn port_mut(&mut self) -> &mut U {
        &mut self.inner.port_mut().0
    }

    /// Gives the port back.
    pub fn into_port(self) -> U {
        self.inner.into_port().0
    }

    /// Asks a device what it is.
    pub fn ping(&mut self, id: Id) -> Result<Answer<Identity>, Error<U::Error>> {
        run(self.inner.ping(id))
    }

    /// Asks every device on the bus what it is; gives how many have answered.
    pub fn discover(&mut self, found: &mut [Option<Found>]) -> Result<usize, Error<U::Error>> {
        run(self.inner.discover(found))
    }

    /// Reads the bytes from `address` on, as many as `bytes` holds.
    pub fn read(&mut self, id: Id, address: u16, bytes: &mut [u8]) -> Result<Answer<()>, Error<U::Error>> {
        run(self.inner.read(id, address, bytes))
    }

    /// Writes bytes from `address` on.
    pub fn write(&mut self, id: Id, address: u16, bytes: &[u8]) -> Result<Answer<()>, Error<U::Error>> {
        run(self.inner.write(id, address, bytes))
    }

    /// Reads a register, as in `master.get(id, xm430::PRESENT_POSITION)`.
    pub fn get<T: Value>(&mut self, id: Id, register: Register<T>) -> Result<Answer<T>, Error<U::Error>> {
        run(self.inner.get(id, register))
    }

    /// Writes a register.
    pub fn set<T: Value>(&mut self, id: Id, register: Register<T>, value: T) -> Result<Answer<()>, Error<U::Error>> {
        run(self.inner.set(id, register, value))
    }

    /// Reads a number.
    pub fn read_value<T: Value>(&mut self, id: Id, address: u16) -> Result<Answer<T>, Error<U::Error>> {
        run(self.inner.read_value(id, address))
    }

    /// Writes a number.
    pub fn write_value<T: Value>(&mut self, id: Id, address: u16, value: T) -> Result<Answer<()>, Error<U::Error>> {
        run(self.inner.write_value(id, address, value))
    }

    /// Keeps a write until [`Master::action`].
    pub fn reg_write(&mut self, id: Id, address: u16, bytes: &[u8]) -> Result<Answer<()>, Error<U::Error>> {
        run(self.inner.reg_write(id, address, bytes))
    }

    /// Carries out the write that was kept.
    pub fn action(&mut self, id: Id) -> Result<Answer<()>, Error<U::Error>> {
        run(self.inner.action(id))
    }

    /// Restarts a device.
    pub fn reboot(&mut self, id: Id) -> Result<Answer<()>, Error<U::Error>> {
        run(self.inner.reboot(id))
    }

    /// Returns a device's control table to the factory's values and restarts it.
    pub fn factory_reset(&mut self, id: Id, scope: ResetScope) -> Result<Answer<()>, Error<U::Error>> {
        run(self.inner.factory_reset(id, scope))
    }

    /// Forgets the number of turns.
    pub fn clear_turns(&mut self, id: Id) -> Result<Answer<()>, Error<U::Error>> {
        run(self.inner.clear_turns(id))
    }

    /// Stores the control table, or restores it.
    pub fn backup(&mut self, id: Id, what: Backup) -> Result<Answer<()>, Error<U::Error>> {
        run(self.inner.backup(id, what))
    }

    /// Reads the same `L` bytes of several devices with one instruction.
    pub fn sync_read<const L: usize>(
        &mut self,
        address: u16,
        devices: &mut [SyncAnswer<U::Error, L>],
    ) -> Result<(), Error<U::Error>> {
        run(self.inner.sync_read(address, devices))
    }

    /// As [`Master::sync_read`], answered with one packet.
    pub fn fast_sync_read<const L: usize>(
        &mut self,
        address: u16,
        devices: &mut [SyncAnswer<U::Error, L>],
    ) -> Result<(), Error<U::Error>> {
        run(self.inner.fast_sync_read(address, devices))
    }

    /// Writes `L` bytes from `address` on to several devices with one instruction.
    pub fn sync_write<const L: usize>(
        &mut self,
        address: u16,
        devices: &[(Id, [u8; L])],
    ) -> Result<(), Error<U::Error>> {
        run(self.inner.sync_write(address, devices))
    }

    /// Reads different bytes of several devices with one instruction.
    pub fn bulk_read(&mut self, devices: &mut [BulkAnswer<'_, U::Error>]) -> Result<(), Error<U::Error>> {
        run(self.inner.bulk_read(devices))
    }

    /// As [`Master::bulk_read`], answered with one packet.
    pub fn fast_bulk_read(&mut self, devices: &mut [BulkAnswer<'_, U::Error>]) -> Result<(), Error<U::Error>> {
        run(self.inner.fast_bulk_read(devices))
    }

    /// Writes different bytes to several devices with one instruction.
    pub fn bulk_write(&mut self, devices: &[BulkWrite<'_>]) -> Result<(), Error<U::Error>> {
        run(self.inner.bulk_write(devices))
    }
}
