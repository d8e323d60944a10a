//! Why nothing more is shown.

use std::process::ExitCode;

use crate::exit::bad_input;
use fre::files::FileError;
use fre_gripper::source::OrderError;

/// Why nothing more is shown.
pub enum Stop {
    /// What was asked for makes no sense, or does not answer.
    Input(String),
    /// The output.
    Output(std::io::Error),
}

impl Stop {
    /// Prints it, and gives the exit status.
    pub fn exit(self) -> ExitCode {
        match self {
            Self::Input(message) => bad_input(&message),
            // Whoever reads the lines has read enough.
            Self::Output(error) if error.kind() == std::io::ErrorKind::BrokenPipe => ExitCode::SUCCESS,
            Self::Output(error) => bad_input(&format!("cannot write: {error}")),
        }
    }
}

impl From<std::io::Error> for Stop {
    fn from(error: std::io::Error) -> Self {
        Self::Output(error)
    }
}

impl From<FileError> for Stop {
    fn from(error: FileError) -> Self {
        Self::Input(error.to_string())
    }
}

impl From<OrderError> for Stop {
    fn from(error: OrderError) -> Self {
        Self::Input(error.to_string())
    }
}

#[cfg(feature = "terminal")]
impl From<fre_gripper::terminal::TerminalError> for Stop {
    fn from(error: fre_gripper::terminal::TerminalError) -> Self {
        Self::Input(error.to_string())
    }
}

impl From<Box<dyn std::error::Error>> for Stop {
    fn from(error: Box<dyn std::error::Error>) -> Self {
        Self::Input(error.to_string())
    }
}
