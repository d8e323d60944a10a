//! The gripper's firmware in QEMU (mps2-an500, Cortex-M7): its bus and its link are sockets on which this program listens.
//!
//! The sockets are there before QEMU starts, so that not one of the firmware's first bytes is lost. QEMU gets a process
//! group of its own: Ctrl-C ends the demonstration, which then ends QEMU.

use std::fs::{self, File};
use std::os::unix::net::UnixListener;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

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
    /// Ends QEMU if this program is killed: a shell that waits for the end of its standard input.
    heir: Option<Child>,
    /// The servo, from outside.
    pub servo: Handle,
    bus: Running,
    folder: Folder,
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
        let folder = Folder::new()?;
        let mut hub = Hub::new();
        hub.listen_unix(&folder.path("bus"))?;
        let servo = hub.servo(servo);
        let bus = hub.spawn()?;
        let link = folder.path("link");
        let listener = UnixListener::bind(&link).map_err(DemoError::file(&link))?;
        listener.set_nonblocking(true).map_err(DemoError::System)?;

        let mut command = Command::new("qemu-system-arm");
        command.args(["-machine", "mps2-an500", "-display", "none", "-monitor", "none"]);
        command.args(["-semihosting-config", "enable=on,target=native"]);
        if let Pace::Counted { shift } = pace {
            command.args(["-icount", &format!("shift={shift}")]);
        }
        for name in ["bus", "link"] {
            let socket = format!("socket,id={name},path={}", folder.path(name).display());
            command.args(["-chardev", &socket, "-serial", &format!("chardev:{name}")]);
        }
        let create = |path: &Path| File::create(path).map_err(DemoError::file(path));
        let words = folder.path("words");
        command.arg("-kernel").arg(firmware).process_group(0);
        command.stdin(Stdio::null()).stdout(create(log)?).stderr(create(&words)?);
        let qemu = command.spawn().map_err(DemoError::NoQemu)?;
        // From here on dropping ends QEMU.
        let mut machine = Self { qemu, heir: None, servo, bus, folder };
        let mut heir = Command::new("/bin/sh");
        heir.args(["-c", "read _; kill -9 \"$0\"; /bin/rm -r \"$1\"", &machine.qemu.id().to_string()]);
        heir.arg(&machine.folder.0).process_group(0).stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::null());
        machine.heir = Some(heir.spawn().map_err(DemoError::System)?);

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
        let words = fs::read(self.folder.path("words")).unwrap_or_default();
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
        for child in self.heir.as_mut().into_iter().chain([&mut self.qemu]) {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// A folder for sockets, for this user only, removed when dropped. (A socket's path is 107 bytes at most: not in the
/// report's folder.)
struct Folder(PathBuf);

impl Folder {
    fn new() -> Result<Self, DemoError> {
        use std::os::unix::fs::DirBuilderExt;
        let base = std::env::temp_dir();
        for number in 0..100 {
            let path = base.join(format!("fre-demo-{}-{number}", std::process::id()));
            match fs::DirBuilder::new().mode(0o700).create(&path) {
                Ok(()) => return Ok(Self(path)),
                Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => {}
                Err(source) => return Err(DemoError::File { path, source }),
            }
        }
        Err(DemoError::File { path: base, source: std::io::ErrorKind::AlreadyExists.into() })
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}
