//! `cargo xtask firmware BOARD`: builds one board's image and prints its sections.

use crate::command::{headline, run as run_command};
use crate::cross::{Cross, TRIPLE};
use crate::{paths, setup};
use anyhow::{Context, Result, bail};
use object::{Object, ObjectSection, SectionFlags, SectionKind, elf};
use std::path::PathBuf;

/// Packages of `firmware/boards`; the image of each is called `gripper-BOARD`.
pub const BOARDS: &[&str] = &[SIMULATED];
/// The one that QEMU runs.
pub const SIMULATED: &str = "mps2";

/// Provides what is missing, builds and prints.
pub fn run(board: &str) -> Result<()> {
    check(board)?;
    setup::run(setup::Parts::Firmware)?;
    show(board).map(drop)
}

/// Builds a board's image and prints its sections; returns the ELF's path.
pub fn show(board: &str) -> Result<PathBuf> {
    headline(&format!("image for {board}"));
    let image = build(board)?;
    println!("{}", image.display());
    print_sections(&std::fs::read(&image).context("cannot read the image")?)?;
    Ok(image)
}

/// Builds a board's image; returns the ELF's path.
fn build(board: &str) -> Result<PathBuf> {
    check(board)?;
    let cross = Cross::find()?;
    run_command(cross.cargo("build").args(["--quiet", "--release", "--package", board, "--bins"]))?;
    Ok(paths::boards_target().join(TRIPLE).join("release").join(format!("gripper-{board}")))
}

fn check(board: &str) -> Result<()> {
    if !BOARDS.contains(&board) {
        bail!("`{board}` is not a board; the boards are: {}", BOARDS.join(", "));
    }
    Ok(())
}

fn print_sections(image: &[u8]) -> Result<()> {
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
    println!("flash {flash} bytes, static RAM {ram} bytes");
    Ok(())
}
