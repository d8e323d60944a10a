//! Ctrl-C: long work asks Python now and then whether a signal has come.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::time::{Duration, Instant};

use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use rayon::ThreadPool;

use crate::error::value;

/// How long work goes on before Python is asked.
pub(crate) const GLANCE: Duration = Duration::from_millis(100);

fn check() -> PyResult<()> {
    Python::attach(|py| py.check_signals())
}

/// The error of work that was stopped, until [`Signals::or`] or [`in_pool`] put what the handler raised in its place.
pub(crate) fn stopped() -> PyErr {
    PyKeyboardInterrupt::new_err(())
}

/// Looks for signals between the steps of work on the calling thread.
pub(crate) struct Signals {
    asked: Instant,
    raised: Option<PyErr>,
}

impl Signals {
    /// Begins to look.
    pub(crate) fn new() -> Self {
        Self { asked: Instant::now(), raised: None }
    }

    /// Whether the work goes on. Asks Python at most once per [`GLANCE`]: another thread may hold the interpreter.
    pub(crate) fn look(&mut self) -> ControlFlow<()> {
        if self.raised.is_none() && self.asked.elapsed() >= GLANCE {
            self.raised = check().err();
            self.asked = Instant::now();
        }
        if self.raised.is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// What has come of the work; what a signal's handler raised if that has stopped it.
    pub(crate) fn or<X>(self, found: PyResult<X>) -> PyResult<X> {
        self.raised.map_or(found, Err)
    }
}

/// Does work in the threads of a pool, which stops early when its flag is set: as soon as a signal's handler raises. Python runs handlers
/// on its main thread alone, so the calling thread waits and looks.
pub(crate) fn in_pool<X: Send>(pool: &ThreadPool, work: impl FnOnce(&AtomicBool) -> PyResult<X> + Send) -> PyResult<X> {
    let stop = &AtomicBool::new(false);
    let (sender, done) = sync_channel(1);
    pool.in_place_scope(|scope| {
        scope.spawn(move |_| {
            // Who has stopped it does not wait for its result.
            let _ = sender.send(work(stop));
        });
        loop {
            match done.recv_timeout(GLANCE) {
                Ok(found) => return found,
                Err(RecvTimeoutError::Timeout) => check().inspect_err(|_| stop.store(true, Ordering::Relaxed))?,
                // The work has panicked, which the end of the scope passes on.
                Err(RecvTimeoutError::Disconnected) => return Err(value("the work has ended without a result")),
            }
        }
    })
}
