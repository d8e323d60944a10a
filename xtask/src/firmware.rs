//! `cargo xtask firmware BOARD`: builds one board's image and prints its sections.

use crate::command::{headline, run as run_command};
use crate::cross::{Cross, TRIPLE, board_target};
use crate::{in_ram, near, paths, setup};
use anyhow::{Context, Result, bail, ensure};
use fre_boards::{Board, Label, SECTION};
use object::elf::FileHeader32;
use object::read::elf::{FileHeader, ProgramHeader};
use object::{Endianness, Object, ObjectSection, ObjectSymbol, SectionFlags, SectionKind, elf};
use std::path::{Path, PathBuf};

/// The one that QEMU runs.
pub const SIMULATED: &str = fre_boards::MPS2.name;
/// The one whose cycles the tests measure.
pub const MEASURED: &str = fre_boards::OPENCR.name;

/// Provides what is missing, builds and prints.
pub fn run(board: &str) -> Result<()> {
    check(board)?;
    setup::run(setup::Parts::Firmware)?;
    show(board).map(drop)
}

/// Builds a board's image and prints its sections; returns the ELF's path. An image over its budget is an error, and so is one that needs
/// flash where it has to run from RAM.
pub fn show(board: &str) -> Result<PathBuf> {
    headline(&format!("image for {board}"));
    let image = build(board)?;
    println!("{}", image.display());
    let (listed, bytes) = (check(board)?, std::fs::read(&image).context("cannot read the image")?);
    print_sections(listed, &bytes)?;
    labelled(listed, &bytes)?;
    loads(listed, &bytes)?;
    near::check(listed, &bytes).with_context(|| format!("the image for {board}"))?;
    if listed.probe.is_some() {
        in_ram::check(listed, &bytes).with_context(|| format!("the image for {board}"))?;
    }
    Ok(image)
}

/// Looks through a board's own code with Clippy.
pub fn lint(cross: &Cross, board: &str) -> Result<()> {
    let package = ["--quiet", "--release", "--package", board, "--bins"];
    run_command(cross.cargo("clippy").args(package).args(["--", "-D", "warnings"]))
}

/// That the image's file says which board and version it is: `fre flash` refuses all others.
pub fn labelled(board: &Board, image: &[u8]) -> Result<()> {
    let file = object::File::parse(image).context("the image is not an ELF file")?;
    let section = file.section_by_name(SECTION).with_context(|| format!("the image has no section {SECTION}"))?;
    let SectionFlags::Elf { sh_flags } = section.flags() else { bail!("the image is not an ELF file") };
    ensure!(sh_flags & u64::from(elf::SHF_ALLOC) == 0, "the label takes room on the board");
    let found = Label::read(section.data()?);
    ensure!(found == Some((board.name, env!("CARGO_PKG_VERSION"))), "the image's label is {found:?}");
    Ok(())
}

/// That all that the image's file loads belongs into the board's flash: `fre flash` refuses anything else.
fn loads(board: &Board, image: &[u8]) -> Result<()> {
    let header = FileHeader32::<Endianness>::parse(image).context("the image is not a 32-bit ELF file")?;
    let endian = header.endian()?;
    for segment in header.program_headers(endian, image)? {
        let (start, bytes) = (segment.p_paddr(endian), segment.p_filesz(endian));
        let is_inside = board.flash[0] <= start && u64::from(start) + u64::from(bytes) <= u64::from(board.flash[1]);
        let is_loaded = segment.p_type(endian) == elf::PT_LOAD && bytes > 0;
        ensure!(
            is_inside || !is_loaded,
            "the image loads {bytes} bytes at {start:#010x}, which is not in the flash of {}",
            board.name
        );
    }
    Ok(())
}

/// Builds a board's image; returns the ELF's path.
fn build(board: &str) -> Result<PathBuf> {
    let listed = check(board)?;
    let cross = Cross::find()?;
    run_command(cross.image_cargo(listed, "build").args(["--quiet", "--release", "--package", board, "--bins"]))?;
    keep(&image_in(&board_target(listed), board), &image(board))
}

/// Builds the simulated board's image as a board's own is made: optimised alike, for the same floating-point unit, with the same room.
/// What QEMU runs of it is then found in that board's image. Returns the ELF's path, beside the others.
pub fn twin(board: &str) -> Result<PathBuf> {
    let listed = check(board)?;
    let cross = Cross::find()?;
    let mut build = cross.image_cargo(listed, "build");
    build.args(["--quiet", "--release", "--package", SIMULATED, "--bins"]);
    if listed.is_small {
        build.arg("--config").arg(format!("profile.release.package.{SIMULATED}.opt-level=\"s\""));
    }
    build.args(["--no-default-features", "--features", &room(listed).join(",")]);
    run_command(&mut build)?;
    let kept = image(SIMULATED).with_file_name(format!("twin-{board}"));
    keep(&image_in(&board_target(listed), SIMULATED), &kept)
}

/// The features of the firmware for which a board has the memory.
fn room(board: &Board) -> Vec<&'static str> {
    let has = [(board.has_friction, "friction"), (board.has_ribs, "ribs")];
    has.into_iter().filter_map(|(has, feature)| has.then_some(feature)).collect()
}

/// Where a board's image is once it is built; `fre flash` looks there, too.
pub fn image(board: &str) -> PathBuf {
    image_in(&paths::boards_target(), board)
}

/// Copies an image to where it is looked for, unless it is there; returns that place.
fn keep(built: &Path, kept: &Path) -> Result<PathBuf> {
    if built != kept {
        let copy = || {
            kept.parent().map_or(Ok(()), std::fs::create_dir_all)?;
            std::fs::copy(built, kept)
        };
        copy().with_context(|| format!("cannot keep the image as {}", kept.display()))?;
    }
    Ok(kept.to_owned())
}

/// A board's image in a target folder.
fn image_in(folder: &Path, board: &str) -> PathBuf {
    folder.join(TRIPLE).join("release").join(format!("gripper-{board}"))
}

fn check(board: &str) -> Result<&'static Board> {
    fre_boards::named(board).with_context(|| format!("`{board}` is not a board; the boards are: {}", names()))
}

/// The boards' names, in a row.
pub fn names() -> String {
    let names: Vec<&str> = fre_boards::ALL.iter().map(|board| board.name).collect();
    names.join(", ")
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
        let bytes = start.saturating_sub(end);
        println!("{:<14} {bytes:>8} bytes at {end:#010x}", "stack");
        if bytes != u64::from(board.stack) {
            bail!("{} has {bytes} bytes of stack by its memory.x, {} by the list of boards", board.name, board.stack);
        }
    }
    println!("flash {flash} of {} bytes, static RAM {ram} of {} bytes", board.flash_budget, board.ram_budget);
    within(board, flash, ram)
}

/// That an image keeps its budget.
fn within(board: &Board, flash: u64, ram: u64) -> Result<()> {
    for (what, used, allowed) in [("flash", flash, board.flash_budget), ("static RAM", ram, board.ram_budget)] {
        if used > u64::from(allowed) {
            bail!("the image for {} takes {used} bytes of {what}; its budget is {allowed}", board.name);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An image that was built elsewhere is then where `fre flash` looks, and the last one built counts.
    #[test]
    fn an_image_is_kept_where_it_is_looked_for() {
        let folder = tempfile::tempdir().unwrap();
        let (built, kept) = (folder.path().join("built"), folder.path().join("double/kept"));
        for content in ["first", "second"] {
            std::fs::write(&built, content).unwrap();
            assert_eq!(keep(&built, &kept).unwrap(), kept);
            assert_eq!(std::fs::read_to_string(&kept).unwrap(), content);
        }
        assert_eq!(keep(&kept, &kept).unwrap(), kept);
        assert_eq!(std::fs::read_to_string(&kept).unwrap(), "second");
    }

    #[test]
    fn a_budget_is_kept_or_named() {
        let board = check("opencr").unwrap();
        let [flash, ram] = [board.flash_budget, board.ram_budget].map(u64::from);
        assert!(within(board, flash, ram).is_ok());
        let error = within(board, flash + 1, 0).unwrap_err().to_string();
        assert!(
            error.contains("opencr") && error.contains("of flash") && error.contains(&flash.to_string()),
            "{error}"
        );
        assert!(within(board, 0, ram + 1).unwrap_err().to_string().contains("static RAM"));
        assert!(check("uno").unwrap_err().to_string().contains("mps2, opencr, nucleo-h743zi, nucleo-g474re"));
    }

    /// `KEY : ORIGIN = a, LENGTH = b` of a memory map; bytes, with K and M, and differences.
    fn region(map: &str, key: &str) -> [u64; 2] {
        let line = map.lines().find(|line| line.trim().starts_with(key)).unwrap();
        let (origin, length) = line.split_once("ORIGIN =").unwrap().1.split_once(", LENGTH =").unwrap();
        let number = |text: &str| {
            let text = text.trim();
            let (digits, unit) = match text.as_bytes().last() {
                Some(b'K') => (&text[..text.len() - 1], 1024),
                Some(b'M') => (&text[..text.len() - 1], 1024 * 1024),
                _ => (text, 1),
            };
            let hex = digits.strip_prefix("0x").map(|digits| u64::from_str_radix(digits, 16).unwrap());
            unit * hex.unwrap_or_else(|| digits.parse().unwrap())
        };
        let (mut plus, minus): (Vec<&str>, Vec<&str>) = (origin.split('+').collect(), length.split(" - ").collect());
        let origin = plus.drain(..).map(number).sum();
        [origin, number(minus[0]) - minus[1..].iter().map(|text| number(text)).sum::<u64>()]
    }

    #[test]
    fn the_list_has_the_memory_of_each_board_s_own_map() {
        for board in fre_boards::ALL {
            let map = std::fs::read_to_string(paths::boards().join(board.name).join("memory.x")).unwrap();
            let has = |start: &str| map.lines().any(|line| line.trim().starts_with(start));
            let [origin, length] = region(&map, "FLASH");
            // The part that runs from elsewhere follows the other one.
            let behind = if has("ACCELERATED ") { region(&map, "ACCELERATED_LOAD") } else { [origin + length, 0] };
            assert_eq!(behind[0], origin + length, "{}", board.name);
            assert_eq!([origin, behind[0] + behind[1]], board.flash.map(u64::from), "{}", board.name);
            let [ram, bytes] = region(&map, "RAM");
            assert_eq!(bytes, u64::from(board.ram), "{}", board.name);
            let listed = board.near.map(|[first, end]| [u64::from(first), u64::from(end - first)]);
            if has("REGION_ALIAS(\"NEAR\", RAM)") {
                assert!(listed.is_some_and(|[first, near]| first == ram && near < bytes), "{}", board.name);
            } else {
                assert_eq!(has("NEAR ").then(|| region(&map, "NEAR")), listed, "{}", board.name);
            }
            if has("GUARD ") {
                let [guard, bytes] = region(&map, "GUARD");
                let source = std::fs::read_to_string(paths::boards().join("stm32/src/guard.rs")).unwrap();
                assert!(source.contains(&format!("const BYTES: u32 = {bytes};")), "{}: {bytes}", board.name);
                assert_eq!((guard % bytes, guard + bytes), (0, region(&map, "STACK")[0]), "{}", board.name);
            }
        }
    }

    #[test]
    fn every_board_is_a_package_built_as_listed_with_a_page_and_every_package_is_a_board() {
        let manifest = std::fs::read_to_string(paths::boards().join("Cargo.toml")).unwrap();
        for board in fre_boards::ALL {
            assert!(manifest.contains(&format!("\"{}\"", board.name)), "{} is not a member", board.name);
            let level = format!("[profile.release.package.{}]\nopt-level = \"s\"\n", board.name);
            assert_eq!(manifest.contains(&level), board.is_small, "{}", board.name);
            let own = std::fs::read_to_string(paths::boards().join(board.name).join("Cargo.toml")).unwrap();
            for feature in ["friction", "ribs"] {
                let listed = room(board).contains(&feature);
                assert_eq!(own.contains(&format!("\"{feature}\"")), listed, "{}: {feature}", board.name);
            }
            // The virtual one has nothing to wire.
            assert!(
                board.probe.is_none() || paths::boards().join(board.name).join("README.md").exists(),
                "{}",
                board.name
            );
        }
        for entry in paths::boards().read_dir().unwrap() {
            let folder = entry.unwrap().path();
            let name = folder.file_name().unwrap().to_string_lossy().into_owned();
            let board = folder.join("memory.x").exists();
            assert!(!board || fre_boards::named(&name).is_some(), "{name} is not in firmware/board-list");
        }
    }

    #[test]
    fn every_crate_of_two_versions_has_its_reason() {
        let lock = std::fs::read_to_string(paths::boards().join("Cargo.lock")).unwrap();
        let mut names: Vec<&str> = lock.lines().filter_map(|line| line.strip_prefix("name = ")).collect();
        names.sort_unstable();
        let mut twice: Vec<&str> =
            names.windows(2).filter(|pair| pair[0] == pair[1]).map(|pair| pair[0].trim_matches('"')).collect();
        twice.dedup();
        let page = std::fs::read_to_string(paths::boards().join("README.md")).unwrap();
        let table = page.split_once("## Crates of two versions").unwrap().1;
        let rows = table.lines().filter_map(|line| line.strip_prefix("| `")?.split_once(" |"));
        let mut explained: Vec<&str> = rows.flat_map(|(crates, _)| crates.split(", ")).collect();
        explained.iter_mut().for_each(|name| *name = name.trim_matches('`'));
        explained.sort_unstable();
        assert_eq!(explained, twice);
    }

    #[test]
    fn the_page_of_the_boards_has_the_list() {
        let page = std::fs::read_to_string(paths::boards().join("README.md")).unwrap();
        for board in fre_boards::ALL {
            let Some(probe) = board.probe else { continue };
            let row = format!(
                "| [{}]({}/README.md) | `{}` | {}, {} | {} MHz | {} µs | {} | {} of {} KB | {} of {} KB |",
                board.title,
                board.name,
                board.name,
                probe.chip,
                board.processor,
                board.clock_hz / 1_000_000,
                board.answer_us,
                board.fingers,
                board.flash_budget / 1024,
                (board.flash[1] - board.flash[0]) / 1024,
                board.ram_budget / 1024,
                board.ram / 1024,
            );
            assert!(page.contains(&row), "firmware/boards/README.md lacks the row\n{row}");
        }
    }
}
