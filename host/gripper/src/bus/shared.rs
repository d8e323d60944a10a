//! What the bus's thread and its handle have in common.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::Sender;
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::source::{Listeners, Order, OrderError, Setup, Told};

/// An order and where its outcome goes.
pub(super) struct Asked {
    pub(super) order: Order,
    pub(super) outcome: Sender<Result<(), OrderError>>,
}

#[derive(Debug)]
pub(super) struct Shared {
    pub(super) listeners: Listeners,
    pub(super) setup: Mutex<Setup>,
    pub(super) frames: AtomicU64,
    pub(super) damaged: AtomicU64,
    pub(super) unheard: AtomicU64,
    pub(super) stop: AtomicBool,
    pub(super) closed: AtomicBool,
}

impl Shared {
    pub(super) fn tell(&self, told: &Told) {
        self.unheard.fetch_add(self.listeners.tell(told), Ordering::Relaxed);
    }

    pub(super) fn setup(&self) -> MutexGuard<'_, Setup> {
        self.setup.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
