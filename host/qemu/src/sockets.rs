//! Sockets of the board's two UARTs.

use std::fs::Permissions;
use std::io;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

/// A folder for the sockets of a board's bus and link, open to this user only, removed when dropped.
///
/// It is in the system's temporary folder because a socket's path has at most 107 bytes.
#[derive(Debug)]
pub struct Sockets(TempDir);

impl Sockets {
    /// Makes the folder.
    ///
    /// # Errors
    /// The temporary folder cannot be written.
    pub fn new() -> io::Result<Self> {
        let own = Permissions::from_mode(0o700);
        tempfile::Builder::new().prefix("fre-qemu-").permissions(own).tempdir().map(Self)
    }

    /// Socket of UART 0, the servos' bus.
    pub fn bus(&self) -> PathBuf {
        self.0.path().join("bus")
    }

    /// Socket of UART 1, the link to the host.
    pub fn link(&self) -> PathBuf {
        self.0.path().join("link")
    }

    /// The folder: what belongs to the same run may be kept here too.
    pub fn folder(&self) -> &Path {
        self.0.path()
    }
}
