//! The gripper's words, with an end to the patience for them.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use messages::Report;

use super::error::DemoError;
use super::machine::Machine;
use crate::link::Told;

/// How long the first estimate may take, and any later one.
const FIRST: Duration = Duration::from_secs(20);
const SILENCE: Duration = Duration::from_secs(5);
/// How often is looked whether there is something to do.
const GLANCE: Duration = Duration::from_millis(20);

/// The gripper's words as they come.
pub(super) struct Heard {
    told: Receiver<Told>,
    last: Instant,
}

impl Heard {
    /// What comes from now on.
    pub(super) fn of(told: Receiver<Told>) -> Self {
        Self { told, last: Instant::now() }
    }

    /// The next one, or none after a short while.
    pub(super) fn next(&mut self, machine: &mut Machine) -> Result<Option<Told>, DemoError> {
        match self.told.recv_timeout(GLANCE) {
            Ok(told) => {
                self.last = Instant::now();
                Ok(Some(told))
            }
            Err(RecvTimeoutError::Timeout) => {
                machine.check()?;
                if self.last.elapsed() > SILENCE {
                    return Err(machine.timeout("report from the gripper", SILENCE));
                }
                Ok(None)
            }
            Err(RecvTimeoutError::Disconnected) => {
                // QEMU's end closes its sockets a little before it can be seen.
                std::thread::sleep(10 * GLANCE);
                Err(machine.timeout("report from the gripper: the link is closed", self.last.elapsed()))
            }
        }
    }

    /// What came before does not count.
    pub(super) fn forget(&mut self) {
        self.told.try_iter().for_each(drop);
        self.last = Instant::now();
    }

    /// Waits for a trustworthy estimate.
    pub(super) fn until_ready(&mut self, machine: &mut Machine, stop: &AtomicBool) -> Result<(), DemoError> {
        let end = Instant::now() + FIRST;
        while Instant::now() < end {
            if stop.load(Ordering::Relaxed) {
                return Err(DemoError::Stopped);
            }
            if let Some(Told::Report(Report { estimate, .. })) = self.next(machine)?
                && estimate.status.is_trustworthy()
            {
                return Ok(());
            }
        }
        Err(machine.timeout("trustworthy estimate", FIRST))
    }
}
