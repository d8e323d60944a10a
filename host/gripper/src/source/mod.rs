//! Where estimates come from: a gripper behind a link, servos on a bus of this PC, or a recording. All tell the same, so
//! that a view, a page, a recorder and plain lines need not know which.

mod alive;
mod base;
mod clock;
mod ended;
mod gap;
mod listeners;
mod margin;
mod setup;
mod told;

pub use alive::{SIGN_OF_LIFE, alive};
pub use base::Base;
pub use clock::{Clock, now_ns};
pub use ended::Ended;
pub use gap::{Gap, Sequence};
pub use listeners::Listeners;
#[cfg(test)]
pub(crate) use margin::tests;
pub use margin::{GripMargin, Margins};
pub use setup::{Modelled, Origin, Setup};
pub use told::Told;

use std::sync::mpsc::Receiver;

use messages::{CloseTo, Counters, Finger, GripTo, Object, Refusal, Settings, Which};

/// Messages that wait for a listener unless it asks for more: 2 s of four fingers at 500 Hz.
pub const WAITING: usize = 4096;

/// What was heard so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Sound frames.
    pub frames: u64,
    /// Damaged ones.
    pub damaged: u64,
    /// Sound ones that nobody expected: other definitions than ours, or answers after their time.
    pub unexpected: u64,
    /// Reports missing between those that came, by their sequence numbers.
    pub missing_reports: u64,
    /// Messages that a listener had no room for.
    pub unheard: u64,
}

/// What a source may be asked for.
#[derive(Clone, Debug, PartialEq)]
pub enum Order {
    /// Another object for a finger, in that finger's world frame.
    Object(u8, Object),
    /// Another design of a finger.
    Finger(u8, Box<Finger>),
    /// Other settings.
    Settings(Settings),
    /// Open.
    Open(Which),
    /// Close to an angle.
    Close(CloseTo),
    /// Close until a force is reached.
    Grip(GripTo),
    /// Stay where it is.
    Hold(Which),
    /// Switch the servos' torque off: whatever they hold is let go.
    Relax(Which),
}

/// Why an order was not obeyed.
#[derive(Debug, thiserror::Error)]
pub enum OrderError {
    /// The gripper's, or the connection's.
    #[error(transparent)]
    Gripper(Box<dyn std::error::Error + Send + Sync>),
    /// The value is not allowed.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// Some of the fingers have not obeyed; the others have.
    #[error("no answer from the servo of finger {}; every other finger has done it", numbers(.0))]
    Silent(Vec<u8>),
    /// This source cannot do that.
    #[error("{0}")]
    Never(&'static str),
}

fn numbers(fingers: &[u8]) -> String {
    let words: Vec<String> = fingers.iter().map(u8::to_string).collect();
    words.join(", ")
}

/// A source of estimates.
///
/// Its thread ends when it is dropped; the listeners' channels end with it, or before when nothing more comes.
pub trait Source: Send + Sync {
    /// The source, with its settings, designs and objects, as of now.
    ///
    /// # Errors
    /// A gripper that does not answer.
    fn setup(&self) -> Result<Setup, OrderError>;

    /// Everything that is reported from now on; `waiting` messages wait for a listener that is late, what comes then is lost to it
    /// and counted ([`Statistics::unheard`]).
    fn hear(&self, waiting: usize) -> Receiver<Told>;

    /// What came so far, and what is missing.
    fn statistics(&self) -> Statistics;

    /// What a gripper counted; nothing if this source does not count.
    ///
    /// # Errors
    /// A gripper that does not answer.
    fn counters(&self) -> Result<Option<Counters>, OrderError>;

    /// Says that this program is there, and waits for no answer: a gripper may stop the motions of hosts that are gone. [`alive`] does it as
    /// often as needed. Other sources do not mind.
    fn sign(&self) {}

    /// Does what is asked, or says why not. A changed set-up goes to all listeners.
    ///
    /// # Errors
    /// The order is not for this source, or not allowed.
    fn order(&self, order: &Order) -> Result<(), OrderError>;

    /// Nothing more comes.
    fn is_closed(&self) -> bool;
}
