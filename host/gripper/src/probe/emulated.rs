//! The log of the gripper's image for QEMU, which comes out by semihosting.

use std::io::{self, Read};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

use fre_log::Line;
pub use fre_qemu::BOARD;
use fre_qemu::{Machine, QemuError};

use super::board::image_of;
use super::{Image, ProbeError};

/// Where `cargo xtask firmware mps2` puts the image, from the repository's root.
pub fn image() -> PathBuf {
    image_of(BOARD)
}

/// Boots the image and gives out its log as it comes, bytes and the lines that they complete, for so long, or until QEMU
/// ends or `take` breaks off; nothing is on its bus and nobody on its link.
///
/// # Errors
/// No image; no QEMU, or one that ends by itself; what `take` says.
pub fn log(
    path: &Path,
    longest: Option<Duration>,
    mut take: impl FnMut(&[u8], &[Line]) -> io::Result<ControlFlow<()>>,
) -> Result<(), ProbeError> {
    let image = Image::read(path, BOARD)?;
    let log = image.log()?;
    let failed = |doing| move |source| ProbeError::Log { doing, source };
    let mut machine = Machine::new(path).boot(Stdio::piped())?;

    let (sender, received) = channel();
    if let Some(mut output) = machine.output() {
        // Ends with QEMU, which ends with this function.
        thread::spawn(move || {
            let mut buffer = [0; 4096];
            while let Ok(count @ 1..) = output.read(&mut buffer) {
                if sender.send(buffer[..count].to_vec()).is_err() {
                    return;
                }
            }
        });
    }
    let end = longest.map(|longest| Instant::now() + longest);
    let mut lines = log.decoder();
    loop {
        let wait = end.map_or(Duration::from_secs(3600), |end| end.saturating_duration_since(Instant::now()));
        match received.recv_timeout(wait) {
            Ok(bytes) => {
                if take(&bytes, &lines.feed(&bytes)).map_err(failed("written"))?.is_break() {
                    return Ok(());
                }
            }
            Err(RecvTimeoutError::Timeout) if end.is_none() => {}
            Err(RecvTimeoutError::Timeout) => return Ok(()),
            Err(RecvTimeoutError::Disconnected) => {
                return match machine.end(None, || Ok(()))? {
                    Some(status) if !status.success() => {
                        Err(QemuError::Ended { status: status.to_string(), words: machine.words() }.into())
                    }
                    _ => Ok(()),
                };
            }
        }
        if end.is_some_and(|end| Instant::now() >= end) {
            return Ok(());
        }
    }
}
