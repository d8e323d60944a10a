//! What a source has reported and nobody has read yet.

use std::collections::VecDeque;
use std::io;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use fre_gripper::source::Told;
use pyo3::prelude::*;

use crate::report::{deadline, python};
use crate::signals::GLANCE;

/// Most messages that wait: a minute of four fingers at 500 Hz.
const MOST: usize = 1 << 17;
/// No report is on its way for longer, µs: one farther from an order is of a gripper that has started anew.
const LEAP_US: u64 = 2_000_000;

/// Messages that wait for a reader.
#[derive(Default)]
struct Waiting {
    told: VecDeque<Told>,
    /// When the last order was given, µs, until a later report has come.
    since_us: Option<u64>,
    /// Messages that nobody will read.
    unread: u64,
    /// Nothing more comes.
    ended: bool,
}

impl Waiting {
    /// Takes a message; the oldest makes room for it.
    fn take(&mut self, told: Told) {
        let is_before = match (&told, self.since_us) {
            // Nobody reads them.
            (Told::Shape(_) | Told::Setup(_), _) => return,
            (Told::Report(report), Some(since_us)) => {
                let is_before = report.time_us <= since_us && since_us - report.time_us <= LEAP_US;
                self.since_us = self.since_us.filter(|_| is_before);
                is_before
            }
            // It follows the reports of its fingers.
            (Told::Grasp(_), Some(_)) => true,
            _ => false,
        };
        if is_before {
            self.unread += 1;
            return;
        }
        if self.told.len() >= MOST {
            self.told.pop_front();
            self.unread += 1;
        }
        self.told.push_back(told);
    }

    /// Drops reports and grasps of before an order, also those that are on their way. Events stay: each says when it happened.
    fn forget(&mut self, since_us: u64) {
        let is_since = |time_us: u64| time_us > since_us && time_us - since_us <= LEAP_US;
        let before = |told: &Told| matches!(told, Told::Report(report) if !is_since(report.time_us));
        let next = self.told.iter().rposition(before).map_or(0, |last| last + 1);
        let first = (next..self.told.len()).find(|&place| matches!(self.told[place], Told::Report(_)));
        self.since_us = if first.is_none() { Some(since_us) } else { None };
        let (count, first) = (self.told.len(), first.unwrap_or(self.told.len()));
        let mut place = 0;
        self.told.retain(|told| {
            place += 1;
            place > first || matches!(told, Told::Event(_))
        });
        self.unread += (count - self.told.len()) as u64;
    }
}

/// What is shared with the thread that hears.
#[derive(Default)]
struct Shared {
    waiting: Mutex<Waiting>,
    news: Condvar,
}

impl Shared {
    /// The lock, also if another thread stopped while it held it.
    fn lock(&self) -> MutexGuard<'_, Waiting> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// What a source reports, kept until it is read: the newest of it.
pub(crate) struct Heard(Arc<Shared>);

impl Heard {
    /// Hears a source in a thread that ends with it.
    pub(crate) fn new(source: Receiver<Told>) -> io::Result<Self> {
        let shared = Arc::<Shared>::default();
        let for_thread = shared.clone();
        std::thread::Builder::new().name("reports".into()).spawn(move || {
            for told in source {
                for_thread.lock().take(told);
                for_thread.news.notify_one();
            }
            for_thread.lock().ended = true;
            for_thread.news.notify_all();
        })?;
        Ok(Self(shared))
    }

    /// Drops reports and grasps of before an order, which was given at this time of the gripper, µs.
    pub(crate) fn forget(&self, since_us: u64) {
        self.0.lock().forget(since_us);
    }

    /// Messages that came here and that nobody has read or will read.
    pub(crate) fn unread(&self) -> u64 {
        self.0.lock().unread
    }

    /// The next message, waited for at most so long.
    fn wait(&self, longest: Duration) -> Result<Told, RecvTimeoutError> {
        let idle = |waiting: &mut Waiting| waiting.told.is_empty() && !waiting.ended;
        let woken = self.0.news.wait_timeout_while(self.0.lock(), longest, idle);
        let (mut waiting, _) = woken.unwrap_or_else(PoisonError::into_inner);
        let ended = waiting.ended;
        let none = if ended { RecvTimeoutError::Disconnected } else { RecvTimeoutError::Timeout };
        waiting.told.pop_front().ok_or(none)
    }

    /// The next report, event or grasp as Python takes it; none if nothing came in time or nothing comes any more.
    pub(crate) fn next<'py>(&self, py: Python<'py>, timeout_s: f64) -> PyResult<Option<Bound<'py, PyAny>>> {
        let end = deadline("timeout_s", timeout_s)?;
        let left = || end.map_or(GLANCE, |end| end.saturating_duration_since(Instant::now()));
        loop {
            match py.detach(|| self.wait(left().min(GLANCE))) {
                Ok(told) => match python(py, &told)? {
                    Some(told) => return Ok(Some(told)),
                    None => continue,
                },
                Err(RecvTimeoutError::Disconnected) => return Ok(None),
                Err(RecvTimeoutError::Timeout) => {
                    py.check_signals()?;
                    if left().is_zero() {
                        return Ok(None);
                    }
                }
            }
        }
    }
}
