//! Ports of a bus: raw pseudo-terminals and sockets, none of which ever holds it.

use std::fs::File;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};

use rustix::fs::{Mode, OFlags, fcntl_getfl, fcntl_setfl, open};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, QueueSelector, tcflush, tcgetattr, tcsetattr};

/// Why a port could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum PortError {
    /// The pseudo-terminal.
    #[error("no pseudo-terminal could be opened: {0}")]
    Pty(#[source] io::Error),
    /// A unix socket.
    #[error("the socket {} cannot be {action}: {source}", path.display())]
    Unix {
        /// Its path.
        path: PathBuf,
        /// What was tried.
        action: &'static str,
        /// The system's words.
        source: io::Error,
    },
    /// A TCP socket.
    #[error("the address {address} cannot be {action}: {source}")]
    Tcp {
        /// As it was given.
        address: String,
        /// What was tried.
        action: &'static str,
        /// The system's words.
        source: io::Error,
    },
    /// Anything else.
    #[error("the bus could not be started: {0}")]
    Start(#[source] io::Error),
}

/// Rate of a new pseudo-terminal, bits per second; no Dynamixel device has it.
const NEW_PTY: u32 = 38_400;

/// Someone on the bus.
#[derive(Debug)]
pub(super) enum Port {
    Pty {
        controller: File,
        /// Kept open, so that the terminal stays raw and does not hang up when the other program leaves.
        peer: OwnedFd,
    },
    Unix(UnixStream),
    Tcp(TcpStream),
}

impl Port {
    /// A raw pseudo-terminal and the path that the other program opens.
    pub(super) fn pty() -> Result<(Self, PathBuf), PortError> {
        let pty = || -> io::Result<_> {
            let controller = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)?;
            grantpt(&controller)?;
            unlockpt(&controller)?;
            let name = ptsname(&controller, Vec::new())?;
            let path = PathBuf::from(name.to_str().map_err(io::Error::other)?);
            let peer = open(&path, OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC, Mode::empty())?;
            // Raw before anyone else opens it: otherwise the line editor echoes, and swallows bytes such as 0x03.
            let mut settings = tcgetattr(&peer)?;
            settings.make_raw();
            tcsetattr(&peer, OptionalActions::Now, &settings)?;
            fcntl_setfl(&controller, fcntl_getfl(&controller)? | OFlags::NONBLOCK)?;
            Ok((Self::Pty { controller: File::from(controller), peer }, path))
        };
        pty().map_err(PortError::Pty)
    }

    pub(super) fn unix(stream: UnixStream) -> io::Result<Self> {
        stream.set_nonblocking(true)?;
        Ok(Self::Unix(stream))
    }

    pub(super) fn tcp(stream: TcpStream) -> io::Result<Self> {
        stream.set_nonblocking(true)?;
        stream.set_nodelay(true)?;
        Ok(Self::Tcp(stream))
    }

    /// Bits per second to which the other program has set its terminal; nothing for a socket, which carries bytes at any rate, and for a
    /// terminal that nobody has set.
    pub(super) fn rate(&self) -> Option<u32> {
        let Self::Pty { peer, .. } = self else { return None };
        tcgetattr(peer).ok().map(|settings| settings.output_speed()).filter(|rate| *rate != NEW_PTY)
    }

    /// What has arrived: nothing yet (`None`), or 0 bytes if the party has left.
    pub(super) fn receive(&mut self, into: &mut [u8]) -> Option<usize> {
        let result = match self {
            Self::Pty { controller, .. } => controller.read(into),
            Self::Unix(stream) => stream.read(into),
            Self::Tcp(stream) => stream.read(into),
        };
        match result {
            Ok(count) => Some(count),
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => None,
            Err(_) => Some(0),
        }
    }

    /// Sends as much as the party has room for; gives the number of bytes that are lost.
    pub(super) fn send(&mut self, bytes: &[u8]) -> usize {
        let mut rest = bytes;
        let mut flushed = false;
        while !rest.is_empty() {
            let result = match self {
                Self::Pty { controller, .. } => controller.write(rest),
                Self::Unix(stream) => stream.write(rest),
                Self::Tcp(stream) => stream.write(rest),
            };
            match (result, &self) {
                (Ok(count), _) if count > 0 => rest = &rest[count..],
                (Err(error), _) if error.kind() == ErrorKind::Interrupted => {}
                // Nobody reads the terminal: who opens it later wants the present, not the past.
                (_, Self::Pty { peer, .. }) if !flushed => {
                    flushed = true;
                    let _ = tcflush(peer, QueueSelector::IFlush);
                }
                _ => return rest.len(),
            }
        }
        0
    }
}

impl AsFd for Port {
    fn as_fd(&self) -> BorrowedFd<'_> {
        match self {
            Self::Pty { controller, .. } => controller.as_fd(),
            Self::Unix(stream) => stream.as_fd(),
            Self::Tcp(stream) => stream.as_fd(),
        }
    }
}

/// A door to the bus.
#[derive(Debug)]
pub(super) enum Listener {
    Unix { listener: UnixListener, path: PathBuf },
    Tcp(TcpListener),
}

impl Listener {
    pub(super) fn unix(path: &Path) -> Result<Self, PortError> {
        let failed = |source| PortError::Unix { path: path.to_owned(), action: "listened on", source };
        // A socket that nobody listens on is what a process that was killed has left behind.
        let is_socket = std::fs::symlink_metadata(path)
            .is_ok_and(|data| std::os::unix::fs::FileTypeExt::is_socket(&data.file_type()));
        if is_socket && UnixStream::connect(path).is_err_and(|error| error.kind() == ErrorKind::ConnectionRefused) {
            std::fs::remove_file(path).map_err(failed)?;
        }
        let listener = UnixListener::bind(path).map_err(failed)?;
        listener.set_nonblocking(true).map_err(failed)?;
        Ok(Self::Unix { listener, path: path.to_owned() })
    }

    pub(super) fn accept(&self) -> Option<Port> {
        match self {
            Self::Unix { listener, .. } => Port::unix(listener.accept().ok()?.0).ok(),
            Self::Tcp(listener) => Port::tcp(listener.accept().ok()?.0).ok(),
        }
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        if let Self::Unix { path, .. } = self {
            let _ = std::fs::remove_file(path);
        }
    }
}

impl AsFd for Listener {
    fn as_fd(&self) -> BorrowedFd<'_> {
        match self {
            Self::Unix { listener, .. } => listener.as_fd(),
            Self::Tcp(listener) => listener.as_fd(),
        }
    }
}
