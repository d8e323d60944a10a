//! A bus with another master on it: whoever leads the servos opens a pseudo-terminal, and what the gripper says is counted.

use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::spawn;

/// Another master's end of the bus.
pub struct SharedBus {
    /// The serial port for the other master.
    pub port: PathBuf,
    pub(crate) said: Arc<AtomicU64>,
}

impl SharedBus {
    /// Bytes that the gripper has sent so far.
    pub fn said(&self) -> u64 {
        self.said.load(Ordering::SeqCst)
    }
}

/// Carries bytes between the gripper and the bus until one of them ends; counts what the gripper says.
pub(crate) fn carry(gripper: UnixStream, bus: UnixStream, said: Arc<AtomicU64>) -> std::io::Result<()> {
    let (mut from_bus, mut to_gripper) = (bus.try_clone()?, gripper.try_clone()?);
    let (mut from_gripper, mut to_bus) = (gripper, bus);
    spawn(move || std::io::copy(&mut from_bus, &mut to_gripper));
    spawn(move || {
        let mut chunk = [0; 256];
        while let Ok(count @ 1..) = from_gripper.read(&mut chunk) {
            said.fetch_add(count as u64, Ordering::SeqCst);
            if to_bus.write_all(&chunk[..count]).is_err() {
                break;
            }
        }
    });
    Ok(())
}
