//! Joins a virtual machine's two UARTs to each other.
//!
//! QEMU connects to us, not to itself: as a client it is connected before the machine starts; as a server it would throw away what
//! the program sends before it gets round to accepting.

use anyhow::{Context, Result};
use fre_qemu::Uart;
use std::io::{self, ErrorKind};
use std::os::linux::net::SocketAddrExt;
use std::os::unix::net::{SocketAddr, UnixListener, UnixStream};
use std::thread;

/// A socket that waits for the two UARTs. Its name has no file and goes with the process.
pub struct Crossing {
    name: String,
    listener: UnixListener,
    first: Option<UnixStream>,
}

impl Crossing {
    /// Opens the socket; the name must be unique on this machine.
    pub fn new(name: String) -> Result<Self> {
        let address = SocketAddr::from_abstract_name(&name)?;
        let listener = UnixListener::bind_addr(&address).with_context(|| format!("cannot open the socket `{name}`"))?;
        listener.set_nonblocking(true)?;
        Ok(Self { name, listener, first: None })
    }

    /// What QEMU's UARTs, both of them, connect to.
    pub fn uart(&self) -> Uart {
        Uart::ConnectedByName(self.name.clone())
    }

    /// Takes a UART that has come meanwhile; never waits. Bytes flow once both are there, until QEMU ends.
    pub fn attend(&mut self) -> io::Result<()> {
        loop {
            let stream = match self.listener.accept() {
                Ok((stream, _)) => stream,
                Err(error) if error.kind() == ErrorKind::WouldBlock => return Ok(()),
                Err(error) => return Err(error),
            };
            stream.set_nonblocking(false)?;
            match self.first.take() {
                None => self.first = Some(stream),
                Some(first) => {
                    pass_on(first.try_clone()?, stream.try_clone()?);
                    pass_on(stream, first);
                }
            }
        }
    }
}

fn pass_on(mut from: UnixStream, mut to: UnixStream) {
    // Ends with the machine: either side's error means that QEMU has gone.
    thread::spawn(move || io::copy(&mut from, &mut to));
}
