//! The bytes below the link: a socket or a serial port, read with a limit to the wait.

use std::fmt;
use std::io::{self, ErrorKind, Read, Write};
use std::net::TcpStream;
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use serialport::{ClearBuffer, SerialPort};

use super::{Address, LinkError};

/// How long a write may wait for a gripper that takes nothing.
const PATIENCE: Duration = Duration::from_secs(3);
/// Bytes that a wait on a serial port takes in.
const CHUNK: usize = 256;

/// One end of the link; both halves are clones of it.
#[derive(Debug)]
pub(crate) enum Port {
    Unix(UnixStream),
    Tcp(TcpStream),
    Serial(Serial),
}

/// A serial port, raw. A pseudo-terminal ignores the rate.
pub(crate) struct Serial {
    port: Box<dyn SerialPort>,
    /// What came while bytes were only waited for: the library has no wait that leaves them where they are.
    ahead: Vec<u8>,
}

impl fmt::Debug for Serial {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Serial").field("name", &self.port.name()).field("ahead", &self.ahead.len()).finish()
    }
}

impl Serial {
    fn open(path: &str, baud: u32) -> io::Result<Self> {
        let port = serialport::new(path, baud).timeout(PATIENCE).open()?;
        // What an earlier program left unread does not answer anything here.
        port.clear(ClearBuffer::All)?;
        Ok(Self { port, ahead: Vec::new() })
    }

    /// Reads what is there, or comes in time: `None` if nothing does, 0 if the other end is gone.
    fn receive(&mut self, into: &mut [u8], longest: Duration) -> io::Result<Option<usize>> {
        if !self.ahead.is_empty() {
            let count = self.ahead.len().min(into.len());
            into.iter_mut().zip(self.ahead.drain(..count)).for_each(|(to, byte)| *to = byte);
            return Ok(Some(count));
        }
        self.port.set_timeout(longest)?;
        match self.port.read(into) {
            Ok(count) => Ok(Some(count)),
            Err(error) => match error.kind() {
                ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted => Ok(None),
                ErrorKind::BrokenPipe => Ok(Some(0)),
                _ => Err(error),
            },
        }
    }

    /// Waits for bytes, which the next [`Self::receive`] gives. What goes wrong, it says then.
    fn wait(&mut self, longest: Duration) {
        let mut chunk = [0; CHUNK];
        if self.ahead.is_empty()
            && let Ok(Some(count)) = self.receive(&mut chunk, longest)
        {
            self.ahead.extend_from_slice(&chunk[..count]);
        }
    }
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
            Address::Serial { path, baud } => Serial::open(&path.to_string_lossy(), *baud).map(Self::Serial),
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
            Self::Serial(serial) => Self::Serial(Serial { port: serial.port.try_clone()?, ahead: Vec::new() }),
        })
    }

    /// Waits a while for bytes: `None` if there are none yet, 0 at the end.
    pub(crate) fn receive(&mut self, into: &mut [u8], longest: Duration) -> io::Result<Option<usize>> {
        if self.socket().is_some_and(|socket| !wait(socket, PollFlags::IN, longest)) {
            return Ok(None);
        }
        let result = match self {
            Self::Serial(serial) => return serial.receive(into, longest),
            Self::Unix(stream) => stream.read(into),
            Self::Tcp(stream) => stream.read(into),
        };
        match result {
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => Ok(None),
            result => result.map(Some),
        }
    }

    /// Writes all of it, or says why not.
    pub(crate) fn send(&mut self, mut bytes: &[u8]) -> io::Result<()> {
        let full = || io::Error::new(ErrorKind::TimedOut, "the other end takes nothing");
        while !bytes.is_empty() {
            let result = match self {
                Self::Unix(stream) => stream.write(bytes),
                Self::Tcp(stream) => stream.write(bytes),
                Self::Serial(serial) => {
                    serial.port.set_timeout(PATIENCE).map_err(io::Error::from).and_then(|()| serial.port.write(bytes))
                }
            };
            match (result, self.socket()) {
                (Ok(0), _) => return Err(ErrorKind::WriteZero.into()),
                (Ok(count), _) => bytes = &bytes[count..],
                (Err(error), _) if error.kind() == ErrorKind::Interrupted => {}
                (Err(error), Some(socket)) if error.kind() == ErrorKind::WouldBlock => {
                    if !wait(socket, PollFlags::OUT, PATIENCE) {
                        return Err(full());
                    }
                }
                // The library has waited already.
                (Err(error), None) if error.kind() == ErrorKind::TimedOut => return Err(full()),
                (Err(error), _) => return Err(error),
            }
        }
        Ok(())
    }

    /// Changes the rate; a socket has none.
    pub(crate) fn set_baud(&mut self, baud: u32) -> io::Result<()> {
        if let Self::Serial(serial) = self {
            serial.ahead.clear();
            serial.port.set_baud_rate(baud)?;
            serial.port.clear(ClearBuffer::All)?;
        }
        Ok(())
    }

    /// Waits until there are bytes to read, at most so long.
    pub(crate) fn wait_for_bytes(&mut self, longest: Duration) {
        if let Some(socket) = self.socket() {
            wait(socket, PollFlags::IN, longest);
        } else if let Self::Serial(serial) = self {
            serial.wait(longest);
        }
    }

    /// What is waited for; a serial port waits by itself.
    fn socket(&self) -> Option<BorrowedFd<'_>> {
        match self {
            Self::Unix(stream) => Some(stream.as_fd()),
            Self::Tcp(stream) => Some(stream.as_fd()),
            Self::Serial(_) => None,
        }
    }
}

/// Waits until a socket has bytes or room, at most so long; false if it has not. An interrupted wait is a short one.
fn wait(socket: BorrowedFd<'_>, what: PollFlags, longest: Duration) -> bool {
    let longest = Timespec { tv_sec: longest.as_secs() as i64, tv_nsec: i64::from(longest.subsec_nanos()) };
    let mut watched = [PollFd::from_borrowed_fd(socket, what)];
    let _ = poll(&mut watched, Some(&longest));
    !watched[0].revents().is_empty()
}
