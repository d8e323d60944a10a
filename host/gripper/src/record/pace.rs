//! How fast a recording is gone through.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// How often one who waits looks whether he is still wanted.
const GLANCE: Duration = Duration::from_millis(20);

/// How fast a recording is played.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Speed {
    /// So many times as fast as it was recorded.
    Times(f64),
    /// As fast as whoever listens takes it.
    AtOnce,
}

/// When a recording's messages are due; the first one is at once.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    speed: Speed,
    /// Time of the first message, ns, and when it was.
    began: Option<(u64, Instant)>,
}

impl Pace {
    /// Before the first message.
    pub fn new(speed: Speed) -> Self {
        Self { speed, began: None }
    }

    /// Waits until a message of this time (ns) is due, or `stop`.
    pub fn wait(&mut self, ns: u64, stop: &AtomicBool) {
        let Speed::Times(times) = self.speed else { return };
        let (first, start) = *self.began.get_or_insert_with(|| (ns, Instant::now()));
        let due = start + Duration::from_nanos(ns.saturating_sub(first)).div_f64(times);
        while !stop.load(Ordering::Acquire) {
            match due.checked_duration_since(Instant::now()) {
                Some(early) if !early.is_zero() => std::thread::sleep(early.min(GLANCE)),
                _ => return,
            }
        }
    }
}
