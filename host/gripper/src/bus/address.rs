//! Where a bus is: the path of a serial port, with or without its baud rate; or a socket.

use std::fmt;
use std::str::FromStr;

use crate::link::{Address, BadAddress};

/// Where a bus is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BusAddress {
    pub(super) port: Address,
    /// Bits per second; none: those that servos know are tried.
    pub(super) baud: Option<u32>,
}

impl FromStr for BusAddress {
    type Err = BadAddress;

    fn from_str(words: &str) -> Result<Self, BadAddress> {
        let port = words.parse()?;
        let baud = match &port {
            Address::Serial { baud, .. } => words.contains('@').then_some(*baud),
            Address::Unix(_) | Address::Tcp(_) => None,
        };
        Ok(Self { port, baud })
    }
}

impl fmt::Display for BusAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.port {
            Address::Serial { path, .. } => write!(f, "{}", path.display()),
            socket => socket.fmt(f),
        }
    }
}
