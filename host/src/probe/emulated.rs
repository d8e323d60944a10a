//! The log of the gripper's image for QEMU, which comes out by semihosting.

use std::io::{self, Read, Seek, SeekFrom};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

use super::board::image_of;
use super::{Image, Log, ProbeError};

/// The board that QEMU is.
pub const BOARD: &str = "mps2";

/// Where `cargo xtask firmware mps2` puts the image, from the repository's root.
pub fn image() -> PathBuf {
    image_of(BOARD)
}

/// Ended when dropped.
struct Qemu(Child);

impl Drop for Qemu {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Boots the image and gives out its log as it comes, bytes and the lines that they complete, for so long, or until QEMU
/// ends or `take` breaks off; nothing is on its bus and nobody on its link.
///
/// # Errors
/// No image; no QEMU, or one that ends by itself; what `take` says.
pub fn log(
    path: &Path,
    longest: Option<Duration>,
    mut take: impl FnMut(&[u8], &[String]) -> io::Result<ControlFlow<()>>,
) -> Result<(), ProbeError> {
    let image = Image::read(path, BOARD)?;
    let log = Log::of(&image)?;
    let failed = |doing| move |source| ProbeError::Log { doing, source };
    let mut words = tempfile::tempfile().map_err(failed("read"))?;
    let mut command = Command::new("qemu-system-arm");
    command.args([
        "-machine",
        "mps2-an500",
        "-display",
        "none",
        "-monitor",
        "none",
        "-serial",
        "null",
        "-serial",
        "null",
    ]);
    command.args(["-semihosting-config", "enable=on,target=native", "-kernel"]).arg(path);
    command.stdin(Stdio::null()).stdout(Stdio::piped());
    command.stderr(words.try_clone().map_err(failed("read"))?);
    let mut qemu = Qemu(command.spawn().map_err(ProbeError::NoQemu)?);

    let (sender, received) = channel();
    if let Some(mut output) = qemu.0.stdout.take() {
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
    let mut lines = log.lines();
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
                let status = qemu.0.wait().map_err(failed("read"))?;
                if status.success() {
                    return Ok(());
                }
                let mut said = String::new();
                let _ = words.seek(SeekFrom::Start(0)).and_then(|_| words.read_to_string(&mut said));
                let said = if said.trim().is_empty() { "nothing".to_owned() } else { said.trim().to_owned() };
                return Err(ProbeError::QemuEnded { status: status.to_string(), words: said });
            }
        }
        if end.is_some_and(|end| Instant::now() >= end) {
            return Ok(());
        }
    }
}
