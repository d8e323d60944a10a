//! A run whose ticks are measured in cycles of the real chips, by QEMU's plugin.

use std::ffi::OsString;
use std::io;
use std::path::{Path, PathBuf};

use fre_cycles::report::{BadLine, Report};
use tempfile::TempDir;

use crate::machine::firmware;

/// The cost clock of QEMU's board: a read of it ends a window and begins the next (`dual_timer::VALUE` of the board).
const CLOCK: &str = "0x40002004";

/// What the plugin needs, and where it writes.
pub struct Cycles {
    plugin: PathBuf,
    image: PathBuf,
    boards: Vec<(String, PathBuf)>,
    layouts: &'static str,
    folder: TempDir,
}

impl Cycles {
    /// Of the firmware that QEMU runs, on the boards whose images are made as that is. By `FRE_FIRMWARE_ELF`, `FRE_CYCLES_PLUGIN` (the
    /// plugin), and `FRE_BOARD_IMAGES` (boards' images, `gripper-BOARD`, with colons between them).
    ///
    /// # Panics
    /// They do not name what they should.
    pub fn new() -> Self {
        Self::of(firmware(), images("FRE_BOARD_IMAGES", "gripper-"))
    }

    /// Of a board's twin, the firmware for QEMU made as that board's is, on that board: `FRE_TWIN_IMAGES` has them (`twin-BOARD`).
    ///
    /// # Panics
    /// As [`Self::new`].
    pub fn twin(board: &str) -> Self {
        let only = |variable: &str, prefix: &str| {
            let mut found = images(variable, prefix);
            found.retain(|(name, _)| name == board);
            assert_eq!(found.len(), 1, "{variable} has no image of {board}");
            found
        };
        let (_, image) = only("FRE_TWIN_IMAGES", "twin-").remove(0);
        Self::of(image, only("FRE_BOARD_IMAGES", "gripper-"))
    }

    fn of(image: PathBuf, boards: Vec<(String, PathBuf)>) -> Self {
        let plugin = PathBuf::from(named("FRE_CYCLES_PLUGIN"));
        assert!(plugin.is_file(), "{} is no plugin", plugin.display());
        Self { plugin, image, boards, layouts: "all", folder: tempfile::tempdir().expect("a folder for the cycles") }
    }

    /// Without the layouts that no image has.
    #[must_use]
    pub fn as_image(self) -> Self {
        Self { layouts: "image", ..self }
    }

    /// What QEMU runs.
    pub(crate) fn image(&self) -> &Path {
        &self.image
    }

    fn out(&self) -> PathBuf {
        self.folder.path().join("windows")
    }

    /// A virtual board that is measured.
    pub(crate) fn on(&self, machine: fre_qemu::Machine) -> fre_qemu::Machine {
        let out = self.out();
        let (clock, layouts) = (Path::new(CLOCK), Path::new(self.layouts));
        let mut arguments = vec![("image", self.image()), ("clock", clock), ("out", &out), ("layouts", layouts)];
        arguments.extend(self.boards.iter().map(|(board, image)| (board.as_str(), image.as_path())));
        machine.plugin(&self.plugin, &arguments)
    }

    /// What has been measured until now.
    ///
    /// # Errors
    /// Nothing was written; or something else than the plugin's lines.
    pub fn report(&self) -> io::Result<Report> {
        let mut summary = self.out().into_os_string();
        summary.push(".summary");
        let windows = std::fs::read_to_string(self.out())?;
        let bad = |error: BadLine| io::Error::new(io::ErrorKind::InvalidData, error);
        Report::parse(&windows, &std::fs::read_to_string(summary)?).map_err(bad)
    }
}

impl Default for Cycles {
    fn default() -> Self {
        Self::new()
    }
}

fn named(variable: &str) -> OsString {
    std::env::var_os(variable).unwrap_or_else(|| panic!("{variable} is not set: run this by `cargo xtask`"))
}

/// Boards and their images, by a variable that has their paths and what a file's name begins with.
fn images(variable: &str, prefix: &str) -> Vec<(String, PathBuf)> {
    let board = |image: PathBuf| {
        let board = image.file_name().and_then(|name| name.to_str()?.strip_prefix(prefix)).map(str::to_owned);
        (board.unwrap_or_else(|| panic!("{} is no board's image", image.display())), image)
    };
    std::env::split_paths(&named(variable)).map(board).collect()
}
