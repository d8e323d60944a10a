//! Those who hear what a source reports.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use super::told::Told;

/// How often is looked whether a late listener has room again.
const GLANCE: Duration = Duration::from_millis(1);

/// Whoever listens to a source. A listener that does not keep up loses the newest messages; the others do not notice.
#[derive(Debug, Default)]
pub struct Listeners {
    inner: Mutex<Inner>,
}

#[derive(Debug, Default)]
struct Inner {
    listeners: Vec<Arc<Listener>>,
    greeting: Vec<Told>,
    closed: bool,
}

#[derive(Debug)]
struct Listener {
    sender: SyncSender<Told>,
    gone: AtomicBool,
}

impl Listener {
    /// Gives it a message; gives it back if there is no room.
    fn give(&self, told: Told) -> Option<Told> {
        match self.sender.try_send(told) {
            Ok(()) => None,
            Err(TrySendError::Full(told)) => Some(told),
            Err(TrySendError::Disconnected(_)) => {
                self.gone.store(true, Ordering::Relaxed);
                None
            }
        }
    }
}

impl Listeners {
    /// One more, for whom so many messages wait.
    pub fn add(&self, waiting: usize) -> Receiver<Told> {
        let (sender, receiver) = sync_channel(waiting);
        let listener = Listener { sender, gone: AtomicBool::new(false) };
        let mut inner = self.lock();
        for told in &inner.greeting {
            // Whoever has no room for it wants none.
            let _ = listener.give(told.clone());
        }
        if !inner.closed {
            inner.listeners.push(Arc::new(listener));
        }
        receiver
    }

    /// What everybody hears who comes later.
    pub fn greet(&self, told: Told) {
        self.lock().greeting.push(told);
    }

    /// Whether nobody listens.
    pub fn is_empty(&self) -> bool {
        self.lock().listeners.is_empty()
    }

    /// Sends to all; returns how many had no room for it.
    pub fn tell(&self, told: &Told) -> u64 {
        let mut inner = self.lock();
        let unheard = inner.listeners.iter().filter(|listener| listener.give(told.clone()).is_some()).count();
        inner.listeners.retain(|listener| !listener.gone.load(Ordering::Relaxed));
        unheard as u64
    }

    /// Sends to all, waiting for each that has no room for it, until `stop`: for a source that can wait.
    pub fn tell_patiently(&self, told: &Told, stop: &AtomicBool) {
        // Not under the lock: others come meanwhile.
        let listeners = self.lock().listeners.clone();
        for listener in &listeners {
            let mut waiting = listener.give(told.clone());
            while let Some(told) = waiting.take().filter(|_| !stop.load(Ordering::Acquire)) {
                std::thread::sleep(GLANCE);
                waiting = listener.give(told);
            }
        }
        self.lock().listeners.retain(|listener| !listener.gone.load(Ordering::Relaxed));
    }

    /// Nothing more comes: every channel ends.
    pub fn close(&self) {
        let mut inner = self.lock();
        inner.closed = true;
        inner.listeners.clear();
    }

    /// The lock, also if another thread stopped while it held it.
    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::{Event, Notice};

    fn event(time_us: u64) -> Told {
        Told::Event(Notice { time_us, event: Event::ServoLost { finger: 0, other_master: false } })
    }

    #[test]
    fn a_full_listener_loses_the_newest_and_one_that_is_gone_is_forgotten() {
        let listeners = Listeners::default();
        listeners.greet(event(0));
        let (slow, gone) = (listeners.add(2), listeners.add(2));
        drop(gone);
        let unheard: Vec<u64> = (1..4).map(|time| listeners.tell(&event(time))).collect();
        assert_eq!(unheard, [0, 1, 1]);
        listeners.close();
        assert_eq!(slow.iter().collect::<Vec<_>>(), [event(0), event(1)]);
        assert!(listeners.is_empty() && listeners.add(1).iter().count() == 1, "only the greeting");
    }

    #[test]
    fn a_patient_source_loses_nothing() {
        let listeners = Arc::new(Listeners::default());
        let slow = listeners.add(1);
        let teller = std::thread::spawn({
            let listeners = listeners.clone();
            move || {
                let stop = AtomicBool::new(false);
                (0..20).for_each(|time| listeners.tell_patiently(&event(time), &stop));
                listeners.close();
            }
        });
        assert_eq!(slow.iter().count(), 20);
        teller.join().unwrap();
    }
}
