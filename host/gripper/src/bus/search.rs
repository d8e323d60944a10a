//! Lists every servo on the bus, with its baud rate.

use dynamixel::{Found, Id, Master, StatusReturn, Timing};

use super::address::BusAddress;
use super::error::BusError;
use super::port::{Clock, Fault, Line};
use crate::link::Address;

/// A bus's master; the longest answer to one question of ours takes 60 bytes.
pub(super) type Asker = Master<Line, Clock, 256>;
/// Why it got nothing.
pub(super) type AskError = dynamixel::Error<Fault>;

/// Rates in the order in which they are tried: those that carry an estimator, then the factory's, then what else the X series
/// knows.
const RATES: [u32; 7] = [1_000_000, 57_600, 3_000_000, 4_000_000, 2_000_000, 115_200, 9_600];
/// What is allowed beyond the wire time at first: the longest return delay (508 µs), an adapter that keeps bytes for 16 ms,
/// and a PC that is busy.
const FIRST_LATENCY_US: u32 = 60_000;

/// How long the master waits at a rate.
pub(super) fn timing(baud_rate: u32, latency_us: u32) -> Timing {
    Timing { baud_rate, latency_us, status_return: StatusReturn::All }
}

/// The servos found, and their rate.
pub(super) struct Census {
    pub(super) baud: u32,
    pub(super) servos: Vec<Found>,
}

/// Looks for these servos, or for any.
pub(super) fn search(
    line: &Line,
    master: &mut Asker,
    address: &BusAddress,
    wanted: Option<&[u8]>,
) -> Result<Census, BusError> {
    let rates: Vec<u32> = match (address.baud, &address.port) {
        (Some(baud), _) => vec![baud],
        (None, Address::Serial { .. }) => RATES.to_vec(),
        // A socket has none.
        (None, _) => vec![RATES[0]],
    };
    for &baud in &rates {
        let servos = at(line, master, address, baud, wanted)?;
        if !servos.is_empty() {
            return complete(line, master, address, Census { baud, servos }, wanted);
        }
    }
    // Nobody at the rate that was named: which would have been right?
    if let (Some(baud), Address::Serial { .. }) = (address.baud, &address.port) {
        for right in RATES.into_iter().filter(|rate| *rate != baud) {
            // Rates that the port does not know are none.
            let Ok(servos) = at(line, master, address, right, wanted) else { continue };
            if !servos.is_empty() {
                let found = servos.iter().map(|servo| servo.id.get()).collect();
                return Err(BusError::WrongBaud { address: address.to_string(), baud, right, found });
            }
        }
    }
    let asked = match wanted {
        Some([one]) => format!("servo {one} was"),
        Some(several) => format!("servos {} were", several.iter().map(u8::to_string).collect::<Vec<_>>().join(", ")),
        None => "everybody was".to_owned(),
    };
    Err(BusError::Silence { address: address.to_string(), asked, rates })
}

/// Who answers at a rate.
fn at(
    line: &Line,
    master: &mut Asker,
    address: &BusAddress,
    baud: u32,
    wanted: Option<&[u8]>,
) -> Result<Vec<Found>, BusError> {
    line.set_baud(baud).map_err(|source| BusError::Baud { address: address.to_string(), baud, source })?;
    master.set_timing(timing(baud, FIRST_LATENCY_US));
    let broken = |source| BusError::Bus { address: address.to_string(), source };
    let Some(wanted) = wanted else { return everybody(line, master).map_err(broken) };
    let mut found = Vec::new();
    for id in wanted.iter().filter_map(|id| Id::new(*id)) {
        match line.run(master.ping(id)) {
            Ok(answer) => found.push(Found { id, identity: answer.value, alert: answer.alert }),
            Err(source @ (AskError::Port(_) | AskError::Closed)) => return Err(broken(source)),
            // Silence, or noise: what a wrong rate looks like.
            Err(_) => {}
        }
    }
    Ok(found)
}

/// Whoever answers a ping to all.
fn everybody(line: &Line, master: &mut Asker) -> Result<Vec<Found>, AskError> {
    let mut found = [None; 253];
    match line.run(master.discover(&mut found)) {
        Ok(_) | Err(AskError::Babble { .. }) => Ok(found.into_iter().flatten().collect()),
        Err(error) => Err(error),
    }
}

/// All that are wanted, or an error that says who is there instead.
fn complete(
    line: &Line,
    master: &mut Asker,
    address: &BusAddress,
    census: Census,
    wanted: Option<&[u8]>,
) -> Result<Census, BusError> {
    let has = |id: &u8| census.servos.iter().any(|servo| servo.id.get() == *id);
    let missing: Vec<u8> = wanted.unwrap_or_default().iter().filter(|id| !has(id)).copied().collect();
    if missing.is_empty() {
        return Ok(census);
    }
    let found = everybody(line, master).unwrap_or(census.servos);
    let found = found.iter().map(|servo| servo.id.get()).collect();
    Err(BusError::Missing { address: address.to_string(), baud: census.baud, missing, found })
}

/// What keeps the adapter's bytes back, ms, if the system reports it.
pub(super) fn latency_timer_ms(address: &Address) -> Option<u32> {
    let Address::Serial { path, .. } = address else { return None };
    // By-id names are links to the port.
    let name = std::fs::canonicalize(path).ok()?.file_name()?.to_owned();
    let file = std::path::Path::new("/sys/bus/usb-serial/devices").join(name).join("latency_timer");
    std::fs::read_to_string(file).ok()?.trim().parse().ok()
}
