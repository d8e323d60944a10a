//! Why there is no bus.

use std::io::{self, ErrorKind};
use std::path::Path;

use messages::Refusal;

use super::port::Fault;

/// Why there is no bus.
#[derive(Debug, thiserror::Error)]
pub enum BusError {
    /// The port cannot be opened.
    #[error("the bus {address} cannot be opened: {source}{}", hint(address, source))]
    Open {
        /// Where it should have been.
        address: String,
        /// The system's words.
        source: io::Error,
    },
    /// The port cannot run at that rate.
    #[error("the bus {address} cannot be set to {baud} baud: {source}")]
    Baud {
        /// Which port.
        address: String,
        /// The rate.
        baud: u32,
        /// The system's words.
        source: io::Error,
    },
    /// Nobody has answered.
    #[error(
        "nobody answers on {address}: {asked} asked at {} baud. Check the servos' power (12 V), the cable (TTL for a T servo), \
         and that no other program uses the port",
        listed(rates)
    )]
    Silence {
        /// Which port.
        address: String,
        /// Who was asked.
        asked: String,
        /// At which rates.
        rates: Vec<u32>,
    },
    /// They answer at another rate than the one that was named.
    #[error(
        "nobody answers on {address} at {baud} baud; at {right} baud these servos do: {}. Name the port {address}@{right}",
        numbers(found)
    )]
    WrongBaud {
        /// Which port.
        address: String,
        /// The rate named.
        baud: u32,
        /// The rate of those that answer.
        right: u32,
        /// Who they are.
        found: Vec<u8>,
    },
    /// Some of the servos are not there.
    #[error(
        "servo {} does not answer on {address} at {baud} baud; those that do: {}",
        numbers(missing),
        numbers(found)
    )]
    Missing {
        /// Which port.
        address: String,
        /// The rate.
        baud: u32,
        /// Who is missing.
        missing: Vec<u8>,
        /// Who answers.
        found: Vec<u8>,
    },
    /// More servos than fingers.
    #[error("{} servos answer on {address}, which are more than {most} fingers: {}; name the fingers' by --set finger.0.servo_id=…", found.len(), numbers(found))]
    Many {
        /// Which port.
        address: String,
        /// The most fingers.
        most: usize,
        /// Who answers.
        found: Vec<u8>,
    },
    /// What answers is not a servo's position.
    #[error("servo {id} on {address} is a model {model}, whose registers are not those of the X series")]
    Model {
        /// Which port.
        address: String,
        /// Which servo.
        id: u8,
        /// Its model number.
        model: u16,
    },
    /// The bus does not work.
    #[error("the bus {address} does not work: {source}")]
    Bus {
        /// Which port.
        address: String,
        /// What the protocol says.
        source: dynamixel::Error<Fault>,
    },
    /// Settings, design or object.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// No thread.
    #[error("the bus cannot be started: {0}")]
    Start(#[source] io::Error),
}

fn listed(rates: &[u32]) -> String {
    rates.iter().map(u32::to_string).collect::<Vec<_>>().join(", ")
}

fn numbers(ids: &[u8]) -> String {
    if ids.is_empty() { "none".to_owned() } else { ids.iter().map(u8::to_string).collect::<Vec<_>>().join(", ") }
}

/// What a person can do about a port that does not open.
fn hint(address: &str, error: &io::Error) -> String {
    match error.kind() {
        ErrorKind::PermissionDenied => {
            "; the user needs the group of the port (on Debian and Ubuntu: sudo usermod -aG dialout $USER, then log in again)"
                .to_owned()
        }
        ErrorKind::NotFound => match ports().as_slice() {
            [] => "; this PC has no USB serial port at all (ttyUSB, ttyACM): is the adapter plugged in?".to_owned(),
            ports => format!("; the USB serial ports are {}", ports.join(", ")),
        },
        _ if Path::new(address).is_file() || Path::new(address).is_dir() => "; it is not a serial port".to_owned(),
        _ => String::new(),
    }
}

/// The USB serial ports of this PC.
fn ports() -> Vec<String> {
    let names = std::fs::read_dir("/dev").into_iter().flatten().flatten().map(|entry| entry.file_name());
    let usb = |name: &String| name.starts_with("ttyUSB") || name.starts_with("ttyACM");
    let mut ports: Vec<String> = names.filter_map(|name| name.into_string().ok()).filter(usb).collect();
    ports.sort();
    ports.iter().map(|name| format!("/dev/{name}")).collect()
}
