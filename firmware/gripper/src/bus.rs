//! The Dynamixel bus between the control task and the bus task.
//!
//! The control task says when a tick's question is to be asked, and goes on with its estimate; the bus task, which interrupts it
//! ([`serve`](crate::serve)), asks at that time with the goals that are then there, and keeps the answers until they are wanted. Where another
//! master leads, the bus task hears and answers instead. Everything else that is done on the bus takes more than one transaction and
//! follows from the last one's answer: the control task does that itself, while the bus task has no job.

use core::cell::Cell;

use embassy_sync::blocking_mutex::Mutex as Blocking;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex as Raw;
use embassy_sync::mutex::{Mutex, MutexGuard};
use embassy_sync::signal::Signal;
use embassy_time::{Duration, Instant};
use heapless::Vec;
use messages::FINGERS;

use crate::board::BusPort;
use crate::ears::Ears;
use crate::servo::{Goals, Servos, Turn};

/// What a bus has: the servos, and the question that is asked of them.
pub(crate) struct Line<U: BusPort> {
    pub(crate) servos: Servos<U>,
    /// Whom the question is for; then what they have answered.
    pub(crate) turns: Vec<Turn<U>, FINGERS>,
    /// From the last question's beginning to its last answer.
    pub(crate) took: Duration,
}

/// What the bus task has to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Job {
    /// Nothing.
    Rest,
    /// To ask the question at this time.
    Ask(Instant),
    /// To hear and to answer what another master says.
    Listen,
}

/// The ears, until this is dropped; nothing where nobody listens.
pub(crate) type HeldEars<'b> = MutexGuard<'b, Raw, Option<Ears>>;

/// The bus, for the two tasks that use it. One per gripper, in a static.
pub struct Bus<U: BusPort> {
    line: Mutex<Raw, Line<U>>,
    /// What the gripper makes of another master's traffic; locked for moments only.
    ears: Mutex<Raw, Option<Ears>>,
    goals: Blocking<Raw, Cell<Goals>>,
    job: Signal<Raw, Job>,
    answered: Signal<Raw, ()>,
    heard: Signal<Raw, ()>,
}

impl<U: BusPort> Bus<U> {
    /// The bus behind this port; `latency_us` is [`Board::BUS_LATENCY_US`](crate::Board::BUS_LATENCY_US).
    pub fn new(port: U, latency_us: u32) -> Self {
        let line = Line { servos: Servos::new(port, latency_us), turns: Vec::new(), took: Duration::from_ticks(0) };
        Self {
            line: Mutex::new(line),
            ears: Mutex::new(None),
            goals: Blocking::new(Cell::new([None; FINGERS])),
            job: Signal::new(),
            answered: Signal::new(),
            heard: Signal::new(),
        }
    }

    /// The servos, once the bus task has no job; until this is dropped it does none.
    pub(crate) async fn line(&self) -> MutexGuard<'_, Raw, Line<U>> {
        self.line.lock().await
    }

    /// What the gripper makes of another master's traffic.
    pub(crate) async fn ears(&self) -> HeldEars<'_> {
        self.ears.lock().await
    }

    /// Gives the bus task something to do. It asks a question to its end, and listens until it gets something else.
    pub(crate) fn give(&self, job: Job) {
        self.job.signal(job);
    }

    /// The next thing that the bus task has to do.
    pub(crate) async fn job(&self) -> Job {
        self.job.wait().await
    }

    /// The goals that the next question is asked with.
    pub(crate) fn goals(&self) -> Goals {
        self.goals.lock(Cell::get)
    }

    /// The servos' goals from the next question on.
    pub(crate) fn set_goals(&self, goals: Goals) {
        self.goals.lock(|kept| kept.set(goals));
    }

    /// The question is answered.
    pub(crate) fn has_answered(&self) {
        self.answered.signal(());
    }

    /// Waits for the answers to the question.
    pub(crate) async fn answered(&self) {
        self.answered.wait().await;
    }

    /// Something was heard.
    pub(crate) fn has_heard(&self) {
        self.heard.signal(());
    }

    /// Waits until something is heard.
    pub(crate) async fn heard(&self) {
        self.heard.wait().await;
    }
}
