//! Who leads the fingers: the program, or a person who has taken over.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

/// Something that leads the fingers by itself until a person does.
#[derive(Debug, Default)]
pub struct Lead {
    pausing: AtomicBool,
    /// Held while an order of the lead is under way.
    ordering: Mutex<()>,
}

impl Lead {
    /// Gives an order unless a person leads; false if so.
    pub fn order(&self, order: impl FnOnce()) -> bool {
        let _one = self.ordering.lock();
        let leads = !self.is_pausing();
        if leads {
            order();
        }
        leads
    }

    /// Whether a person leads.
    pub fn is_pausing(&self) -> bool {
        self.pausing.load(Ordering::Acquire)
    }

    /// A person leads, from the next order on.
    pub fn pause(&self) {
        self.pausing.store(true, Ordering::Release);
    }

    /// Returns when no order of the lead is under way any more.
    pub fn settle(&self) {
        drop(self.ordering.lock());
    }

    /// The lead goes on.
    pub fn resume(&self) {
        self.pausing.store(false, Ordering::Release);
    }
}
