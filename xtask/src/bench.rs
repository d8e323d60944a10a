//! `cargo xtask bench`: builds the target's images and starts the bench (`tests/bench`), which measures.

use crate::command::{headline, run as run_command};
use crate::cross::Cross;
use crate::pc::{FEATURES, cargo};
use crate::{cycles, firmware, paths, setup};
use anyhow::{Context, Result};
use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The images of the part `target`, by the features that they are built with.
const IMAGES: [(&str, &[&str]); 2] = [
    ("bench", &["bench-reduced", "bench-rubbing", "bench-remembering", "bench-paper", "bench-empty"]),
    ("bench-ribs", &["bench-ribs"]),
];

/// Hands the arguments on, with the images and the Python that the wanted parts need.
pub fn run(arguments: &[&str]) -> Result<()> {
    if arguments == ["ros2"] {
        return ros2();
    }
    // Refused, or answered (`--help`), before anything is built for the target.
    run_command(bench().arg("--check").args(arguments))?;
    if arguments.iter().any(|argument| ["--help", "-h"].contains(argument)) {
        return Ok(());
    }
    let parts = parts(arguments);
    let wanted = |part| parts.is_empty() || parts.contains(&part);
    headline("set-up");
    setup::run(setup::Parts::Firmware)?;
    let mut command = bench();
    if wanted("rates") {
        let boards: Vec<&str> = fre_boards::ALL.iter().map(|board| board.name).collect();
        let boards: Vec<&str> = boards.into_iter().filter(|board| *board != firmware::SIMULATED).collect();
        let twins = boards.iter().map(|board| firmware::twin(board)).collect::<Result<Vec<_>>>()?;
        command.env("FRE_TWIN_IMAGES", env::join_paths(twins).context("a folder's name has a colon")?);
        cycles::provide(&mut command, &boards)?;
    }
    if wanted("peer") {
        match setup::python::PEER.provide() {
            Ok(_) => drop(command.arg("--peer-python").arg(setup::python::PEER.python())),
            Err(error) => println!("left out: CasADi + IPOPT: {error:#}"),
        }
    }
    if wanted("target") {
        let cross = Cross::find()?;
        let (folder, opt_level) = images(&cross)?;
        command.arg("--images").arg(folder).args(["--opt-level", &opt_level, "--rustc", &cross.rustc_version()?]);
    }
    run_command(command.args(arguments))
}

/// A minute of forces at 500 Hz to Eclipse Cyclone DDS: what is lost when it is reliable (nothing may be), and when it is not. It is the
/// tests' program, for longer: the bench itself needs no DDS.
fn ros2() -> Result<()> {
    setup::run(setup::Parts::Everything)?;
    let mut test = cargo("test");
    test.args(["--quiet", "--workspace"]).args(FEATURES).args(["--test", "cyclone", "--", "--nocapture", "topics"]);
    run_command(test.env("FRE_ROS2_SECONDS", "60"))
}

/// The parts among the arguments: all words but options and their values.
fn parts<'a>(arguments: &[&'a str]) -> Vec<&'a str> {
    let mut parts = Vec::new();
    let mut words = arguments.iter();
    while let Some(&word) = words.next() {
        if !word.starts_with('-') {
            parts.push(word);
        } else if !word.contains('=') {
            words.next();
        }
    }
    parts
}

/// The bench, built as users build.
fn bench() -> Command {
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(paths::root()).args(["run", "--quiet", "--release", "--package", "fre-bench", "--"]);
    command
}

/// Builds the images; their folder and optimisation level.
fn images(cross: &Cross) -> Result<(PathBuf, String)> {
    let mut built = Vec::new();
    for (features, images) in IMAGES {
        let mut build = cross.cargo("build");
        // With the lists that are measured: those of an image have room for ribs.
        build.args(["--quiet", "--release", "--package", "mps2", "--no-default-features", "--features", features]);
        for image in images {
            build.args(["--bin", image]);
        }
        built.extend(crate::cross::built(&mut build)?);
    }
    let image = built.iter().find(|message| message["executable"].is_string()).context("cargo named no image")?;
    let folder = image["executable"].as_str().and_then(|path| Path::new(path).parent());
    let opt_level = image["profile"]["opt_level"].as_str().context("cargo named no optimisation level")?;
    Ok((folder.context("an image without a folder")?.to_owned(), opt_level.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_the_words_that_belong_to_no_option() {
        assert!(parts(&[]).is_empty() && parts(&["--json", "peer"]).is_empty());
        assert_eq!(parts(&["pc", "--json", "a.json", "target"]), ["pc", "target"]);
        assert_eq!(parts(&["--json=a.json", "pc"]), ["pc"]);
    }
}
