//! `cargo xtask fuzz`: builds the fuzz targets with libFuzzer's instrumentation and runs each for a while.
//!
//! The fuzzer is a library (`libfuzzer-sys`), the instrumentation a pass of the compiler in use: neither `cargo-fuzz` nor a
//! nightly toolchain is needed. Without a nightly there is no address sanitizer; the code has no `unsafe` it could watch.

use crate::command::{self, headline};
use crate::cross::{clear_inherited, host_of};
use crate::paths;
use anyhow::{Context, Result, bail};
use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Seconds per target without `--seconds`.
const SECONDS: u32 = 60;
/// Seconds after which one input counts as a hang.
const HANG: u32 = 10;
/// The longest input, bytes: the formats' longest with room.
const LONGEST: u32 = 16_384;
/// The name of the driver's package and binary.
const DRIVER: &str = "fuzz-driver";

/// Edge counters and compared values, as libFuzzer reads them.
const FLAGS: &[&str] = &[
    "--cfg=fuzzing",
    "-Cpasses=sancov-module",
    "-Cllvm-args=-sanitizer-coverage-level=4",
    "-Cllvm-args=-sanitizer-coverage-inline-8bit-counters",
    "-Cllvm-args=-sanitizer-coverage-pc-table",
    "-Cllvm-args=-sanitizer-coverage-trace-compares",
];

/// What is asked for.
#[derive(Debug, PartialEq)]
struct Options<'a> {
    seconds: u32,
    /// All if empty.
    targets: Vec<&'a str>,
}

/// Builds and fuzzes; every target gets its time, then what was found is one error.
pub fn run(arguments: &[&str]) -> Result<()> {
    let options = parse(arguments)?;
    let folder = paths::target().join("fuzz");
    headline("fuzz targets");
    let targets = provide_seeds(&folder.join("corpus"))?;
    if let Some(unknown) = options.targets.iter().find(|name| !targets.iter().any(|target| target == *name)) {
        bail!("`{unknown}` is not a fuzz target; the targets are: {}", targets.join(", "));
    }
    let driver = build(&folder)?;

    let mut found = Vec::new();
    for target in targets.iter().filter(|name| options.targets.is_empty() || options.targets.contains(&name.as_str())) {
        headline(&format!("{target}, {} s", options.seconds));
        let before = findings(&folder.join("crashes"), target)?;
        let log = folder.join(format!("{target}.log"));
        let mut command = fuzzer(&driver, &folder, target, options.seconds)?;
        // The fuzzer tells of every input it keeps: thousands of lines.
        command.stderr(fs::File::create(&log).with_context(|| format!("cannot create {}", log.display()))?);
        let status = command.status().with_context(|| format!("cannot start `{}`", command::line(&command)))?;
        let told = fs::read(&log).with_context(|| format!("cannot read {}", log.display()))?;
        println!("{}", summary(&String::from_utf8_lossy(&told)));
        let after = findings(&folder.join("crashes"), target)?;
        let new: Vec<PathBuf> = after.into_iter().filter(|file| !before.contains(file)).collect();
        for file in &new {
            show(target, file)?;
        }
        if !status.success() && new.is_empty() {
            bail!("`{}` failed: {status}; what it said is in {}", command::line(&command), log.display());
        }
        found.extend(new);
    }
    if !found.is_empty() {
        bail!("{} input(s) failed; they are kept in {}", found.len(), folder.join("crashes").display());
    }
    println!("\nno input failed");
    Ok(())
}

fn parse<'a>(arguments: &[&'a str]) -> Result<Options<'a>> {
    let mut options = Options { seconds: SECONDS, targets: Vec::new() };
    let mut rest = arguments.iter();
    while let Some(&argument) = rest.next() {
        let seconds = match argument.strip_prefix("--seconds") {
            None if argument.starts_with('-') => {
                bail!("`{argument}` is not an option of fuzz; usage: cargo xtask fuzz [--seconds N] [TARGET ...]")
            }
            None => {
                options.targets.push(argument);
                continue;
            }
            Some("") => *rest.next().context("--seconds needs a number")?,
            Some(value) => value.strip_prefix('=').with_context(|| format!("`{argument}` is not an option of fuzz"))?,
        };
        options.seconds = match seconds.parse() {
            Ok(seconds) if seconds > 0 => seconds,
            _ => bail!("--seconds {seconds}: needed is a whole number of at least 1"),
        };
    }
    Ok(options)
}

/// Writes the seeds and returns the targets' names. What earlier runs found interesting stays beside them.
fn provide_seeds(corpus: &Path) -> Result<Vec<String>> {
    let targets = |arguments: &[&str]| {
        let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        command.args(["run", "--quiet", "--package", "fuzz-targets", "--"]).args(arguments);
        command::output(command.current_dir(paths::root()))
    };
    targets(&["seeds", &corpus.display().to_string()])?;
    Ok(targets(&["list"])?.lines().map(str::to_owned).collect())
}

/// Builds the driver; the flags go to the target's code only, not to build scripts and macros.
fn build(folder: &Path) -> Result<PathBuf> {
    let version = command::output(Command::new("rustc").arg("-vV"))?;
    let host = host_of(&version).context("the compiler does not name its host")?;
    let mut build = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    clear_inherited(&mut build);
    build.args(["build", "--quiet", "--release", "--target", host, "--target-dir"]).arg(folder.join("build"));
    build.current_dir(paths::root().join("fuzz/driver")).env("CARGO_ENCODED_RUSTFLAGS", FLAGS.join("\x1f"));
    command::run(&mut build)?;
    let driver = folder.join("build").join(host).join("release").join(DRIVER);
    println!("built with {}", version.lines().next().unwrap_or_default());
    Ok(driver)
}

/// The driver's command line for one target.
fn fuzzer(driver: &Path, folder: &Path, target: &str, seconds: u32) -> Result<Command> {
    let (corpus, crashes, place) = (folder.join("corpus"), folder.join("crashes"), folder.join("empty"));
    // A folder without files, so that a text which names a file finds none.
    for folder in [&crashes, &place] {
        fs::create_dir_all(folder).with_context(|| format!("cannot create {}", folder.display()))?;
    }
    let mut command = Command::new(driver);
    command.env("FRE_FUZZ_TARGET", target).current_dir(&place).stdin(std::process::Stdio::null());
    command.arg(corpus.join(target));
    command.args([format!("-max_total_time={seconds}"), format!("-timeout={HANG}"), format!("-max_len={LONGEST}")]);
    command.args(["-rss_limit_mb=2048", "-print_final_stats=1", "-verbosity=1"]);
    command.arg(format!("-artifact_prefix={}/{target}-", crashes.display()));
    let words = corpus.join(format!("{target}.dict"));
    if fs::metadata(&words).is_ok_and(|file| file.len() > 0) {
        command.arg(format!("-dict={}", words.display()));
    }
    Ok(command)
}

/// What became of a run, from the fuzzer's log: how much was tried, and why it stopped if an input failed.
fn summary(log: &str) -> String {
    let stat = |name: &str| {
        let line = log.lines().rev().find_map(|line| line.strip_prefix("stat::")?.strip_prefix(name));
        line.map_or("?", |rest| rest.trim_start_matches(':').trim()).to_owned()
    };
    let edges = log.lines().rev().find_map(|line| line.split("cov: ").nth(1)?.split(' ').next()).unwrap_or("?");
    let mut lines = vec![format!(
        "{} inputs ({} a second), {edges} edges covered, {} inputs new to the corpus, {} MB",
        stat("number_of_executed_units"),
        stat("average_exec_per_sec"),
        stat("new_units_added"),
        stat("peak_rss_mb"),
    )];
    // A panic's place and words, a hang, a signal.
    let mut rest = log.lines();
    while let Some(line) = rest.next() {
        if line.contains("panicked at") {
            lines.push(line.trim().to_owned());
            lines.extend(rest.next().map(|line| format!("  {}", line.trim())));
        } else if line.starts_with("==") && line.contains("ERROR") {
            lines.push(line.to_owned());
        }
    }
    lines.join("\n")
}

/// Inputs kept for a target, in a fixed order.
fn findings(crashes: &Path, target: &str) -> Result<Vec<PathBuf>> {
    let Ok(entries) = fs::read_dir(crashes) else {
        return Ok(Vec::new());
    };
    let mut files = Vec::new();
    for entry in entries {
        let path = entry.context("cannot list the kept inputs")?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let kind = name.strip_prefix(target).and_then(|rest| rest.strip_prefix('-')).unwrap_or_default();
        if ["crash-", "timeout-", "oom-", "leak-"].iter().any(|start| kind.starts_with(start)) {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

/// Prints an input that failed, and how to run it again.
fn show(target: &str, file: &Path) -> Result<()> {
    const SHOWN: usize = 2000;
    let bytes = fs::read(file).with_context(|| format!("cannot read {}", file.display()))?;
    println!("\nkept: {} ({} bytes)", file.display(), bytes.len());
    let first = &bytes[..bytes.len().min(SHOWN)];
    let shown = match std::str::from_utf8(first) {
        Ok(text) if !text.contains(|letter: char| letter.is_control() && letter != '\n') => text.replace('\n', "\n  "),
        _ => first.escape_ascii().to_string(),
    };
    println!("  {shown}{}", if bytes.len() > SHOWN { " …" } else { "" });
    println!("again: cargo run -p fuzz-targets -- {target} {}", file.display());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_read() {
        assert_eq!(parse(&[]).unwrap(), Options { seconds: 60, targets: vec![] });
        assert_eq!(parse(&["--seconds", "5", "case"]).unwrap(), Options { seconds: 5, targets: vec!["case"] });
        assert_eq!(parse(&["--seconds=7"]).unwrap().seconds, 7);
        for bad in [&["--seconds"][..], &["--seconds", "0"], &["--seconds=-1"], &["--secondsx"], &["--forever"]] {
            assert!(parse(bad).is_err(), "{bad:?}");
        }
    }

    #[test]
    fn a_summary_says_how_much_was_tried_and_what_failed() {
        let log = "INFO: Loaded 1 modules\n#2\tINITED cov: 17 ft: 18 corp: 1/1b exec/s: 0 rss: 26Mb\n\
            #9 NEW    cov: 2609 ft: 8456 corp: 13/632Kb lim: 965 exec/s: 8194 rss: 32Mb\n\
            thread '<unnamed>' (1) panicked at src/case.rs:3:5:\nno line\n==12== ERROR: libFuzzer: deadly signal\n\
            stat::number_of_executed_units: 73897\nstat::average_exec_per_sec:     8210\n\
            stat::new_units_added:          11\nstat::peak_rss_mb:              32\n";
        let lines: Vec<String> = summary(log).lines().map(str::to_owned).collect();
        assert_eq!(lines[0], "73897 inputs (8210 a second), 2609 edges covered, 11 inputs new to the corpus, 32 MB");
        assert!(lines[1].contains("panicked at src/case.rs:3:5") && lines[2] == "  no line", "{lines:?}");
        assert_eq!(lines[3], "==12== ERROR: libFuzzer: deadly signal");
        assert_eq!(summary(""), "? inputs (? a second), ? edges covered, ? inputs new to the corpus, ? MB");
    }

    #[test]
    fn kept_inputs_belong_to_their_target() {
        let folder = env::temp_dir().join(format!("xtask-fuzz-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        for name in ["case-crash-1", "case-timeout-2", "case-two-crash-3", "other-crash-4", "notes"] {
            fs::write(folder.join(name), "x").unwrap();
        }
        let names = |target| {
            let files = findings(&folder, target).unwrap();
            files.iter().map(|file| file.file_name().unwrap().to_str().unwrap().to_owned()).collect::<Vec<_>>()
        };
        assert_eq!(names("case"), ["case-crash-1", "case-timeout-2"]);
        assert_eq!(names("case-two"), ["case-two-crash-3"]);
        assert!(findings(&folder.join("absent"), "case").unwrap().is_empty());
        fs::remove_dir_all(&folder).unwrap();
    }
}
