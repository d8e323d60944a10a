//! A gripper without hardware: its firmware in QEMU with a simulated servo on its bus, and its link open for everything that talks to a
//! gripper.

use std::io;
use std::path::PathBuf;
use std::process::Stdio;
use std::time::Duration;

use fre_qemu::{Machine, Pace, QemuError, Running as Board, Sockets};
use messages::{Finger, Object, Settings};

use crate::link::{Address, Link, LinkError};
use crate::servo::{Config, ConfigError, Handle, Hub, PortError, Running, Servo};

/// How long QEMU may take to open its sockets.
const BOOT: Duration = Duration::from_secs(20);

/// Why there is no simulated gripper.
#[derive(Debug, thiserror::Error)]
pub enum SimError {
    /// QEMU, or what was waited for in vain.
    #[error(transparent)]
    Qemu(#[from] QemuError),
    /// A folder for the sockets.
    #[error("the system gives no folder for sockets: {0}")]
    Folder(#[source] io::Error),
    /// The servo.
    #[error("the servo: {0}")]
    Servo(#[from] ConfigError),
    /// The bus.
    #[error("the bus: {0}")]
    Bus(#[from] PortError),
    /// The gripper refuses the finger, the object or the settings, or does not answer.
    #[error(transparent)]
    Link(#[from] LinkError),
}

/// What the gripper is given at the start.
#[derive(Clone, Debug)]
pub struct Given {
    /// Its settings.
    pub settings: Settings,
    /// The design of its finger.
    pub finger: Finger,
    /// The finger's object, world frame.
    pub object: Object,
}

/// A gripper that runs until this is dropped.
#[derive(Debug)]
pub struct Sim {
    board: Board,
    servo: Handle,
    bus: Running,
    sockets: Sockets,
}

impl Sim {
    /// Boots a firmware (an ELF for [`fre_qemu::BOARD`]) with this servo. Without anything given, the gripper is as new: idle.
    ///
    /// # Errors
    /// QEMU is missing, ends or does not start in time; a servo that no XM430 can be; a finger for which the gripper has no room.
    pub fn boot(firmware: PathBuf, pace: Pace, servo: Config, given: Option<&Given>) -> Result<Self, SimError> {
        let servo = Servo::new(servo)?;
        let sockets = Sockets::new().map_err(SimError::Folder)?;
        let machine = Machine::new(firmware).pace(pace).listening(&sockets).apart(sockets.folder());
        let mut board = machine.boot(Stdio::null())?;
        let mut hub = Hub::new();
        board.until("connection to the bus", BOOT, || hub.connect_unix(&sockets.bus()))?;
        let servo = hub.servo(servo);
        let mut sim = Self { board, servo, bus: hub.spawn()?, sockets };
        if let Some(given) = given {
            sim.give(given)?;
        }
        Ok(sim)
    }

    /// Where its link is. It has one user at a time, as a serial port has.
    pub fn address(&self) -> Address {
        Address::Unix(self.sockets.link())
    }

    /// The servo, from outside.
    pub fn servo(&self) -> &Handle {
        &self.servo
    }

    /// Bytes that were lost on the bus because QEMU did not take them.
    pub fn lost_on_bus(&self) -> u64 {
        self.bus.lost()
    }

    /// That QEMU still runs.
    ///
    /// # Errors
    /// It does not; with its words.
    pub fn check(&mut self) -> Result<(), SimError> {
        Ok(self.board.check()?)
    }

    fn give(&mut self, given: &Given) -> Result<(), SimError> {
        let link = Link::open_within(&self.address(), BOOT)?;
        let finger = link.set_finger(0, &given.finger);
        let all =
            finger.and_then(|()| link.set_object(0, given.object)).and_then(|()| link.set_settings(&given.settings));
        // QEMU's own words, if it has ended.
        all.map_err(|error| self.board.check_after_close().err().map_or(SimError::Link(error), SimError::Qemu))
    }
}
