//! The boards that a debug probe reaches.

use std::path::PathBuf;

/// A board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Board {
    /// As `cargo xtask firmware` calls it.
    pub name: &'static str,
    /// Its chip, as probe-rs calls it.
    pub chip: &'static str,
    /// The chip's flash, by addresses: where the image may lie.
    pub flash: (u64, u64),
    /// What has to be connected.
    pub probe: &'static str,
}

/// All of them. An OpenCR's flash begins behind its boot loader, which is never overwritten.
pub const BOARDS: &[Board] = &[
    Board {
        name: "opencr",
        chip: "STM32F746ZG",
        flash: (0x0804_0000, 0x0810_0000),
        probe: "a debug probe (ST-LINK, CMSIS-DAP, J-Link) at the board's JTAG/SWD connector",
    },
    Board {
        name: "nucleo-h743zi",
        chip: "STM32H743ZI",
        flash: (0x0800_0000, 0x0820_0000),
        probe: "the board's own ST-LINK, by its USB connector",
    },
    Board {
        name: "nucleo-g474re",
        chip: "STM32G474RE",
        flash: (0x0800_0000, 0x0808_0000),
        probe: "the board's own ST-LINK, by its USB connector",
    },
];

impl Board {
    /// The board of this name.
    ///
    /// # Errors
    /// There is none; names those that are.
    pub fn named(name: &str) -> Result<Self, String> {
        BOARDS.iter().find(|board| board.name == name).copied().ok_or_else(|| {
            let names: Vec<&str> = BOARDS.iter().map(|board| board.name).collect();
            format!("allowed are {}", names.join(", "))
        })
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
