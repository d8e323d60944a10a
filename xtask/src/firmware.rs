//! `cargo xtask firmware BOARD`: builds one board's image and prints its sections.

use crate::command::{headline, run as run_command};
use crate::cross::{Cross, TRIPLE};
use crate::{paths, setup};
use anyhow::{Context, Result, bail};
use object::{Object, ObjectSection, ObjectSymbol, SectionFlags, SectionKind, elf};
use std::path::PathBuf;

/// A board: a package of `firmware/boards`, whose image is called `gripper-NAME`.
#[derive(Debug)]
pub struct Board {
    /// Its name.
    pub name: &'static str,
    /// What its image may take of the flash, bytes.
    flash: u64,
    /// What its variables may take of the RAM, the stack not counted, bytes.
    ram: u64,
}

const KB: u64 = 1024;

/// The boards. A budget is below what the chip has: it is there to be noticed before the linker is.
pub const BOARDS: &[Board] = &[
    Board { name: SIMULATED, flash: 480 * KB, ram: 512 * KB },
    Board { name: "opencr", flash: 512 * KB, ram: 192 * KB },
    Board { name: "nucleo-h743zi", flash: 512 * KB, ram: 448 * KB },
    Board { name: "nucleo-g474re", flash: 448 * KB, ram: 108 * KB },
];
/// The one that QEMU runs.
pub const SIMULATED: &str = "mps2";
/// The one whose cycles the tests measure.
pub const MEASURED: &str = "opencr";

/// Provides what is missing, builds and prints.
pub fn run(board: &str) -> Result<()> {
    check(board)?;
    setup::run(setup::Parts::Firmware)?;
    show(board).map(drop)
}

/// Builds a board's image and prints its sections; returns the ELF's path. An image over its budget is an error.
pub fn show(board: &str) -> Result<PathBuf> {
    headline(&format!("image for {board}"));
    let image = build(board)?;
    println!("{}", image.display());
    print_sections(check(board)?, &std::fs::read(&image).context("cannot read the image")?)?;
    Ok(image)
}

/// Builds a board's image; returns the ELF's path.
fn build(board: &str) -> Result<PathBuf> {
    check(board)?;
    let cross = Cross::find()?;
    run_command(cross.cargo("build").args(["--quiet", "--release", "--package", board, "--bins"]))?;
    Ok(image(board))
}

/// Where a board's image is once it is built.
pub fn image(board: &str) -> PathBuf {
    paths::boards_target().join(TRIPLE).join("release").join(format!("gripper-{board}"))
}

fn check(board: &str) -> Result<&'static Board> {
    BOARDS.iter().find(|known| known.name == board).with_context(|| {
        let names: Vec<&str> = BOARDS.iter().map(|board| board.name).collect();
        format!("`{board}` is not a board; the boards are: {}", names.join(", "))
    })
}

fn print_sections(board: &Board, image: &[u8]) -> Result<()> {
    let file = object::File::parse(image).context("the image is not an ELF file")?;
    let (mut flash, mut ram) = (0, 0);
    for section in file.sections() {
        let SectionFlags::Elf { sh_flags } = section.flags() else {
            continue;
        };
        if sh_flags & u64::from(elf::SHF_ALLOC) == 0 || section.size() == 0 {
            continue;
        }
        println!("{:<14} {:>8} bytes at {:#010x}", section.name()?, section.size(), section.address());
        let zeros = section.kind() == SectionKind::UninitializedData;
        let writable = sh_flags & u64::from(elf::SHF_WRITE) != 0;
        flash += if zeros { 0 } else { section.size() };
        ram += if zeros || writable { section.size() } else { 0 };
    }
    let symbol = |name: &str| file.symbols().find(|symbol| symbol.name() == Ok(name)).map(|symbol| symbol.address());
    if let (Some(start), Some(end)) = (symbol("_stack_start"), symbol("_stack_end")) {
        println!("{:<14} {:>8} bytes at {end:#010x}", "stack", start.saturating_sub(end));
    }
    println!("flash {flash} of {} bytes, static RAM {ram} of {} bytes", board.flash, board.ram);
    within(board, flash, ram)
}

/// That an image keeps its budget.
fn within(board: &Board, flash: u64, ram: u64) -> Result<()> {
    for (what, used, allowed) in [("flash", flash, board.flash), ("static RAM", ram, board.ram)] {
        if used > allowed {
            bail!("the image for {} takes {used} bytes of {what}; its budget is {allowed}", board.name);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_budget_is_kept_or_named() {
        let board = check("opencr").unwrap();
        assert!(within(board, board.flash, board.ram).is_ok());
        let error = within(board, board.flash + 1, 0).unwrap_err().to_string();
        assert!(
            error.contains("opencr") && error.contains("of flash") && error.contains(&board.flash.to_string()),
            "{error}"
        );
        assert!(within(board, 0, board.ram + 1).unwrap_err().to_string().contains("static RAM"));
        assert!(check("uno").unwrap_err().to_string().contains("mps2, opencr, nucleo-h743zi, nucleo-g474re"));
    }
}
