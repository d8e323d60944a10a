//! The gripper's firmware in QEMU (mps2-an500, Cortex-M7): its bus and its link are sockets on which this program listens.
//!
//! The sockets are there before QEMU starts, so that not one of the firmware's first bytes is lost. QEMU gets a process
//! group of its own: Ctrl-C ends the demonstration, which then ends QEMU.

use std::fs::{self, File, Permissions};
use std::io::Write;
use std::os::unix::fs::PermissionsExt;
use std::os::unix::net::UnixListener;
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use tempfile::TempDir;

use super::error::DemoError;
use crate::link::{Link, LinkError};
use crate::servo::{Handle, Hub, Running, Servo};

/// How long QEMU may take to start.
const BOOT: Duration = Duration::from_secs(20);
/// How often is looked whether it has.
const GLANCE: Duration = Duration::from_millis(10);

/// How QEMU's time passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// As fast as it can; costs are wall time and say nothing about a chip.
    Free,
    /// An instruction takes 2^shift ns; costs are counts of instructions.
    Counted {
        /// 0 to 10.
        shift: u8,
    },
}

impl Pace {
    /// Instructions per tick of a clock of so many ticks a second; none if they are not counted.
    pub fn instructions_per_tick(self, clock_hz: u32) -> Option<f64> {
        match self {
            Self::Free => None,
            Self::Counted { shift } => Some(1e9 / f64::from(clock_hz.max(1)) / f64::from(1_u32 << shift.min(31))),
        }
    }
}

/// A running gripper; ended when dropped.
pub struct Machine {
    qemu: Child,
    heir: Option<Heir>,
    /// The servo, from outside.
    pub servo: Handle,
    bus: Running,
    folder: TempDir,
}

impl Machine {
    /// Boots the firmware with a servo on its bus; `log` takes the firmware's log (defmt frames).
    ///
    /// # Errors
    /// QEMU is missing, or ends, or does not connect in time; no sockets or files; `stop` is set.
    pub fn boot(
        firmware: &Path,
        servo: Servo,
        log: &Path,
        pace: Pace,
        stop: &AtomicBool,
    ) -> Result<(Self, Link), DemoError> {
        if !firmware.is_file() {
            return Err(DemoError::Firmware(firmware.to_owned()));
        }
        let folder = folder()?;
        let mut hub = Hub::new();
        hub.listen_unix(&folder.path().join("bus"))?;
        let servo = hub.servo(servo);
        let bus = hub.spawn()?;
        let link = folder.path().join("link");
        let listener = UnixListener::bind(&link).map_err(DemoError::file(&link))?;
        listener.set_nonblocking(true).map_err(DemoError::System)?;

        let mut command = Command::new("qemu-system-arm");
        command.args(["-machine", "mps2-an500", "-display", "none", "-monitor", "none"]);
        command.args(["-semihosting-config", "enable=on,target=native"]);
        if let Pace::Counted { shift } = pace {
            command.args(["-icount", &format!("shift={shift}")]);
        }
        for name in ["bus", "link"] {
            let socket = format!("socket,id={name},path={}", folder.path().join(name).display());
            command.args(["-chardev", &socket, "-serial", &format!("chardev:{name}")]);
        }
        let create = |path: &Path| File::create(path).map_err(DemoError::file(path));
        let words = folder.path().join("words");
        command.arg("-kernel").arg(firmware).process_group(0);
        command.stdin(Stdio::null()).stdout(create(log)?).stderr(create(&words)?);
        // It waits before QEMU starts, and learns its number at once: there is hardly a moment to be killed between.
        let mut heir = Heir::new(folder.path())?;
        let qemu = command.spawn().map_err(DemoError::NoQemu)?;
        let told = heir.learn(&qemu);
        // From here on dropping ends QEMU.
        let mut machine = Self { qemu, heir: Some(heir), servo, bus, folder };
        told?;

        let end = Instant::now() + BOOT;
        let stream = loop {
            match listener.accept() {
                Ok((stream, _)) => break stream,
                Err(error) if error.kind() == std::io::ErrorKind::WouldBlock => {}
                Err(error) => return Err(DemoError::System(error)),
            }
            machine.check()?;
            if stop.load(Ordering::Relaxed) {
                return Err(DemoError::Stopped);
            }
            if Instant::now() > end {
                return Err(machine.timeout("connection from QEMU", BOOT));
            }
            std::thread::sleep(GLANCE);
        };
        let link = Link::over_stream(stream)?;
        Ok((machine, link))
    }

    /// That QEMU still runs.
    ///
    /// # Errors
    /// It does not; with its words.
    pub fn check(&mut self) -> Result<(), DemoError> {
        match self.qemu.try_wait() {
            Ok(None) => Ok(()),
            Ok(Some(status)) => Err(DemoError::QemuEnded { status: status.to_string(), words: self.words() }),
            Err(error) => Err(DemoError::System(error)),
        }
    }

    /// An error for something that did not happen: that QEMU has ended, if so, else that the time is up.
    pub fn timeout(&mut self, what: &'static str, waited: Duration) -> DemoError {
        self.check().err().unwrap_or_else(|| DemoError::Timeout {
            what,
            waited,
            hint: match self.words().as_str() {
                "nothing" => String::new(),
                words => format!("; QEMU said:\n{words}"),
            },
        })
    }

    /// An error of the link: that QEMU has ended, if that is behind it.
    pub fn blame(&mut self, error: LinkError) -> DemoError {
        // QEMU closes its sockets a little before its end can be seen.
        std::thread::sleep(10 * GLANCE);
        self.check().err().unwrap_or(DemoError::Link(error))
    }

    /// Bytes that were lost on the bus because QEMU did not take them.
    pub fn lost_on_bus(&self) -> u64 {
        self.bus.lost()
    }

    fn words(&self) -> String {
        let words = fs::read(self.folder.path().join("words")).unwrap_or_default();
        let words = String::from_utf8_lossy(&words);
        let lines: Vec<&str> = words.trim().lines().collect();
        match lines.as_slice() {
            [] => "nothing".to_owned(),
            // Registers, mostly, between what happened and where.
            all if all.len() > 20 => {
                format!("{}\n…\n{}", all[..8].join("\n"), all[all.len() - 8..].join("\n"))
            }
            all => all.join("\n"),
        }
    }
}

impl Drop for Machine {
    fn drop(&mut self) {
        // The heir first: it must not end another process that has got QEMU's number.
        drop(self.heir.take());
        let _ = self.qemu.kill();
        let _ = self.qemu.wait();
    }
}

/// Ends QEMU and removes the folder if this program is killed: a shell that waits for the end of its standard input.
struct Heir(Child);

impl Heir {
    fn new(folder: &Path) -> Result<Self, DemoError> {
        let mut shell = Command::new("/bin/sh");
        shell.args(["-c", "read qemu; read _; kill -9 $qemu; /bin/rm -r \"$0\""]).arg(folder);
        shell.process_group(0).stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::null());
        Ok(Self(shell.spawn().map_err(DemoError::System)?))
    }

    /// Learns whom it ends.
    fn learn(&mut self, qemu: &Child) -> Result<(), DemoError> {
        let input = self.0.stdin.as_mut().ok_or(std::io::ErrorKind::BrokenPipe);
        input.map_err(Into::into).and_then(|input| writeln!(input, "{}", qemu.id())).map_err(DemoError::System)
    }
}

impl Drop for Heir {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A folder for sockets, for this user only, removed when dropped. (A socket's path is 107 bytes at most: not in the
/// report's folder.)
fn folder() -> Result<TempDir, DemoError> {
    let own = Permissions::from_mode(0o700);
    let made = tempfile::Builder::new().prefix("fre-demo-").permissions(own).tempdir();
    made.map_err(DemoError::file(&std::env::temp_dir()))
}
