//! Why a boot loader has not taken an image.

use std::io;
use std::time::Duration;

use crate::link::LinkError;
use crate::probe::ProbeError;

/// Why a boot loader has not taken an image.
#[derive(Debug, thiserror::Error)]
pub enum LoaderError {
    /// The image is not one for this board.
    #[error(transparent)]
    Image(#[from] ProbeError),
    /// The board has no boot loader for this.
    #[error(
        "{board} has no boot loader that takes images by its port; leave out --port and use a debug probe. --port is for opencr"
    )]
    NoLoader {
        /// The board.
        board: &'static str,
    },
    /// Another board is at the port.
    #[error("at {port} is {found}, not {board}; nothing was written")]
    OtherBoard {
        /// The port.
        port: String,
        /// What the program or the boot loader calls its board.
        found: String,
        /// The board.
        board: &'static str,
    },
    /// The port cannot be used.
    #[error(
        "{port} cannot be used: {source}; is it the board's port, may this user open it, and has no other program opened it?"
    )]
    Port {
        /// The port.
        port: String,
        /// The system's words.
        source: io::Error,
    },
    /// No boot loader answers.
    #[error(
        "no boot loader answers at {port} within {waited:?}; nothing was written. Hold the button SW2 while you press RESET: the loader \
         waits then, and its LED blinks"
    )]
    Silent {
        /// The port.
        port: String,
        /// How long was waited.
        waited: Duration,
    },
    /// The loader has stopped answering.
    #[error("the boot loader does not answer while {doing}; the program in flash is incomplete: flash it again")]
    Lost {
        /// What was being done.
        doing: &'static str,
    },
    /// The loader reports an error.
    #[error("the boot loader reports error {error:#06x} while {doing}{hint}")]
    Refused {
        /// What was being done.
        doing: &'static str,
        /// Its number.
        error: u16,
        /// What that means for the board.
        hint: &'static str,
    },
    /// The new program does not answer.
    #[error("the flash of {board} holds the image, but no program answers at {port}: {source}")]
    NotStarted {
        /// The board.
        board: &'static str,
        /// The port.
        port: String,
        /// Why.
        source: Box<LinkError>,
    },
    /// Another program than the new one answers.
    #[error("the program at {port} has version {found} after the update; the image has {wanted}")]
    OtherVersion {
        /// The port.
        port: String,
        /// The program's.
        found: String,
        /// The image's.
        wanted: String,
    },
    /// The lines cannot be written.
    #[error("the progress cannot be written: {0}")]
    Out(#[from] io::Error),
}
