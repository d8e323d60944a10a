//! Repository commands: `cargo xtask COMMAND`, from anywhere in the repository.

mod bench;
mod command;
mod cross;
mod crossing;
mod cycles;
mod demo;
mod derivation;
mod docs;
mod firmware;
mod fuzz;
mod in_ram;
mod near;
mod new_board;
mod on_target;
mod panic_free;
mod paths;
mod pc;
mod portable;
mod python;
mod qemu;
mod release;
mod setup;
mod suite;

use anyhow::{Context, Result, bail};
use fre_log::Log;
use std::path::Path;
use std::process::ExitCode;

const USAGE: &str = "\
usage: cargo xtask COMMAND

  setup [--fea]          install or build what is missing: QEMU, cross target, Python packages for the tests
  test [PART ...]        every check and test, or these parts of it: format, clippy, pc, python, target
                         (in QEMU), system, boards, release
  firmware BOARD         build one board's image and print its sections (boards: BOARDS)
  qemu-run ELF           run an image in QEMU: its tests if it holds any, else the program with its log
  decode ELF             turn an image's log, on standard input, into text
  demo [--seconds N] [--physics paper|extended] [--live]
                         the firmware in QEMU beside the full-resolution model: live lines, a table, target/demo/report.html
  bench [--json FILE] [PART ...]
                         every figure that the README and the book quote, or these parts of them (`bench --help` lists them)
  bench ros2             a minute of forces at 500 Hz to another implementation of DDS: what is lost
  docs [--check]         make what the program makes of the book's pages and pictures, and the book in target/book; --check
                         compares instead
  docs --page            make the picture of the live page, in Chromium, on the firmware in QEMU
  release [--suite] [FOLDER]
                         make a release in FOLDER (target/release-VERSION): the command, the wheel, the images, the crates and
                         their checksums; --suite uses what the tests have built
  fuzz [--seconds N] [TARGET ...]
                         every fuzz target, or these, for N seconds each (60); failing inputs are shown and kept in target/fuzz/crashes";

/// [`USAGE`] with the boards' names.
fn usage() -> String {
    USAGE.replace("BOARDS", &firmware::names())
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match dispatch(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn dispatch(arguments: &[&str]) -> Result<()> {
    match arguments {
        [] | ["help" | "--help" | "-h"] => {
            println!("{}", usage());
            Ok(())
        }
        ["setup"] => setup::run(setup::Parts::Everything),
        ["setup", "--fea"] => setup::run(setup::Parts::EverythingAndFea),
        ["test", parts @ ..] => suite::run(parts),
        ["bench", rest @ ..] => bench::run(rest),
        ["firmware", board] => firmware::run(board),
        ["qemu-run", elf] => qemu_run(Path::new(elf)),
        ["decode", elf] => qemu::print(&Log::of(&read_image(Path::new(elf))?)?, std::io::stdin()),
        ["demo", options @ ..] => demo::run(options),
        ["fuzz", rest @ ..] => fuzz::run(rest),
        ["docs"] => docs::run(docs::Way::Write),
        ["docs", "--check"] => docs::run(docs::Way::Check),
        ["docs", "--page"] => docs::page(),
        ["release", rest @ ..] => release(rest),
        _ => bail!("`{}` is not a command\n\n{}", arguments.join(" "), usage()),
    }
}

/// `release [--suite] [FOLDER]`.
fn release(words: &[&str]) -> Result<()> {
    let (parts, words) = match words {
        ["--suite", rest @ ..] => (release::Parts::Suite, rest),
        rest => (release::Parts::Built, rest),
    };
    match words {
        [] => release::run(parts, &paths::target().join(concat!("release-", env!("CARGO_PKG_VERSION")))),
        [folder] if !folder.starts_with('-') => release::run(parts, &std::path::absolute(folder)?),
        _ => bail!("`release {}` is not understood\n\n{}", words.join(" "), usage()),
    }
}

fn qemu_run(elf: &Path) -> Result<()> {
    if on_target::holds_tests(&read_image(elf)?)? { on_target::run(elf) } else { qemu::run_with_log(elf) }
}

fn read_image(elf: &Path) -> Result<Vec<u8>> {
    std::fs::read(elf).with_context(|| format!("cannot read the image {}", elf.display()))
}
