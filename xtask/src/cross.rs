//! Which toolchain builds for the microcontroller, and the environment it needs.
//!
//! Choice, in this order: the active toolchain if its sysroot has the target's libraries; Debian's `rustc-web` with a sysroot that
//! `cargo xtask setup` built once. (Setup may make the first one true by asking rustup, where that is allowed.)

use crate::command::{line, output};
use crate::paths;
use anyhow::{Context, Result, bail};
use fre_boards::Board;
use std::env;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The microcontroller's target: Cortex-M4F and M7F, hardware floating point in single precision.
pub const TRIPLE: &str = "thumbv7em-none-eabihf";

/// For a Cortex-M7 whose floating-point unit computes in double precision, as the compiler takes one to be.
const DOUBLE: &str = "-Ctarget-cpu=cortex-m7";

/// Target folder in which a board's image is built. Cargo keeps what it built with other flags under the same names: in one folder, every
/// change from one floating-point unit to the other would build all again.
pub fn board_target(board: &Board) -> PathBuf {
    let folder = paths::boards_target();
    if board.has_double { folder.join("double") } else { folder }
}

/// A toolchain that can build for [`TRIPLE`].
#[derive(Debug, PartialEq)]
pub enum Cross {
    /// The one that runs now.
    Active,
    /// Debian's, with a sysroot of our own for the target's libraries.
    Debian { sysroot: PathBuf },
}

impl Cross {
    /// The toolchain in use.
    ///
    /// # Errors
    /// If there is none: `cargo xtask setup` was not run.
    pub fn find() -> Result<Self> {
        if has_target(&active_sysroot()?) {
            return Ok(Self::Active);
        }
        let sysroot = debian_sysroot();
        if debian_stamp(&sysroot).is_some() {
            return Ok(Self::Debian { sysroot });
        }
        bail!("no toolchain for {TRIPLE}: run `cargo xtask setup`")
    }

    /// `cargo SUBCOMMAND` in the boards' workspace, for the target, into a target folder of its own.
    pub fn cargo(&self, subcommand: &str) -> Command {
        self.cargo_into(&paths::boards_target(), subcommand)
    }

    /// The same for a board's image, into [`board_target`]: for the floating-point unit that its processor has.
    pub fn image_cargo(&self, board: &Board, subcommand: &str) -> Command {
        let mut command = self.cargo_into(&board_target(board), subcommand);
        if board.has_double {
            let flags = [self.flags(), vec![DOUBLE.to_owned()]].concat();
            command.env("CARGO_ENCODED_RUSTFLAGS", flags.join("\x1f"));
        }
        command
    }

    fn cargo_into(&self, folder: &Path, subcommand: &str) -> Command {
        let mut command = self.bare_cargo();
        command.arg(subcommand);
        command.args(["--target", TRIPLE]);
        command.arg("--target-dir").arg(folder);
        command.current_dir(paths::boards());
        command
    }

    /// `cargo` with the right toolchain, nothing inherited from the cargo that runs this program, and paths in the image that do
    /// not depend on where the checkout is (they take room in flash, so sizes would).
    fn bare_cargo(&self) -> Command {
        let mut command = match self {
            Self::Active => {
                // The cargo that runs us, and by PATH or RUSTUP_TOOLCHAIN the rustc that belongs to it.
                let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
                clear_inherited(&mut command);
                command
            }
            Self::Debian { .. } => debian_cargo(),
        };
        // Separated by this character, so that paths may have spaces.
        command.env("CARGO_ENCODED_RUSTFLAGS", self.flags().join("\x1f"));
        command
    }

    /// Flags of the compiler.
    fn flags(&self) -> Vec<String> {
        let mut flags = vec![format!("--remap-path-prefix={}=.", paths::root().display())];
        if let Some(home) = cargo_home() {
            flags.push(format!("--remap-path-prefix={}=cargo", home.display()));
        }
        if let Self::Debian { sysroot } = self {
            flags.push(format!("--sysroot={}", sysroot.display()));
        }
        flags
    }

    /// One line about the compiler, as `rustc --version` says it.
    pub fn rustc_version(&self) -> Result<String> {
        let version = match self {
            Self::Active => output(Command::new("rustc").arg("--version"))?,
            Self::Debian { .. } => output(Command::new("/usr/bin/rustc").arg("--version"))?,
        };
        Ok(version.trim().to_owned())
    }
}

/// Runs a build and returns cargo's messages: what it made, with paths and profiles.
pub fn built(build: &mut Command) -> Result<Vec<serde_json::Value>> {
    build.arg("--message-format=json-render-diagnostics").stderr(Stdio::inherit());
    let messages = build.output().with_context(|| format!("cannot start `{}`", line(build)))?;
    if !messages.status.success() {
        bail!("`{}` failed: {}", line(build), messages.status);
    }
    let text = String::from_utf8_lossy(&messages.stdout);
    Ok(text.lines().filter_map(|line| serde_json::from_str(line).ok()).collect())
}

/// Debian's cargo, with every tool it starts taken from /usr/bin, be it directly or through a rustup proxy.
pub fn debian_cargo() -> Command {
    let mut command = Command::new("/usr/bin/cargo");
    clear_inherited(&mut command);
    let mut path = OsString::from("/usr/bin:");
    path.push(env::var_os("PATH").unwrap_or_default());
    command.env("PATH", path).env("RUSTUP_TOOLCHAIN", "/usr");
    command
}

/// Where setup puts the sysroot it builds.
pub fn debian_sysroot() -> PathBuf {
    paths::target().join("cross/debian")
}

/// What Debian's rustc says of itself, if it is the compiler that built the sysroot.
pub fn debian_stamp(sysroot: &Path) -> Option<String> {
    let stamp = std::fs::read_to_string(sysroot.join("rustc.txt")).ok()?;
    let now = debian_rustc()?;
    let linker = sysroot.join("lib/rustlib").join(host_of(&now)?).join("bin/rust-lld");
    (stamp == now && has_target(sysroot) && linker.exists()).then_some(now)
}

/// `rustc -vV` of Debian's compiler, if it is installed.
pub fn debian_rustc() -> Option<String> {
    output(Command::new("/usr/bin/rustc").arg("-vV")).ok()
}

/// The host triple in what `rustc -vV` says.
pub fn host_of(version: &str) -> Option<&str> {
    version.lines().find_map(|line| line.strip_prefix("host: "))
}

/// Where cargo keeps the sources of dependencies.
fn cargo_home() -> Option<PathBuf> {
    env::var_os("CARGO_HOME").map(PathBuf::from).or_else(|| Some(PathBuf::from(env::var_os("HOME")?).join(".cargo")))
}

/// The active toolchain's sysroot.
pub fn active_sysroot() -> Result<PathBuf> {
    let path = output(Command::new("rustc").args(["--print", "sysroot"])).context("no Rust compiler")?;
    Ok(PathBuf::from(path.trim()))
}

/// Whether a sysroot has `core` for the target.
pub fn has_target(sysroot: &Path) -> bool {
    let folder = sysroot.join("lib/rustlib").join(TRIPLE).join("lib");
    folder
        .read_dir()
        .is_ok_and(|entries| entries.flatten().any(|entry| entry.file_name().to_string_lossy().starts_with("libcore-")))
}

/// Removes what the outer cargo sets for its children; what the user configures (home, network, terminal) stays.
pub fn clear_inherited(command: &mut Command) {
    const KEPT: &[&str] = &[
        "CARGO_HOME",
        "CARGO_NET_",
        "CARGO_HTTP_",
        "CARGO_TERM_",
        "CARGO_REGISTR",
        "CARGO_BUILD_JOBS",
        "CARGO_SOURCE_",
    ];
    for (name, _) in env::vars_os() {
        let name = name.to_string_lossy();
        let inherited = name.starts_with("CARGO")
            || name.starts_with("RUSTC")
            || name.starts_with("RUSTDOC")
            || name == "RUSTFLAGS";
        if inherited && !KEPT.iter().any(|kept| name.starts_with(kept)) {
            command.env_remove(&*name);
        }
    }
}
