//! The live page: a gripper in a browser, through a small server on this PC.
//!
//! One thread listens to the gripper (`live`) and makes a frame for the eye 30 times a second, whatever the gripper's rate; the
//! log keeps every report. Frames go to any number of pages as server-sent events. What a page asks is a request to the
//! target, and the page shows the target's answer (`command`). The page is one document without anything from outside.

mod access;
mod command;
mod live;
mod object;
mod server;
mod setup;

pub use access::Access;
pub use live::Live;
pub use server::{WebError, open_browser, serve};

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

/// The page.
pub fn page() -> String {
    include_str!("page.html")
        .replace("/*STYLE*/", include_str!("page.css"))
        .replace("/*SCRIPT*/", include_str!("page.js"))
}

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
