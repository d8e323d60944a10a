//! Those who hear what a source tells.

use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::Told;

/// Whoever listens to a source. A listener that does not keep up loses the newest messages; the others do not notice.
#[derive(Debug, Default)]
pub struct Listeners {
    inner: Mutex<Inner>,
}

#[derive(Debug, Default)]
struct Inner {
    senders: Vec<SyncSender<Told>>,
    greeting: Vec<Told>,
    closed: bool,
}

impl Listeners {
    /// One more, for whom so many messages wait.
    pub fn add(&self, waiting: usize) -> Receiver<Told> {
        let (sender, receiver) = sync_channel(waiting);
        let mut inner = self.lock();
        for told in &inner.greeting {
            // Whoever has no room for it wants none.
            let _ = sender.try_send(told.clone());
        }
        if !inner.closed {
            inner.senders.push(sender);
        }
        receiver
    }

    /// What everybody hears who comes later.
    pub fn greet(&self, told: Told) {
        self.lock().greeting.push(told);
    }

    /// Tells all; how many had no room for it.
    pub fn tell(&self, told: &Told) -> u64 {
        let mut unheard = 0;
        self.lock().senders.retain(|listener| match listener.try_send(told.clone()) {
            Ok(()) => true,
            Err(TrySendError::Full(_)) => {
                unheard += 1;
                true
            }
            Err(TrySendError::Disconnected(_)) => false,
        });
        unheard
    }

    /// Tells all, waiting for each that has no room for it: for a source that can wait.
    pub fn tell_patiently(&self, told: &Told) {
        // Not under the lock: a listener that stops may be waited for by one that comes.
        let senders = self.lock().senders.clone();
        for listener in &senders {
            // Whoever is gone is dropped by the next `tell`, or with the source.
            let _ = listener.send(told.clone());
        }
    }

    /// Nothing more comes: every channel ends.
    pub fn close(&self) {
        let mut inner = self.lock();
        inner.closed = true;
        inner.senders.clear();
    }

    /// The lock, also if another thread stopped while it held it.
    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
