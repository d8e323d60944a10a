//! A node at work: with a live source, or with a recording and its times.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};

use fre_gripper::record::{Pace, RecordError, Recorded, Recording, Speed};
use fre_gripper::source::{Clock, Source, Told, WAITING, alive, now_ns};

use crate::node::{Node, NodeError};

/// How often is looked whether the node is still wanted.
const GLANCE: Duration = Duration::from_millis(50);
/// How long two participants of DDS that know each other may take until both of their ends do.
const FOUND: Duration = Duration::from_millis(500);

/// Why a node stopped before its time.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The node's.
    #[error(transparent)]
    Node(#[from] NodeError),
    /// The file's.
    #[error(transparent)]
    Record(#[from] RecordError),
}

/// Publishes what a source reports until the time is over, somebody stops it, or nothing more comes; the latter is `true`. The source gets
/// signs of life meanwhile.
///
/// # Errors
/// The node's.
pub fn live(
    node: &mut Node,
    source: &dyn Source,
    length: Option<Duration>,
    stop: &AtomicBool,
) -> Result<bool, RunError> {
    alive(source, || publish(node, source, length, stop))
}

fn publish(
    node: &mut Node,
    source: &dyn Source,
    length: Option<Duration>,
    stop: &AtomicBool,
) -> Result<bool, RunError> {
    let told = source.hear(WAITING);
    let mut clock = Clock::default();
    let end = length.and_then(|length| Instant::now().checked_add(length));
    while !stop.load(Ordering::Acquire) {
        let left = end.map_or(GLANCE, |end| end.saturating_duration_since(Instant::now()).min(GLANCE));
        if left.is_zero() {
            break;
        }
        match told.recv_timeout(left) {
            Ok(told) => {
                let ns = match &told {
                    Told::Report(report) => clock.ns(report.time_us),
                    Told::Event(notice) => clock.ns(notice.time_us),
                    // These come behind the reports that they belong to.
                    Told::Shape(_) | Told::Grasp(_) | Told::Setup(_) => clock.last_ns(),
                };
                node.tell(ns, &told)?;
            }
            Err(RecvTimeoutError::Timeout) => node.silence(now_ns()),
            Err(RecvTimeoutError::Disconnected) => return Ok(true),
        }
    }
    Ok(false)
}

/// Publishes a recording with its own times; `true` at its end.
///
/// # Errors
/// The node's, or the file's.
pub fn replay(node: &mut Node, recording: &mut Recording, speed: Speed, stop: &AtomicBool) -> Result<bool, RunError> {
    let mut pace = Pace::new(speed);
    for recorded in recording {
        let (ns, recorded) = recorded?;
        pace.wait(ns, stop);
        if stop.load(Ordering::Acquire) {
            return Ok(false);
        }
        if let Recorded::Told(told) = recorded {
            node.tell(ns, &told)?;
        }
    }
    Ok(true)
}

/// Waits until the force of every finger has a subscriber, or `stop`. What is published before a subscriber has found the node in its turn is
/// lost to it: it has half a second for that.
pub fn wait_for_subscribers(node: &Node, stop: &AtomicBool) {
    let mut found: Option<Instant> = None;
    while found.is_none_or(|then| then.elapsed() < FOUND) && !stop.load(Ordering::Acquire) {
        found = found.filter(|_| node.subscribers() > 0).or_else(|| (node.subscribers() > 0).then(Instant::now));
        std::thread::sleep(GLANCE);
    }
}

/// Stays for those who still fetch what they have missed: until they have gone, at most this long.
pub fn linger(node: &Node, longest: Duration, stop: &AtomicBool) {
    let end = Instant::now() + longest;
    while node.subscribers() > 0 && Instant::now() < end && !stop.load(Ordering::Acquire) {
        std::thread::sleep(GLANCE);
    }
}
