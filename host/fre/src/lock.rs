//! Locks of files that several processes may want to write.

use std::fs::{File, TryLockError};
use std::time::{Duration, Instant};

/// How long [`patiently`] waits.
const PATIENCE: Duration = Duration::from_millis(500);

/// Locks a file for as long as it is open. A lock that another process holds is waited for a moment: a child has its parent's
/// between its fork and its exec.
///
/// # Errors
/// Another process holds it ([`TryLockError::WouldBlock`]), or the system's own.
pub fn patiently(file: &File) -> Result<(), TryLockError> {
    let begin = Instant::now();
    loop {
        match file.try_lock() {
            Err(TryLockError::WouldBlock) if begin.elapsed() < PATIENCE => std::thread::sleep(PATIENCE / 50),
            done => return done,
        }
    }
}
