//! How long the command takes to build and how large it is, for people who change it and people who install it; and `cargo test` alone.

use std::fs;
use std::fs::OpenOptions;
use std::io::Write as _;
use std::path::Path;
use std::process::Command;
use std::thread::available_parallelism;
use std::time::Instant;

use anyhow::{Context, Result, bail};

/// Ticks of `/proc/self/stat` in a second.
const TICKS: f64 = 100.0;

/// What a build took.
#[derive(Clone, Copy, Debug)]
struct Time {
    /// By the clock, s.
    clock: f64,
    /// Of all processors, s; `None` where the system does not say.
    processors: Option<f64>,
}

/// Builds a copy of what git tracks: from nothing, after a change of one line in the library, and as `cargo install` does. Tests it by
/// `cargo test` alone.
pub fn measure() -> Result<String> {
    let folder = tempfile::tempdir()?;
    let copy = folder.path().join("copy");
    copy_to(&copy)?;
    let cores = available_parallelism().map_or(1, usize::from);
    let mut text = format!("{:<58}  {:>8}  {:>15}\n", format!("on {cores} cores"), "clock, s", "all cores, s");
    for (name, features) in [("default features", &[][..]), ("--no-default-features", &["--no-default-features"])] {
        let target = folder.path().join("target");
        let build = || {
            let mut build = cargo(&copy, &target, "build");
            build.args(["--package", "fre-cli", "--bin", "fre"]).args(features);
            build
        };
        text += &row(&format!("fre from nothing, {name}"), timed(build())?);
        change(&copy)?;
        text += &row(&format!("after a change of one line in the library, {name}"), timed(build())?);
        fs::remove_dir_all(&target)?;
    }
    let (target, installed) = (folder.path().join("target"), folder.path().join("installed"));
    let mut install = cargo(&copy, &target, "install");
    install.args(["--locked", "--path", "host/cli", "--root"]).arg(&installed);
    text += &row("cargo install --path host/cli", timed(install)?);
    let program = installed.join("bin").join(format!("fre{}", std::env::consts::EXE_SUFFIX));
    let bytes = fs::metadata(&program).with_context(|| format!("{} was not installed", program.display()))?.len();
    text += &format!("size of the installed command: {:.1} MB\n", bytes as f64 / 1e6);
    let (time, said) = test_alone(&copy, &target)?;
    text += &row("cargo test", time);
    Ok(text + &said)
}

/// `cargo test` as on a laptop that has Rust and no QEMU, by the user who runs this. Returns what it took, how many tests passed, and
/// what it says that it left out.
fn test_alone(copy: &Path, target: &Path) -> Result<(Time, String)> {
    let mut test = cargo(copy, target, "test");
    for (name, _) in std::env::vars_os().filter(|(name, _)| name.to_string_lossy().starts_with("FRE_")) {
        test.env_remove(name);
    }
    // As it goes on, its words go to the file: a pipe that nobody reads would stop it.
    let file = target.with_file_name("words");
    test.stdout(fs::File::create(&file)?);
    let time = timed(test).with_context(|| fs::read_to_string(&file).unwrap_or_default())?;
    Ok((time, outcome(&fs::read_to_string(&file)?)?))
}

/// What a run of `cargo test` says, in short. It must leave out what needs QEMU, and say so.
fn outcome(words: &str) -> Result<String> {
    let passed = |line: &str| line.strip_prefix("test result: ok. ")?.split(' ').next()?.parse::<usize>().ok();
    let count: usize = words.lines().filter_map(passed).sum();
    let left_out: Vec<&str> = words.lines().filter(|line| line.starts_with("left out: ")).collect();
    if count == 0 || !left_out.iter().any(|line| line.contains("QEMU")) {
        bail!("{count} tests passed, and what needs QEMU was not named as left out:\n{words}");
    }
    Ok(format!("{count} tests passed\n{}\n", left_out.join("\n")))
}

fn row(what: &str, time: Time) -> String {
    let processors = time.processors.map_or_else(|| "–".to_owned(), |seconds| format!("{seconds:.0}"));
    format!("{what:<58}  {:>8.0}  {processors:>15}\n", time.clock)
}

/// Cargo in the copy, as people have it: what this process was told about incremental builds does not count.
fn cargo(copy: &Path, target: &Path, subcommand: &str) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(copy).args([subcommand, "--quiet"]).env("CARGO_TARGET_DIR", target);
    command.env_remove("CARGO_INCREMENTAL");
    command
}

fn timed(mut command: Command) -> Result<Time> {
    let (begin, before) = (Instant::now(), of_children());
    let status = command.status().with_context(|| format!("cannot start {command:?}"))?;
    if !status.success() {
        bail!("{command:?} failed: {status}");
    }
    let clock = begin.elapsed().as_secs_f64();
    Ok(Time { clock, processors: before.zip(of_children()).map(|(before, after)| after - before) })
}

/// Seconds that processors have spent on this process's children that have ended; `None` where the system does not say.
fn of_children() -> Option<f64> {
    spent(&fs::read_to_string("/proc/self/stat").ok()?)
}

/// The same in a line of `/proc/self/stat`. The program's name is in brackets and may have some itself.
fn spent(line: &str) -> Option<f64> {
    let (_, fields) = line.rsplit_once(')')?;
    let ticks: Vec<f64> = fields.split_whitespace().skip(13).take(2).filter_map(|field| field.parse().ok()).collect();
    let [user, system] = ticks[..] else { return None };
    Some((user + system) / TICKS)
}

/// Copies the files that git tracks, as they are now.
fn copy_to(copy: &Path) -> Result<()> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let listed =
        Command::new("git").current_dir(&root).args(["ls-files", "-z"]).output().context("cannot start git")?;
    if !listed.status.success() {
        bail!("git names no files of {}: {}", root.display(), String::from_utf8_lossy(&listed.stderr).trim());
    }
    for name in String::from_utf8(listed.stdout)?.split_terminator('\0') {
        let (from, to) = (root.join(name), copy.join(name));
        if let (true, Some(folder)) = (from.is_file(), to.parent()) {
            fs::create_dir_all(folder)?;
            fs::copy(&from, &to).with_context(|| format!("cannot copy {}", from.display()))?;
        }
    }
    Ok(())
}

/// Adds a line of code to the library.
fn change(copy: &Path) -> Result<()> {
    let file = copy.join("host/fre/src/lib.rs");
    let lines = fs::read_to_string(&file)?.lines().count();
    let mut file = OpenOptions::new().append(true).open(&file)?;
    Ok(writeln!(file, "#[doc(hidden)] pub const LINE_{lines}: usize = {lines};")?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_out_must_be_said() {
        let passed = "test result: ok. 7 passed; 0 failed\ntest result: ok. 5 passed; 0 failed\n";
        let line =
            "left out: 1 test program of a (b), feature `qemu`: the firmware and QEMU; `cargo xtask test` runs them\n";
        assert_eq!(outcome(&format!("{line}{passed}")).unwrap(), format!("12 tests passed\n{line}"));
        assert!(outcome(passed).is_err() && outcome(line).is_err());
    }

    #[test]
    fn time_of_children_is_read_behind_any_name() {
        let line = "7 (a) b) S 1 2 3 4 5 6 7 8 9 10 11 12 250 50 20 0 1 0";
        assert_eq!(spent(line), Some(3.0));
        assert_eq!(spent("7 (a) S 1 2"), None);
    }

    #[test]
    fn the_copy_has_the_command_and_a_line_more() {
        let folder = tempfile::tempdir().unwrap();
        copy_to(folder.path()).unwrap();
        assert!(folder.path().join("host/cli/src/main.rs").is_file() && folder.path().join("Cargo.lock").is_file());
        let library = folder.path().join("host/fre/src/lib.rs");
        let count = |file: &Path| fs::read_to_string(file).unwrap().lines().count();
        let before = count(&library);
        change(folder.path()).unwrap();
        assert_eq!(count(&library), before + 1);
    }
}
