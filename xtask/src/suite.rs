//! `cargo xtask test`: every check and test, the cheap ones first.

use crate::command::{find, headline, run as run_command};
use crate::cross::{Cross, TRIPLE, built};
use crate::pc::{FEATURES, cargo};
use crate::{cycles, firmware, new_board, on_target, panic_free, paths, portable, python, release, setup};
use anyhow::{Context, Result, bail};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Instant;

/// A part of the suite, and what it does.
type Part = (&'static str, fn() -> Result<()>);

/// The suite, in the order its parts run in.
const PARTS: &[Part] = &[
    ("format", format),
    ("clippy", clippy),
    ("doc", doc),
    ("pc", pc),
    ("target", target),
    ("boards", boards),
    ("python", python::test),
    ("system", system),
    // Last: of what the parts before it have built.
    ("release", || release::run(release::Parts::Suite, &paths::target().join("release-suite"))),
];

/// The first part that needs the set-up: where all run, it goes on beside those before.
const EQUIPPED: &str = "pc";
/// Parts that run beside those before [`ALONE`], where all run: they build in a folder of their own, a thread to an image.
const BESIDE: [&str; 2] = ["target", "boards"];
/// The first part that has the machine for itself: QEMU and clients of the firmware there keep to real time.
const ALONE: &str = "python";

/// Runs the parts named, or all. A part that fails stops at its first failing step; the others run all the same, so that one run names
/// every part at fault.
pub fn run(names: &[&str]) -> Result<()> {
    if let Some(unknown) = names.iter().find(|name| !PARTS.iter().any(|(part, _)| part == *name)) {
        let parts: Vec<&str> = PARTS.iter().map(|(part, _)| *part).collect();
        bail!("`{unknown}` is not a part of the tests; the parts are: {}", parts.join(", "));
    }
    let all = names.is_empty();
    let mut beside = if all { Some(Beside::start(&["setup"])?) } else { None };
    if !all {
        headline("set-up");
        setup::run(setup::Parts::Everything)?;
    }
    let mut failed = Vec::new();
    let is_here = |part: &str| if all { !BESIDE.contains(&part) } else { names.contains(&part) };
    for (part, run) in PARTS.iter().filter(|(part, _)| is_here(part)) {
        if *part == EQUIPPED
            && let Some(setup) = beside.take()
        {
            setup.finish()?;
            let words: Vec<&str> = ["test"].into_iter().chain(BESIDE).collect();
            beside = Some(Beside::start(&words)?);
        }
        if *part == ALONE
            && let Some(beside) = beside.take()
            && let Err(error) = beside.finish()
        {
            failed.push(format!("{error:#}"));
        }
        let start = Instant::now();
        let result = run();
        headline(&format!("part `{part}`: {:.0} s", start.elapsed().as_secs_f64()));
        if let Err(error) = result {
            println!("failed: {error:#}");
            failed.push(format!("{part}: {error:#}"));
        }
    }
    if failed.is_empty() { Ok(()) } else { bail!("failed parts: {}\n{}", failed.len(), failed.join("\n")) }
}

/// Another run of this program; what it prints is shown when it has ended.
struct Beside {
    words: String,
    child: Child,
    printed: PathBuf,
}

impl Beside {
    fn start(words: &[&str]) -> Result<Self> {
        let printed = paths::target().join("beside.log");
        std::fs::create_dir_all(paths::target())?;
        let file = File::create(&printed).with_context(|| format!("cannot write {}", printed.display()))?;
        let program = std::env::current_exe().context("this program has no file")?;
        let mut command = Command::new(program);
        command.args(words).stdin(Stdio::null()).stdout(file.try_clone()?).stderr(file);
        let child = command.spawn().context("cannot start a second run of this program")?;
        Ok(Self { words: words.join(" "), child, printed })
    }

    fn finish(mut self) -> Result<()> {
        let status = self.child.wait()?;
        headline(&format!("beside: {}", self.words));
        print!("{}", String::from_utf8_lossy(&std::fs::read(&self.printed)?));
        if !status.success() {
            bail!("{}: see above", self.words);
        }
        Ok(())
    }
}

fn format() -> Result<()> {
    headline("formatting");
    run_command(cargo("fmt").args(["--all", "--check", "--", "-l"]))?;
    run_command(cargo("fmt").args(["--all", "--check", "--", "-l"]).current_dir(paths::boards()))
}

fn clippy() -> Result<()> {
    headline("clippy");
    // `--all-features`: the boards' clippy does not look at the crates that they share with the PC.
    let every_target = ["--workspace", "--all-targets", "--all-features"];
    run_command(cargo("clippy").arg("--quiet").args(every_target).args(["--", "-D", "warnings"]))?;
    // What takes the place of a feature that is off is compiled without it only.
    let bare = ["--package", "fre-cli", "--no-default-features", "--all-targets"];
    run_command(cargo("clippy").arg("--quiet").args(bare).args(["--", "-D", "warnings"]))
}

fn doc() -> Result<()> {
    headline("documentation");
    // All features, as Clippy has them: what it has looked through of others' crates serves here as well.
    let every_page = ["--quiet", "--no-deps", "--workspace", "--all-features"];
    run_command(cargo("doc").args(every_page).env("RUSTDOCFLAGS", "-D warnings"))
}

fn clippy_on_target(cross: &Cross) -> Result<()> {
    headline("clippy, target");
    // Not `--all-targets`: that makes tests of binaries too, and those need `std`.
    // Not `--workspace` either: the chip library is made for one chip at a time. What runs in QEMU are the default
    // members; the others are the part `boards`.
    let every_target = ["--lib", "--bins", "--tests", "--features", "mps2/bench"];
    run_command(cross.cargo("clippy").args(["--quiet", "--release"]).args(every_target).args(["--", "-D", "warnings"]))
}

fn pc() -> Result<()> {
    headline("tests on this PC");
    // `fre gripper` and its like are tested on the firmware, too: cargo builds the program for tests of its own package only.
    let tests = || {
        let mut tests = cargo("test");
        tests.args(["--no-fail-fast", "--workspace", "--exclude", "system-tests"]).args(FEATURES);
        tests.env("FRE_FIRMWARE_ELF", firmware::image(firmware::SIMULATED));
        if find("ccx").is_some() {
            tests.args(["--features", "fre-cli/fea"]);
        }
        tests
    };
    // Parts that run at the same time build the image meanwhile.
    run_command(tests().arg("--no-run"))?;
    firmware::show(firmware::SIMULATED)?;
    run_command(&mut tests())
}

fn target() -> Result<()> {
    let cross = &Cross::find()?;
    // Parts that run at the same time wait for it.
    firmware::show(firmware::SIMULATED)?;
    clippy_on_target(cross)?;
    headline("tests on the target, in QEMU");
    on_target::run(&build_on_target(cross)?)?;
    headline("the estimator's image, searched for panics");
    panic_free::check(cross)
}

fn system() -> Result<()> {
    let image = firmware::show(firmware::SIMULATED)?;
    headline("system tests: firmware, servo and host together");
    // `--workspace`, not `--package`: the features of shared dependencies stay as they were, and nothing is built again.
    let mut tests = cargo("test");
    tests.args(["--no-fail-fast", "--workspace"]).args(FEATURES).env("FRE_FIRMWARE_ELF", &image);
    cycles::provide(&mut tests, &[firmware::MEASURED])?;
    for test in system_tests()? {
        tests.args(["--test", &test]);
    }
    run_command(&mut tests)
}

fn boards() -> Result<()> {
    let cross = &Cross::find()?;
    portable::check(portable::Systems::First)?;
    // The chip library is built once per chip and way, which takes minutes the first time.
    for board in fre_boards::ALL.iter().filter(|board| board.name != firmware::SIMULATED) {
        firmware::show(board.name)?;
    }
    // What boards have of their own is alike, and a second look takes their chip's library once more: the others' are for a release.
    firmware::lint(cross, firmware::MEASURED)?;
    new_board::check(cross)
}

/// The test programs of the system: the files of their folder, and the folders in it that have a `main.rs`.
fn system_tests() -> Result<Vec<String>> {
    let folder = paths::root().join("tests/system/tests");
    let name = |path: &Path| {
        let is_program = path.extension().is_some_and(|ending| ending == "rs") || path.join("main.rs").exists();
        path.file_stem().filter(|_| is_program)?.to_str().map(str::to_owned)
    };
    let files = folder.read_dir().with_context(|| format!("cannot list {}", folder.display()))?;
    let mut names: Vec<String> = files.filter_map(|file| name(&file.ok()?.path())).collect();
    names.sort();
    Ok(names)
}

/// Builds the test image; returns the ELF's path, whose name has a hash that only cargo knows.
fn build_on_target(cross: &Cross) -> Result<PathBuf> {
    let mut build = cross.cargo("test");
    build.args(["--quiet", "--release", "--package", "on-target", "--lib", "--no-run"]);
    built(&mut build)?
        .iter()
        .find_map(|message| message["executable"].as_str().map(PathBuf::from))
        .with_context(|| format!("cargo named no test image for {TRIPLE}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn system_tests_are_files_and_folders_with_a_program() {
        let names = system_tests().unwrap();
        // A file, a folder, and a folder of scripts.
        let found = ["friction", "live_page", "sdk"].map(|name| names.iter().any(|found| found == name));
        assert_eq!(found, [true, true, false], "{names:?}");
    }
}
