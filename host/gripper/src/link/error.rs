//! Why the link gave nothing.

use std::io;
use std::time::Duration;

use messages::Refusal;
use postcard_rpc::standard_icd::WireError;

use super::{Address, BadAddress};
use crate::source::OrderError;

/// Why the link gave nothing.
#[derive(Debug, thiserror::Error)]
pub enum LinkError {
    /// The address makes no sense.
    #[error(transparent)]
    Address(#[from] BadAddress),
    /// The port cannot be opened.
    #[error("the link {address} cannot be opened: {source}")]
    Open {
        /// Where it should have been.
        address: Address,
        /// The system's words.
        source: io::Error,
    },
    /// The port is not set up.
    #[error("the link cannot be used: {0}")]
    Start(#[source] io::Error),
    /// The request could not be written.
    #[error("the request could not be sent: {0}")]
    Send(#[source] io::Error),
    /// The request is larger than a frame.
    #[error("the request is too large for a frame")]
    TooLong,
    /// The gripper's lists are shorter than this machine's.
    #[error(transparent)]
    NoRoom(#[from] model_core::size::TooLong),
    /// The other end is gone.
    #[error("the link is closed")]
    Closed,
    /// No answer.
    #[error("no answer to \"{path}\" within {waited:?}")]
    Timeout {
        /// The request's path.
        path: &'static str,
        /// How long was waited.
        waited: Duration,
    },
    /// The gripper did not understand the request: other definitions than ours.
    #[error("the gripper does not understand \"{path}\": {error}")]
    Wire {
        /// The request's path.
        path: &'static str,
        /// What it says.
        error: WireError,
    },
    /// The answer is not what it should be.
    #[error("the answer to \"{path}\" cannot be read")]
    Answer {
        /// The request's path.
        path: &'static str,
    },
    /// The gripper understood and did not want.
    #[error("the gripper refuses: {0}")]
    Refused(#[from] Refusal),
}

impl From<LinkError> for OrderError {
    fn from(error: LinkError) -> Self {
        Self::Gripper(Box::new(error))
    }
}
