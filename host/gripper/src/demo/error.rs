//! Why a demonstration came to nothing.

use std::io;
use std::path::PathBuf;

use fre::files::FileError;
use fre_qemu::QemuError;
use model_core::discretise::DiscretiseError;

use crate::link::LinkError;
use crate::servo::{ConfigError, LoadError, PortError};
use fre::case::CaseError;
use fre::draw::DrawError;

/// Why a demonstration came to nothing.
#[derive(Debug, thiserror::Error)]
pub enum DemoError {
    /// The duration.
    #[error("--seconds is {0}; allowed is 4 to 600")]
    Seconds(f64),
    /// Somebody wanted it to end.
    #[error("stopped before the first estimate")]
    Stopped,
    /// QEMU, or what was waited for in vain.
    #[error(transparent)]
    Qemu(#[from] QemuError),
    /// A file of the report.
    #[error(transparent)]
    Files(#[from] FileError),
    /// A file or folder.
    #[error("{} cannot be written: {source}", path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// The system's words.
        source: io::Error,
    },
    /// A thread or socket.
    #[error("the system gives no thread or socket: {0}")]
    System(#[source] io::Error),
    /// The live lines cannot be written.
    #[error("standard output cannot be written: {0}")]
    Output(#[source] io::Error),
    /// The finger.
    #[error("the preset {0} is missing")]
    Preset(&'static str),
    /// The finger's file.
    #[error(transparent)]
    Case(#[from] CaseError),
    /// The finger's model.
    #[error("a reference cannot be made: {0}")]
    Model(DiscretiseError),
    /// The reference finds no place to begin.
    #[error("a reference cannot begin: the open finger touches the object")]
    NoRoom,
    /// The servo's load.
    #[error("the servo's load: {0}")]
    Load(#[from] LoadError),
    /// The servo.
    #[error("the servo: {0}")]
    Servo(#[from] ConfigError),
    /// The bus.
    #[error("the bus: {0}")]
    Bus(#[from] PortError),
    /// The link.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// The live page.
    #[cfg(feature = "web")]
    #[error(transparent)]
    Web(#[from] crate::web::WebError),
    /// A picture.
    #[error(transparent)]
    Draw(#[from] DrawError),
}

impl DemoError {
    /// A file that cannot be written.
    pub(super) fn file(path: impl Into<PathBuf>) -> impl FnOnce(io::Error) -> Self {
        let path = path.into();
        move |source| Self::File { path, source }
    }
}
