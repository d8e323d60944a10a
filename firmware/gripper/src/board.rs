//! What the gripper needs of a board.

use embedded_io_async::{Read, Write};
use embedded_storage::nor_flash::NorFlash;
use messages::ResetCause;

use crate::last_words::LastWords;

/// The Dynamixel bus.
pub trait BusPort: Read + Write {
    /// Sets the rate and returns the one reached, bits per second.
    fn set_baud(&mut self, baud: u32) -> u32;

    /// When the last byte came, in ticks of [`Board::cost_ticks`]; nothing where the port does not know.
    fn heard_ticks(&self) -> Option<u32> {
        None
    }
}

/// What restarts the processor when it is not fed in time.
pub trait Watchdog {
    /// Gives it [`Board::WATCHDOG_MS`] again.
    fn feed(&mut self);
}

/// A board.
pub trait Board {
    /// Its bus.
    type Bus: BusPort;
    /// Where settings live: all of it, from address 0 to its capacity; at least two erase sectors, and one sector less
    /// than the whole holds [`Self::FINGERS`] + 1 kilobytes.
    ///
    /// Writing may hold the processor (see [`Self::FLASH_STALLS`]): the settings are written only when the host changes them.
    type Flash: NorFlash;
    /// Its watchdog, running since the start.
    type Watchdog: Watchdog;
    /// Its name, 16 bytes at most.
    const NAME: &'static str;
    /// Fingers it has memory for, 1 to [`messages::FINGERS`].
    const FINGERS: usize;
    /// What port and scheduler add to a servo's answer, µs, at most.
    const BUS_LATENCY_US: u32;
    /// How long an answer to another master takes to be ready, µs, at most, from when the question is known to have ended. A shorter return
    /// delay than this and a byte's time is refused, but for 0.
    const ANSWER_US: u32;
    /// Ticks per second of the clock behind [`Self::cost_ticks`].
    const COST_HZ: u32;
    /// After how long without food the watchdog restarts the processor, ms; more than writing the settings takes.
    const WATCHDOG_MS: u32;
    /// Writing [`Self::Flash`] holds the processor, for up to a second or two while a sector is erased: program and settings share a
    /// bank. It is then written between transactions on the bus.
    const FLASH_STALLS: bool;
    /// A clock that wraps, to measure what the estimate costs.
    fn cost_ticks() -> u32;
    /// Starts the program anew, as after [`ResetCause::Software`]; the words, if there are any, are the next start's
    /// [`Boot::last_words`].
    fn restart(last_words: &'static str) -> !;
}

/// How this start came about.
#[derive(Clone, Debug)]
pub struct Boot {
    /// Why the processor started.
    pub cause: ResetCause,
    /// What the program before said when it ended, if it could.
    pub last_words: Option<messages::Text>,
}

impl Boot {
    /// Reads what survived the reset, once: the record is empty afterwards.
    pub fn new(cause: ResetCause, survived: &mut LastWords) -> Self {
        Self { cause, last_words: survived.take() }
    }
}
