//! Builds for this PC, all with the same features.

use std::env;
use std::process::Command;

use crate::{paths, setup};

/// Features of the tests on this PC, the same in every part: so that nothing is built a second time with others.
pub const FEATURES: [&str; 2] = [
    "--features",
    "fre-cli/log,fre-cli/outline,fre-cli/parquet,fre-cli/probe,fre-cli/python,fre-cli/qemu,fre-cli/record,fre-cli/ros2,\
     fre-cli/terminal,fre-cli/web,fre-gripper/python,fre-ros2/dds,fre-ros2/python,system-tests/browser,\
     system-tests/python,system-tests/qemu,system-tests/ros2",
];

/// The feature of CalculiX's tests.
const CALCULIX: &str = "fea";

/// The cargo that runs this program, for the PC, at the repository's root.
pub fn cargo(subcommand: &str) -> Command {
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.arg(subcommand).current_dir(paths::root()).env("FRE_PYTHON", setup::python::TESTS.python());
    // A test program that is left out fails, but for CalculiX's: that is installed on request only (`setup --fea`).
    command.env("FRE_LEFT_OUT", CALCULIX);
    command
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Packages of which a program with these features is built.
    fn packages(features: &[&str]) -> Vec<String> {
        let mut tree = cargo("tree");
        tree.args(["--locked", "--package", "fre-cli", "--edges", "normal,build", "--prefix", "none"]).args(features);
        let output = tree.output().expect("cargo tree");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let lines = String::from_utf8(output.stdout).expect("names");
        lines.lines().filter_map(|line| Some(line.split_once(' ')?.0.to_owned())).collect()
    }

    #[test]
    fn the_command_is_built_without_what_few_use() {
        let named = |features: &[&str], names: &[&'static str]| -> Vec<&'static str> {
            let built = packages(features);
            names.iter().copied().filter(|name| built.iter().any(|package| package == name)).collect()
        };
        let rare = ["defmt-decoder", "parquet", "probe-rs", "ratatui", "ros2-client"];
        assert_eq!(named(&[], &rare), [""; 0], "by default");
        assert_eq!(named(&["--all-features"], &rare), rare, "the names are right");
        let gripper = ["axum", "chess-corners", "mcap", "postcard-rpc", "serialport"];
        assert_eq!(named(&[], &gripper), gripper, "page, photographs, recordings and the gripper's link are there");
        assert_eq!(named(&["--no-default-features"], &gripper), [""; 0], "for cases only");
    }
}
