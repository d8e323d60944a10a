//! Where a gripper is: `unix:PATH`, `tcp:HOST:PORT`, or the path of a serial port.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

/// Where a gripper is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Address {
    /// A unix socket on which it listens.
    Unix(PathBuf),
    /// A TCP address on which it listens, HOST:PORT.
    Tcp(String),
    /// A serial port or pseudo-terminal.
    Serial {
        /// Its path.
        path: PathBuf,
        /// Bits per second.
        baud: u32,
    },
}

/// Why words are not an address.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{words}` is not a link: {why}; allowed are unix:PATH, tcp:HOST:PORT, PORT and PORT@BAUD")]
pub struct BadAddress {
    words: String,
    why: &'static str,
}

/// Bits per second of a serial port if the address has none.
const BAUD: u32 = 1_000_000;

impl FromStr for Address {
    type Err = BadAddress;

    fn from_str(words: &str) -> Result<Self, BadAddress> {
        let bad = |why| BadAddress { words: words.to_owned(), why };
        if let Some(path) = words.strip_prefix("unix:") {
            return if path.is_empty() { Err(bad("the path is missing")) } else { Ok(Self::Unix(path.into())) };
        }
        if let Some(address) = words.strip_prefix("tcp:") {
            let port = address.rsplit_once(':').and_then(|(host, port)| (!host.is_empty()).then_some(port));
            let port = port.ok_or_else(|| bad("host or port is missing"))?;
            port.parse::<u16>().map_err(|_| bad("the port is not a number from 0 to 65535"))?;
            return Ok(Self::Tcp(address.to_owned()));
        }
        let (path, baud) = match words.rsplit_once('@') {
            Some((path, baud)) => (path, baud.parse().map_err(|_| bad("the baud rate is not a number"))?),
            None => (words, BAUD),
        };
        if path.is_empty() {
            return Err(bad("the path is missing"));
        }
        Ok(Self::Serial { path: path.into(), baud })
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unix(path) => write!(f, "unix:{}", path.display()),
            Self::Tcp(address) => write!(f, "tcp:{address}"),
            Self::Serial { path, baud } => write!(f, "{}@{baud}", path.display()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_is_told_apart() {
        let read = |words: &str| words.parse::<Address>();
        assert_eq!(read("unix:a/b"), Ok(Address::Unix("a/b".into())));
        assert_eq!(read("tcp:localhost:7000"), Ok(Address::Tcp("localhost:7000".into())));
        assert_eq!(read("/dev/ttyACM0"), Ok(Address::Serial { path: "/dev/ttyACM0".into(), baud: 1_000_000 }));
        assert_eq!(read("COM@115200"), Ok(Address::Serial { path: "COM".into(), baud: 115_200 }));
    }

    #[test]
    fn nonsense_is_explained() {
        for words in ["", "unix:", "tcp:", "tcp:7000", "tcp::7000", "tcp:host:70000", "@1", "/dev/tty@fast"] {
            let error = words.parse::<Address>().unwrap_err().to_string();
            assert!(error.contains(&format!("`{words}`")) && error.contains("allowed are"), "{error}");
        }
    }
}
