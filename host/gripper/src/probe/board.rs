//! The boards that a debug probe reaches.

use std::path::PathBuf;

use fre_boards::Probe;

/// A board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Board {
    /// As `cargo xtask firmware` calls it.
    pub name: &'static str,
    /// Its chip, as probe-rs calls it.
    pub chip: &'static str,
    /// Addresses that an image may take: the first, and the one behind the last.
    pub flash: (u64, u64),
    /// What has to be connected.
    pub probe: &'static str,
    /// What its boot loader calls the board, if that takes images by the board's own port.
    pub loader: Option<&'static str>,
}

impl Board {
    /// Those that a debug probe reaches.
    pub fn all() -> impl Iterator<Item = Self> {
        fre_boards::ALL.iter().filter_map(|board| {
            let [first, end] = board.flash.map(u64::from);
            let Probe { chip, connection } = board.probe?;
            Some(Self { name: board.name, chip, flash: (first, end), probe: connection, loader: board.loader })
        })
    }

    /// The board of this name.
    ///
    /// # Errors
    /// There is none; names those that are.
    pub fn named(name: &str) -> Result<Self, String> {
        Self::all().find(|board| board.name == name).ok_or_else(|| format!("allowed are {}", Self::names()))
    }

    /// All names, in a row.
    pub fn names() -> String {
        let names: Vec<&str> = Self::all().map(|board| board.name).collect();
        names.join(", ")
    }

    /// Where `cargo xtask firmware` puts its image, from the repository's root.
    pub fn image(&self) -> PathBuf {
        image_of(self.name)
    }
}

/// Where `cargo xtask firmware` puts a board's image, from the repository's root.
pub(super) fn image_of(name: &str) -> PathBuf {
    ["target", "boards", "thumbv7em-none-eabihf", "release", &format!("gripper-{name}")].iter().collect()
}
