//! The bytes below the link: a socket or a serial port, read with a limit to the wait.

use std::fs::File;
use std::io::{self, ErrorKind, Read, Write};
use std::net::TcpStream;
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{Mode, OFlags, open};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

use super::{Address, LinkError};

/// How long a write may wait for a gripper that takes nothing.
const PATIENCE: Duration = Duration::from_secs(3);

/// One end of the link; both halves are clones of it.
#[derive(Debug)]
pub(crate) enum Port {
    Unix(UnixStream),
    Tcp(TcpStream),
    Serial(File),
}

impl Port {
    pub(super) fn open(address: &Address) -> Result<Self, LinkError> {
        Self::connect(address).map_err(|source| LinkError::Open { address: address.clone(), source })
    }

    pub(crate) fn connect(address: &Address) -> io::Result<Self> {
        match address {
            Address::Unix(path) => UnixStream::connect(path).and_then(Self::unix),
            Address::Tcp(address) => TcpStream::connect(address).and_then(|stream| {
                stream.set_nodelay(true)?;
                stream.set_nonblocking(true)?;
                Ok(Self::Tcp(stream))
            }),
            Address::Serial { path, baud } => serial(path, *baud).map(Self::Serial),
        }
    }

    pub(super) fn unix(stream: UnixStream) -> io::Result<Self> {
        stream.set_nonblocking(true)?;
        Ok(Self::Unix(stream))
    }

    pub(super) fn try_clone(&self) -> io::Result<Self> {
        Ok(match self {
            Self::Unix(stream) => Self::Unix(stream.try_clone()?),
            Self::Tcp(stream) => Self::Tcp(stream.try_clone()?),
            Self::Serial(file) => Self::Serial(file.try_clone()?),
        })
    }

    /// Waits a while for bytes: `None` if there are none yet, 0 at the end.
    pub(crate) fn receive(&mut self, into: &mut [u8], longest: Duration) -> io::Result<Option<usize>> {
        if !self.wait(PollFlags::IN, longest) {
            return Ok(None);
        }
        let result = match self {
            Self::Unix(stream) => stream.read(into),
            Self::Tcp(stream) => stream.read(into),
            Self::Serial(file) => file.read(into),
        };
        match result {
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => Ok(None),
            result => result.map(Some),
        }
    }

    /// Writes all of it, or says why not.
    pub(crate) fn send(&mut self, mut bytes: &[u8]) -> io::Result<()> {
        while !bytes.is_empty() {
            let result = match self {
                Self::Unix(stream) => stream.write(bytes),
                Self::Tcp(stream) => stream.write(bytes),
                Self::Serial(file) => file.write(bytes),
            };
            match result {
                Ok(0) => return Err(ErrorKind::WriteZero.into()),
                Ok(count) => bytes = &bytes[count..],
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) if error.kind() == ErrorKind::WouldBlock => {
                    if !self.wait(PollFlags::OUT, PATIENCE) {
                        return Err(io::Error::new(ErrorKind::TimedOut, "the other end takes nothing"));
                    }
                }
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    /// Changes the rate; a socket has none.
    pub(crate) fn set_baud(&self, baud: u32) -> io::Result<()> {
        if let Self::Serial(file) = self {
            let mut settings = tcgetattr(file)?;
            settings.set_speed(baud)?;
            tcsetattr(file, OptionalActions::Flush, &settings)?;
        }
        Ok(())
    }

    /// Waits until there are bytes to read, at most so long.
    pub(crate) fn wait_for_bytes(&self, longest: Duration) {
        self.wait(PollFlags::IN, longest);
    }

    fn wait(&self, what: PollFlags, longest: Duration) -> bool {
        let longest = Timespec { tv_sec: longest.as_secs() as i64, tv_nsec: i64::from(longest.subsec_nanos()) };
        let mut watched = [PollFd::new(self, what)];
        // An interrupted wait is a short one.
        let _ = poll(&mut watched, Some(&longest));
        !watched[0].revents().is_empty()
    }
}

/// A serial port, raw, at a rate. A pseudo-terminal ignores the rate.
fn serial(path: &std::path::Path, baud: u32) -> io::Result<File> {
    let file = open(path, OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC, Mode::empty())?;
    let mut settings = tcgetattr(&file)?;
    settings.make_raw();
    settings.set_speed(baud)?;
    tcsetattr(&file, OptionalActions::Flush, &settings)?;
    Ok(File::from(file))
}

impl AsFd for Port {
    fn as_fd(&self) -> BorrowedFd<'_> {
        match self {
            Self::Unix(stream) => stream.as_fd(),
            Self::Tcp(stream) => stream.as_fd(),
            Self::Serial(file) => file.as_fd(),
        }
    }
}
