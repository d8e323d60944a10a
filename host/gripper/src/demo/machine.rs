//! The gripper's firmware in QEMU: its bus and its link are sockets on which this program listens.
//!
//! The sockets are there before QEMU starts, so that not one of the firmware's first bytes is lost.

use std::fs::File;
use std::io::ErrorKind;
use std::os::unix::net::UnixListener;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use fre_qemu::{Pace, Running as Board, Sockets};

use super::error::DemoError;
use crate::link::{Link, LinkError};
use crate::servo::{Handle, Hub, Running, Servo};

/// How long QEMU may take to start.
const BOOT: Duration = Duration::from_secs(20);
/// How often is looked whether it has.
const GLANCE: Duration = Duration::from_millis(10);

/// A running gripper; ended when dropped.
pub struct Machine {
    board: Board,
    /// The servo, from outside.
    pub servo: Handle,
    bus: Running,
    _sockets: Sockets,
}

impl Machine {
    /// Boots the firmware with a servo on its bus; `log` takes the firmware's log (defmt frames).
    ///
    /// # Errors
    /// QEMU is missing, or ends, or does not connect in time; no sockets or files; `stop` is set.
    pub fn boot(
        firmware: &Path,
        servo: Servo,
        log: File,
        pace: Pace,
        stop: &AtomicBool,
    ) -> Result<(Self, Link), DemoError> {
        let sockets = Sockets::new().map_err(DemoError::file(&std::env::temp_dir()))?;
        let mut hub = Hub::new();
        hub.listen_unix(&sockets.bus())?;
        let servo = hub.servo(servo);
        let bus = hub.spawn()?;
        let listener = UnixListener::bind(sockets.link()).map_err(DemoError::file(sockets.link()))?;
        listener.set_nonblocking(true).map_err(DemoError::System)?;
        let machine = fre_qemu::Machine::new(firmware).pace(pace).connecting(&sockets).apart(sockets.folder());
        let board = machine.boot(log)?;
        let mut machine = Self { board, servo, bus, _sockets: sockets };

        let end = Instant::now() + BOOT;
        let stream = loop {
            match listener.accept() {
                Ok((stream, _)) => break stream,
                Err(error) if error.kind() == ErrorKind::WouldBlock => {}
                Err(error) => return Err(DemoError::System(error)),
            }
            machine.check()?;
            if stop.load(Ordering::Relaxed) {
                return Err(DemoError::Stopped);
            }
            if Instant::now() > end {
                return Err(machine.timeout("connection from QEMU", BOOT));
            }
            std::thread::sleep(GLANCE);
        };
        let link = Link::over_stream(stream)?;
        Ok((machine, link))
    }

    /// That QEMU still runs.
    ///
    /// # Errors
    /// It does not; with its words.
    pub fn check(&mut self) -> Result<(), DemoError> {
        Ok(self.board.check()?)
    }

    /// An error for something that did not happen: that QEMU has ended, if so, else that the time is up.
    pub fn timeout(&mut self, what: &'static str, waited: Duration) -> DemoError {
        self.board.blame(what, waited).into()
    }

    /// An error of the link: that QEMU has ended, if that is behind it.
    pub fn blame(&mut self, error: LinkError) -> DemoError {
        self.board.check_after_close().err().map_or(DemoError::Link(error), DemoError::Qemu)
    }

    /// Bytes that were lost on the bus because QEMU did not take them.
    pub fn lost_on_bus(&self) -> u64 {
        self.bus.lost()
    }
}
