//! A run whose ticks are measured in cycles of the real chips, by QEMU's plugin.

use std::io;
use std::path::{Path, PathBuf};

use fre_cycles::report::{BadLine, Report};
use tempfile::TempDir;

use crate::machine::firmware;

/// The cost clock of QEMU's board: a read of it ends a window and begins the next (`dual_timer::VALUE` of the board).
const CLOCK: &str = "0x40002004";

/// How an image was made. What QEMU runs must be made as what its instructions are carried over to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Build {
    /// For speed.
    Fast,
    /// For size, where the flash is small.
    Small,
}

/// What the plugin needs, and where it writes.
pub struct Cycles {
    plugin: PathBuf,
    image: PathBuf,
    boards: Vec<(String, PathBuf)>,
    folder: TempDir,
}

impl Cycles {
    /// Of the boards that have such an image. By `FRE_CYCLES_PLUGIN` (the plugin), `FRE_BOARD_IMAGES` (boards' images, `gripper-BOARD`,
    /// with colons between them), and `FRE_FIRMWARE_ELF` or `FRE_SMALL_FIRMWARE_ELF`, the image that QEMU runs.
    ///
    /// # Panics
    /// They do not name what they should.
    pub fn of(build: Build) -> Self {
        let named = |variable: &str| {
            std::env::var_os(variable).unwrap_or_else(|| panic!("{variable} is not set: run this by `cargo xtask`"))
        };
        let plugin = PathBuf::from(named("FRE_CYCLES_PLUGIN"));
        assert!(plugin.is_file(), "{} is no plugin", plugin.display());
        let image = match build {
            Build::Fast => firmware(),
            Build::Small => named("FRE_SMALL_FIRMWARE_ELF").into(),
        };
        let board = |image: PathBuf| {
            let board = image.file_name().and_then(|name| name.to_str()?.strip_prefix("gripper-")).map(str::to_owned);
            (board.unwrap_or_else(|| panic!("{} is no board's image", image.display())), image)
        };
        let is_so = |name: &str| fre_boards::named(name).is_some_and(|board| board.is_small == (build == Build::Small));
        let images = std::env::split_paths(&named("FRE_BOARD_IMAGES")).map(board).collect::<Vec<_>>();
        let boards = images.into_iter().filter(|(name, _)| is_so(name)).collect();
        Self { plugin, image, boards, folder: tempfile::tempdir().expect("a folder for the cycles") }
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
        let mut arguments = vec![("image", self.image()), ("clock", Path::new(CLOCK)), ("out", &out)];
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
