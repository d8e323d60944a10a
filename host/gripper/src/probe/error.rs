//! Why a board could not be flashed or listened to.

use std::io;
use std::path::PathBuf;

use fre_qemu::QemuError;

/// Why a board could not be flashed or listened to.
#[derive(Debug, thiserror::Error)]
pub enum ProbeError {
    /// The image is not a file.
    #[error("{} cannot be read ({source}); `cargo xtask firmware {board}` builds the image for {board}", path.display())]
    NoImage {
        /// Which file.
        path: PathBuf,
        /// The board it is for.
        board: String,
        /// The system's words.
        source: io::Error,
    },
    /// The image is not an image.
    #[error("{} is not an image for a board: {why}", path.display())]
    BadImage {
        /// Which file.
        path: PathBuf,
        /// What is wrong with it.
        why: String,
    },
    /// The image is another board's.
    #[error("{} is an image for {label}, not for {board}; `cargo xtask firmware {board}` builds the right one", path.display())]
    OtherBoard {
        /// Which file.
        path: PathBuf,
        /// The board.
        board: &'static str,
        /// The board that its label names.
        label: String,
    },
    /// The image does not belong into the board's flash.
    #[error(
        "{} does not belong on {board}: it has {bytes} bytes at {address:#010x}, and the board's flash for programs is \
         {start:#010x} to {end:#010x}; `cargo xtask firmware {board}` builds the right one",
        path.display()
    )]
    WrongBoard {
        /// Which file.
        path: PathBuf,
        /// The board.
        board: &'static str,
        /// Address of the piece that does not fit.
        address: u64,
        /// Its length.
        bytes: u64,
        /// Start of the flash.
        start: u64,
        /// End of the flash.
        end: u64,
    },
    /// This program was built without probe-rs.
    #[error(
        "this `fre` was built without debug probes; build it with them: cargo run --release -p fre-cli --features probe --bin \
         fre -- …"
    )]
    NotBuilt,
    /// This program was built without the log's decoder.
    #[error(
        "this `fre` was built without logs; build it with them: cargo run --release -p fre-cli --features log --bin fre -- …"
    )]
    NoLog,
    /// There is no probe.
    #[error(
        "no debug probe was found. Looked for ST-LINK, CMSIS-DAP (v2), J-Link and the other USB probes that probe-rs knows, \
         among {devices} USB devices. Needed: {needed}. If it is connected: may this user open it (on Linux, probe-rs' \
         udev rules)? does another debugger have it?"
    )]
    NoProbe {
        /// How many USB devices were seen, or that none could be listed.
        devices: String,
        /// What has to be connected.
        needed: &'static str,
    },
    /// There are several.
    #[error("{} debug probes were found: {}; choose one by --probe VID:PID[:SERIAL]", found.len(), found.join(", "))]
    SeveralProbes {
        /// Them.
        found: Vec<String>,
    },
    /// The probe or the chip does not do what is asked.
    #[error("{doing}: {why}{hint}")]
    Probe {
        /// What was being done.
        doing: &'static str,
        /// probe-rs' words.
        why: String,
        /// What may help.
        hint: &'static str,
    },
    /// QEMU.
    #[error(transparent)]
    Qemu(#[from] QemuError),
    /// The log cannot be read or written.
    #[error("the log cannot be {doing}: {source}")]
    Log {
        /// Read or written.
        doing: &'static str,
        /// The system's words.
        source: io::Error,
    },
}
