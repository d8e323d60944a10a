//! The boards that the gripper's firmware is made for: the one list that the images themselves, the build, the PC's tools and the
//! documentation read.
//!
//! What only an image needs (pins, clock tree, interrupts) is in its own folder of `firmware/boards`.
#![no_std]

mod label;

pub use label::{Label, SECTION};

/// A board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Board {
    /// The package's name in `firmware/boards`; its image is `gripper-NAME`.
    pub name: &'static str,
    /// What its maker calls it.
    pub title: &'static str,
    /// The chip's processor.
    pub processor: &'static str,
    /// The processor's clock, Hz. The ticks in which the firmware reports its costs are counted by it.
    pub clock_hz: u32,
    /// How long an answer to another master takes to be ready, µs, at most, from when the question is known to have ended.
    pub answer_us: u32,
    /// For how many fingers the firmware has room.
    pub fingers: usize,
    /// Ticks per second that are wanted of one finger.
    pub wanted_hz: u32,
    /// Addresses that an image may take: the first, and the one behind the last.
    pub flash: [u32; 2],
    /// What an image may take of the flash, bytes: below what the chip has, so that it is noticed before the linker notices.
    pub flash_budget: u32,
    /// The stack, bytes (`memory.x` has it, too).
    pub stack: u32,
    /// The memory for variables, the stack not counted, bytes.
    pub ram: u32,
    /// What the variables may take of it, bytes.
    pub ram_budget: u32,
    /// The image is built for size instead of speed: its flash has no room for what unrolled loops and inlined calls take.
    pub is_small: bool,
    /// Addresses of memory without wait states, beside it or at its beginning, where the first finger's model lies, or most of it: the
    /// first, and the one behind the last.
    pub near: Option<[u32; 2]>,
    /// Its floating-point unit computes in double precision as well.
    pub has_double: bool,
    /// Its image has room for friction.
    pub has_friction: bool,
    /// Its image has room for up to 16 ribs.
    pub has_ribs: bool,
    /// Nothing can be fetched while the settings are written: they lie in the program's own bank of the flash.
    pub flash_stalls: bool,
    /// How it is reached with a debug probe; a virtual board has none.
    pub probe: Option<Probe>,
    /// What its boot loader calls the board, where one takes images by the board's own port.
    pub loader: Option<&'static str>,
}

/// How a debug probe reaches a board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Probe {
    /// The chip, as probe-rs calls it.
    pub chip: &'static str,
    /// What has to be connected.
    pub connection: &'static str,
}

/// What `cargo xtask test system` allows an answer in QEMU, instructions.
pub const ANSWER_INSTRUCTIONS: u32 = 25_000;

/// By a processor's clock, at two and a half cycles for an instruction: more than the upper bound of an estimate with empty caches
/// (docs/real-time.md).
const fn answer_us(clock_hz: u32) -> u32 {
    (ANSWER_INSTRUCTIONS * 5 / 2).div_ceil(clock_hz / 1_000_000)
}

const KB: u32 = 1024;
const ST_LINK: &str = "the board's own ST-LINK, by its USB connector";

/// QEMU's mps2-an500, which the tests run. Its flash is RAM; it takes turns with the bus all the same, as on the boards.
pub const MPS2: Board = Board {
    name: "mps2",
    title: "QEMU mps2-an500",
    processor: "Cortex-M7",
    clock_hz: 25_000_000,
    // In its own time, where an instruction takes 8 ns.
    answer_us: ANSWER_INSTRUCTIONS / 125,
    fingers: 4,
    wanted_hz: 500,
    flash: [0, 4096 * KB],
    flash_budget: 708 * KB,
    stack: 512 * KB,
    ram: 3584 * KB,
    ram_budget: 512 * KB,
    is_small: false,
    near: None,
    has_double: false,
    has_friction: true,
    has_ribs: true,
    flash_stalls: true,
    probe: None,
    loader: None,
};

/// ROBOTIS' OpenCR 1.0. Its flash begins behind the boot loader, which is never overwritten. More than two fingers are hardly served
/// in time.
pub const OPENCR: Board = Board {
    name: "opencr",
    title: "ROBOTIS OpenCR 1.0",
    processor: "Cortex-M7",
    clock_hz: 216_000_000,
    answer_us: answer_us(216_000_000),
    fingers: 2,
    wanted_hz: 500,
    flash: [0x0804_0000, 0x0810_0000],
    flash_budget: 732 * KB,
    stack: 48 * KB,
    ram: 268 * KB - 256,
    ram_budget: 260 * KB,
    is_small: false,
    near: Some([0x2000_0100, 0x2001_0000]),
    has_double: false,
    has_friction: true,
    has_ribs: true,
    flash_stalls: true,
    probe: Some(Probe {
        chip: "STM32F746ZG",
        connection: "a debug probe (ST-LINK, CMSIS-DAP, J-Link) at the board's JTAG/SWD connector",
    }),
    loader: Some("OpenCR R1.0"),
};

/// ST's NUCLEO-H743ZI2. The settings lie in the last two sectors of the second bank.
pub const NUCLEO_H743ZI: Board = Board {
    name: "nucleo-h743zi",
    title: "ST NUCLEO-H743ZI2",
    processor: "Cortex-M7",
    clock_hz: 480_000_000,
    answer_us: answer_us(480_000_000),
    fingers: 4,
    wanted_hz: 1000,
    flash: [0x0800_0000, 0x0810_0000],
    flash_budget: 672 * KB,
    stack: 42 * KB,
    ram: 512 * KB,
    ram_budget: 448 * KB,
    is_small: false,
    near: Some([0x2000_a900, 0x2002_0000]),
    has_double: true,
    has_friction: true,
    has_ribs: true,
    flash_stalls: false,
    probe: Some(Probe { chip: "STM32H743ZI", connection: ST_LINK }),
    loader: None,
};

/// ST's NUCLEO-G474RE. The settings lie in the last 16 KB.
pub const NUCLEO_G474RE: Board = Board {
    name: "nucleo-g474re",
    title: "ST NUCLEO-G474RE",
    processor: "Cortex-M4",
    clock_hz: 170_000_000,
    answer_us: answer_us(170_000_000),
    fingers: 1,
    wanted_hz: 500,
    flash: [0x0800_0000, 0x0807_c000],
    flash_budget: 464 * KB,
    stack: 29 * KB,
    ram: 99 * KB - 256 - 1536,
    ram_budget: 97 * KB,
    is_small: true,
    near: None,
    has_double: false,
    has_friction: false,
    has_ribs: false,
    flash_stalls: true,
    probe: Some(Probe { chip: "STM32G474RE", connection: ST_LINK }),
    loader: None,
};

/// ST's NUCLEO-F429ZI. The settings lie in the first sectors of the second bank.
pub const NUCLEO_F429ZI: Board = Board {
    name: "nucleo-f429zi",
    title: "ST NUCLEO-F429ZI",
    processor: "Cortex-M4",
    clock_hz: 168_000_000,
    answer_us: answer_us(168_000_000),
    fingers: 1,
    wanted_hz: 500,
    flash: [0x0800_0000, 0x0810_0000],
    flash_budget: 644 * KB,
    stack: 64 * KB,
    ram: 190 * KB - 256,
    ram_budget: 180 * KB,
    is_small: false,
    near: None,
    has_double: false,
    has_friction: true,
    has_ribs: true,
    flash_stalls: false,
    probe: Some(Probe { chip: "STM32F429ZI", connection: ST_LINK }),
    loader: None,
};

/// All of them.
pub const ALL: &[Board] = &[MPS2, OPENCR, NUCLEO_H743ZI, NUCLEO_G474RE, NUCLEO_F429ZI];

/// The board of this name.
pub fn named(name: &str) -> Option<&'static Board> {
    ALL.iter().find(|board| board.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_budgets_are_within_the_chip() {
        for (index, board) in ALL.iter().enumerate() {
            assert_eq!(ALL.iter().position(|other| other.name == board.name), Some(index), "{}", board.name);
            assert_eq!(named(board.name), Some(board));
            let [first, end] = board.flash;
            assert!(
                first < end && board.flash_budget <= end - first && board.ram_budget <= board.ram,
                "{}",
                board.name
            );
            assert!(board.fingers > 0 && board.clock_hz > 0 && board.wanted_hz > 0, "{}", board.name);
        }
        assert_eq!(named("uno"), None);
    }
}
