//! Repository commands: `cargo xtask COMMAND`, from anywhere in the repository.

mod bench;
mod command;
mod cross;
mod crossing;
mod demo;
mod derivation;
mod firmware;
mod fuzz;
mod on_target;
mod panic_free;
mod paths;
mod pc;
mod portable;
mod python;
mod qemu;
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
                         (in QEMU), system, boards
  firmware BOARD         build one board's image and print its sections (boards: mps2, opencr,
                         nucleo-h743zi, nucleo-g474re)
  qemu-run ELF           run an image in QEMU: its tests if it holds any, else the program with its log
  decode ELF             turn an image's log, on standard input, into text
  demo [--seconds N] [--physics paper|extended] [--live]
                         the firmware in QEMU beside the full-resolution model: live lines, a table, target/demo/report.html
  bench [--json FILE] [PART ...]
                         every figure that the README and the book quote, or these parts of them (`bench --help` lists them)
  docs                   make what rustdoc shows of docs/derivation.md
  fuzz [--seconds N] [TARGET ...]
                         every fuzz target, or these, for N seconds each (60); failing inputs are shown and kept in target/fuzz/crashes";

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
            println!("{USAGE}");
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
        ["docs"] => derivation::write(),
        _ => bail!("`{}` is not a command\n\n{USAGE}", arguments.join(" ")),
    }
}

fn qemu_run(elf: &Path) -> Result<()> {
    if on_target::holds_tests(&read_image(elf)?)? { on_target::run(elf) } else { qemu::run_with_log(elf) }
}

fn read_image(elf: &Path) -> Result<Vec<u8>> {
    std::fs::read(elf).with_context(|| format!("cannot read the image {}", elf.display()))
}
