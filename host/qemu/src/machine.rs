//! What is started: image, pace and UARTs, and the command line they make.

use std::ffi::OsString;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::error::QemuError;
use crate::heir::Heir;
use crate::running::Running;
use crate::sockets::Sockets;

/// QEMU's program.
pub const PROGRAM: &str = "qemu-system-arm";
/// The board's name among the firmware's boards.
pub const BOARD: &str = "mps2";

/// How the board's time passes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pace {
    /// As fast as QEMU can; costs are wall time and say nothing about a chip.
    #[default]
    Free,
    /// An instruction takes 2^shift ns; costs are counts of instructions. Waiting takes its time.
    Counted {
        /// 0 to 10.
        shift: u8,
    },
    /// The same, but waiting takes no time: for programs that speak with nobody.
    CountedWithoutWaiting {
        /// 0 to 10.
        shift: u8,
    },
}

impl Pace {
    /// Instructions per tick of a clock of so many ticks a second; none if they are not counted.
    pub fn instructions_per_tick(self, clock_hz: u32) -> Option<f64> {
        match self {
            Self::Free => None,
            Self::Counted { shift } | Self::CountedWithoutWaiting { shift } => {
                Some(1e9 / f64::from(clock_hz.max(1)) / f64::from(1_u32 << shift.min(31)))
            }
        }
    }

    /// QEMU's option.
    fn icount(self) -> Option<String> {
        match self {
            Self::Free => None,
            Self::Counted { shift } => Some(format!("shift={shift}")),
            Self::CountedWithoutWaiting { shift } => Some(format!("shift={shift},sleep=off")),
        }
    }
}

/// What is at the other end of a UART.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Uart {
    /// Nothing.
    Unconnected,
    /// A socket that QEMU opens. The board runs at once: what it sends before a program connects is lost.
    Opened(PathBuf),
    /// A socket on which a program listens already: not one byte is lost.
    Connected(PathBuf),
    /// The same, by a name without a file (Linux's abstract sockets).
    ConnectedByName(String),
}

impl Uart {
    /// Adds a UART to QEMU's command line.
    fn add(&self, id: &str, command: &mut Command) {
        let mut socket = OsString::from(format!("socket,id={id},"));
        match self {
            Self::Unconnected => {
                command.args(["-serial", "null"]);
                return;
            }
            Self::Opened(path) => {
                socket.push("server=on,wait=off,path=");
                socket.push(path);
            }
            Self::Connected(path) => {
                socket.push("path=");
                socket.push(path);
            }
            Self::ConnectedByName(name) => {
                socket.push("abstract=on,path=");
                socket.push(name);
            }
        }
        command.arg("-chardev").arg(socket).args(["-serial", &format!("chardev:{id}")]);
    }
}

/// A virtual board that can be booted.
#[derive(Clone, Debug)]
pub struct Machine {
    image: PathBuf,
    arguments: Vec<String>,
    pace: Pace,
    bus: Uart,
    link: Uart,
    plugin: Option<OsString>,
    monitor: Option<PathBuf>,
    apart: Option<PathBuf>,
}

impl Machine {
    /// A board with this ELF image in its flash, as fast as QEMU can go, with nothing on its UARTs.
    pub fn new(image: impl Into<PathBuf>) -> Self {
        Self {
            image: image.into(),
            arguments: Vec::new(),
            pace: Pace::Free,
            bus: Uart::Unconnected,
            link: Uart::Unconnected,
            plugin: None,
            monitor: None,
            apart: None,
        }
    }

    /// Words that the program can ask for by semihosting.
    #[must_use]
    pub fn arguments(mut self, words: &[&str]) -> Self {
        self.arguments = words.iter().map(|word| (*word).to_owned()).collect();
        self
    }

    /// How its time passes.
    #[must_use]
    pub fn pace(mut self, pace: Pace) -> Self {
        self.pace = pace;
        self
    }

    /// What is on UART 0 (the servos' bus) and on UART 1 (the link).
    #[must_use]
    pub fn uarts(mut self, bus: Uart, link: Uart) -> Self {
        (self.bus, self.link) = (bus, link);
        self
    }

    /// A plugin of QEMU's and its arguments, `name=value` each; no value has a comma.
    #[must_use]
    pub fn plugin(mut self, library: &Path, arguments: &[(&str, &Path)]) -> Self {
        let mut option = library.as_os_str().to_owned();
        for (name, value) in arguments {
            option.push(format!(",{name}="));
            option.push(value);
        }
        self.plugin = Some(option);
        self
    }

    /// QEMU answers on a socket here, which it opens: for [`Running::memory`].
    #[must_use]
    pub fn monitored(mut self, socket: &Path) -> Self {
        self.monitor = Some(socket.to_owned());
        self
    }

    /// QEMU opens both sockets; programs connect when they like.
    #[must_use]
    pub fn listening(self, sockets: &Sockets) -> Self {
        self.uarts(Uart::Opened(sockets.bus()), Uart::Opened(sockets.link()))
    }

    /// QEMU connects to both sockets, on which programs listen already.
    #[must_use]
    pub fn connecting(self, sockets: &Sockets) -> Self {
        self.uarts(Uart::Connected(sockets.bus()), Uart::Connected(sockets.link()))
    }

    /// In a process group of its own: Ctrl-C ends this program, which then ends QEMU. If this program is killed, QEMU ends
    /// too, and the folder is removed.
    #[must_use]
    pub fn apart(mut self, folder: &Path) -> Self {
        self.apart = Some(folder.to_owned());
        self
    }

    /// The command line.
    fn command(&self) -> Command {
        let mut command = Command::new(PROGRAM);
        command.args(["-machine", "mps2-an500", "-display", "none", "-monitor", "none"]);
        let words: String = self.arguments.iter().map(|word| format!(",arg={word}")).collect();
        command.args(["-semihosting-config", &format!("enable=on,target=native{words}")]);
        if let Some(icount) = self.pace.icount() {
            command.args(["-icount", &icount]);
        }
        if let Some(plugin) = &self.plugin {
            command.arg("-plugin").arg(plugin);
        }
        if let Some(monitor) = &self.monitor {
            let mut option = OsString::from("unix:");
            option.push(monitor);
            option.push(",server=on,wait=off");
            command.arg("-qmp").arg(option);
        }
        self.bus.add("bus", &mut command);
        self.link.add("link", &mut command);
        command.arg("-kernel").arg(&self.image).stdin(Stdio::null());
        command
    }

    /// Starts the board. `log` takes what the program writes by semihosting (defmt frames).
    ///
    /// # Errors
    /// No such image; no QEMU; the system gives no process or file.
    pub fn boot(&self, log: impl Into<Stdio>) -> Result<Running, QemuError> {
        if !self.image.is_file() {
            return Err(QemuError::NoImage(self.image.clone()));
        }
        let words = tempfile::tempfile()?;
        let mut command = self.command();
        command.stdout(log).stderr(words.try_clone()?);
        // The heir waits before QEMU starts, and learns its number at once: there is hardly a moment to be killed between.
        let mut heir = match &self.apart {
            None => None,
            Some(folder) => {
                command.process_group(0);
                Some(Heir::new(folder)?)
            }
        };
        let qemu = command.spawn().map_err(QemuError::NoQemu)?;
        let learnt = heir.as_mut().map_or(Ok(()), |heir| heir.learn(&qemu));
        // From here on dropping ends QEMU.
        let running = Running::new(qemu, words, heir, self.monitor.clone());
        learnt?;
        Ok(running)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(machine: &Machine) -> String {
        machine.command().get_args().map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn the_command_line_has_image_pace_arguments_and_uarts() {
        let bare = words(&Machine::new("a.elf"));
        assert!(bare.starts_with("-machine mps2-an500 ") && bare.ends_with("-serial null -serial null -kernel a.elf"));
        assert!(!bare.contains("icount"), "{bare}");
        let machine = Machine::new("a.elf").arguments(&["run_addr", "8"]).pace(Pace::Counted { shift: 2 });
        let machine = machine.plugin(Path::new("p.so"), &[("image", Path::new("a.elf"))]);
        let full = words(&machine.uarts(Uart::Opened("/b".into()), Uart::ConnectedByName("l".into())));
        for part in [
            "enable=on,target=native,arg=run_addr,arg=8",
            "-icount shift=2",
            "-plugin p.so,image=a.elf",
            "-chardev socket,id=bus,server=on,wait=off,path=/b -serial chardev:bus",
            "-chardev socket,id=link,abstract=on,path=l -serial chardev:link",
        ] {
            assert!(full.contains(part), "{part} is missing in {full}");
        }
    }

    #[test]
    fn instructions_per_tick_follow_the_clock() {
        assert_eq!(Pace::Free.instructions_per_tick(25_000_000), None);
        assert_eq!(Pace::Counted { shift: 2 }.instructions_per_tick(25_000_000), Some(10.0));
        assert_eq!(Pace::CountedWithoutWaiting { shift: 6 }.instructions_per_tick(25_000_000), Some(0.625));
    }

    #[test]
    fn an_image_that_is_not_there_is_named() {
        let error = Machine::new("no/such.elf").boot(Stdio::null()).unwrap_err().to_string();
        assert!(error.contains("no/such.elf") && error.contains("cargo xtask firmware mps2"), "{error}");
    }
}
