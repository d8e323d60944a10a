//! Commissioning: which servos a gripper leads, and how they are set from then on.

use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use dynamixel::{Layout, Model};
use messages::{Difference, Event, FINGERS, Mount, Role, ServoSetup, Settings};

use crate::link::{Link, LinkError, Told};

/// How long a search of the bus may take at all rates.
const SEARCH: Duration = Duration::from_secs(30);
/// How long the servos may take to be found and set up.
const SET_UP: Duration = Duration::from_secs(30);

/// A device on the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Device {
    /// Its address.
    pub id: u8,
    /// Model number.
    pub model: u16,
    /// Version of its firmware.
    pub firmware: u8,
    /// Bits per second.
    pub baud: u32,
}

/// Why nothing was commissioned; the gripper is idle then.
#[derive(Debug, thiserror::Error)]
pub enum CommissionError {
    /// The link, or what the gripper refuses.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// As many fingers as servos are needed.
    #[error("{count} servos are named; allowed is 1 to {FINGERS}, one per finger")]
    Count {
        /// How many.
        count: usize,
    },
    /// The search did not end.
    #[error("the search of the bus has not ended after {} s", SEARCH.as_secs())]
    Search,
    /// A servo is not one that can be controlled.
    #[error("finger {finger}: {difference}")]
    Differs {
        /// Whose.
        finger: u8,
        /// In what.
        difference: Difference,
    },
    /// No servo of this address.
    #[error("finger {finger}: no servo with id {id} was found and set up within {} s", SET_UP.as_secs())]
    NotFound {
        /// Whose.
        finger: u8,
        /// Its address.
        id: u8,
    },
    /// What is read back is something else.
    #[error("the gripper's settings are not what was sent: does something else set it?")]
    NotKept,
}

/// Searches the bus at every rate. Nothing is written to any device.
///
/// # Errors
/// A refusal (a finger grips), or a search that does not end.
pub fn devices(link: &Link) -> Result<Vec<Device>, CommissionError> {
    let told = link.listen();
    link.scan()?;
    let end = Instant::now() + SEARCH;
    let mut found = Vec::new();
    loop {
        match event(&told, end) {
            Some(Event::DeviceFound { id, model, firmware, baud, .. }) => {
                found.push(Device { id, model, firmware, baud });
            }
            Some(Event::ScanDone { .. }) => return Ok(found),
            Some(_) => {}
            None => return Err(CommissionError::Search),
        }
    }
}

/// Makes the gripper the master of these servos, a finger each, and keeps how they are set. Servos without torque are set to position control
/// (with `current_fence` to current-based position control, in which they limit their current by themselves) and to answer at once, and hold
/// where they are. Mounts that there are stay but for their servo.
///
/// # Errors
/// A servo that is not there or cannot be controlled: the gripper is idle then.
pub fn commission(link: &Link, servos: &[u8], current_fence: bool) -> Result<Vec<ServoSetup>, CommissionError> {
    if !(1..=FINGERS).contains(&servos.len()) {
        return Err(CommissionError::Count { count: servos.len() });
    }
    let mut settings = link.settings()?;
    for (number, place) in settings.fingers.iter_mut().enumerate() {
        let mount = place.unwrap_or(Mount::DEFAULT);
        *place = servos.get(number).map(|&servo_id| Mount { servo_id, servo: None, current_fence, ..mount });
    }
    // Every servo is looked for anew.
    link.set_settings(&Settings { role: Role::Idle, ..settings })?;
    settings.role = Role::Master;
    let told = link.listen();
    link.set_settings(&settings)?;
    let found = wait(&told, servos).and_then(|()| keep(link, settings));
    if found.is_err() {
        link.set_settings(&Settings { role: Role::Idle, ..settings })?;
    }
    found
}

/// Waits until every servo is set up.
fn wait(told: &Receiver<Told>, servos: &[u8]) -> Result<(), CommissionError> {
    let end = Instant::now() + SET_UP;
    let mut ready = vec![false; servos.len()];
    while let Some(missing) = ready.iter().position(|ready| !ready) {
        match event(told, end) {
            Some(Event::ServoReady { finger, .. }) => {
                ready.iter_mut().skip(usize::from(finger)).take(1).for_each(|ready| *ready = true);
            }
            // What the gripper puts right by itself is found so a moment later.
            Some(Event::ServoDiffers { finger, difference }) if !difference.field.is_mended() => {
                return Err(CommissionError::Differs { finger, difference });
            }
            Some(_) => {}
            None => return Err(CommissionError::NotFound { finger: missing as u8, id: servos[missing] }),
        }
    }
    Ok(())
}

/// Keeps how the servos are set, and reads it back.
fn keep(link: &Link, mut settings: Settings) -> Result<Vec<ServoSetup>, CommissionError> {
    let mut setups = Vec::new();
    for (number, mount) in settings.fingers.iter_mut().flatten().enumerate() {
        let (finger, id) = (number as u8, mount.servo_id);
        let setup = link.servo(finger)?.ok_or(CommissionError::NotFound { finger, id })?;
        mount.servo = Some(setup);
        if Model::of(setup.model).is_some_and(|model| model.layout == Layout::P) && mount.zero == Mount::DEFAULT.zero {
            // The middle of its revolution is 0.
            mount.zero = 0.0;
        }
        setups.push(setup);
    }
    link.set_settings(&settings)?;
    if link.settings()? == settings { Ok(setups) } else { Err(CommissionError::NotKept) }
}

/// The next event, if one comes in time.
fn event(told: &Receiver<Told>, end: Instant) -> Option<Event> {
    loop {
        match told.recv_timeout(end.saturating_duration_since(Instant::now())) {
            Ok(Told::Event(notice)) => return Some(notice.event),
            Ok(_) => {}
            Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => return None,
        }
    }
}
