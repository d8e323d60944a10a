//! `cargo xtask demo`: builds the gripper's image for QEMU and the `fre` command, and lets `fre demo` show them.

use crate::command::{headline, run as run_command};
use crate::{firmware, paths, setup};
use anyhow::{Context, Result, bail};
use fre_log::Log;
use std::env;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Where the report goes, from the repository's root.
const REPORT: &str = "target/demo";
/// Lines of the firmware's log that are shown when something has failed.
const LAST_LINES: usize = 20;

/// What is asked for.
#[derive(Debug, PartialEq)]
struct Options<'a> {
    /// Passed on: `fre` says what is allowed.
    seconds: Option<&'a str>,
    /// Likewise.
    physics: Option<&'a str>,
    live: bool,
}

/// Builds and shows.
pub fn run(arguments: &[&str]) -> Result<()> {
    let options = parse(arguments)?;
    headline("set-up");
    setup::run(setup::Parts::Firmware)?;
    let image = firmware::show(firmware::SIMULATED)?;
    headline("fre");
    let fre = ["--release", "--package", "fre-cli", "--bin", "fre"];
    let features = ["--features", if options.live { "web" } else { "gripper" }];
    run_command(cargo("build").arg("--quiet").args(fre).args(features))?;
    println!("built");

    headline("demo");
    let mut demo = cargo("run");
    demo.arg("--quiet")
        .args(fre)
        .args(features)
        .args(["--", "demo", "--report", REPORT, "--force", "--firmware"])
        .arg(&image);
    if let Some(seconds) = options.seconds {
        demo.args(["--seconds", seconds]);
    }
    if let Some(physics) = options.physics {
        demo.args(["--physics", physics]);
    }
    if options.live {
        demo.arg("--live");
    }
    let outcome = run_command(&mut demo);
    let log = decode(&image)?;
    if outcome.is_err() && !log.is_empty() {
        headline("the end of the firmware's log");
        println!("{}", log[log.len().saturating_sub(LAST_LINES)..].join("\n"));
    }
    outcome
}

fn parse<'a>(arguments: &[&'a str]) -> Result<Options<'a>> {
    let mut options = Options { seconds: None, physics: None, live: false };
    let mut rest = arguments.iter();
    while let Some(&argument) = rest.next() {
        match argument {
            "--live" => options.live = true,
            "--seconds" => options.seconds = Some(rest.next().context("--seconds needs a number")?),
            "--physics" => options.physics = Some(rest.next().context("--physics needs paper or extended")?),
            _ => match argument.split_once('=') {
                Some(("--seconds", seconds)) => options.seconds = Some(seconds),
                Some(("--physics", physics)) => options.physics = Some(physics),
                _ => bail!(
                    "`{argument}` is not an option of demo; usage: cargo xtask demo [--seconds N] \
                     [--physics paper|extended] [--live]"
                ),
            },
        }
    }
    Ok(options)
}

/// The cargo that runs this program, for the PC, at the repository's root.
fn cargo(subcommand: &str) -> Command {
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.arg(subcommand).current_dir(paths::root());
    command
}

/// Turns the firmware's log, if the demo got so far, into text beside it.
fn decode(image: &Path) -> Result<Vec<String>> {
    let folder = paths::root().join(REPORT);
    let Ok(frames) = fs::read(folder.join("firmware.defmt")) else {
        return Ok(Vec::new());
    };
    let lines = Log::of(&fs::read(image).context("cannot read the image")?)?.lines(&frames);
    let lines: Vec<String> = lines.iter().map(ToString::to_string).collect();
    fs::write(folder.join("firmware.log"), lines.join("\n") + "\n").context("cannot write the firmware's log")?;
    Ok(lines)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_read() {
        let seconds = |words: &[&'static str]| parse(words).map(|options| options.seconds);
        assert_eq!(seconds(&[]).unwrap(), None);
        assert_eq!(seconds(&["--seconds", "8"]).unwrap(), Some("8"));
        assert_eq!(seconds(&["--seconds=8"]).unwrap(), Some("8"));
        assert!(seconds(&["--seconds"]).is_err());
        let physics = |words: &[&'static str]| parse(words).map(|options| options.physics);
        assert_eq!(physics(&["--physics", "paper"]).unwrap(), Some("paper"));
        assert_eq!(physics(&["--physics=paper"]).unwrap(), Some("paper"));
        assert!(physics(&["--physics"]).is_err());
        assert!(seconds(&["8"]).unwrap_err().to_string().contains("`8`"));
        assert!(parse(&["--live"]).unwrap().live);
    }
}
