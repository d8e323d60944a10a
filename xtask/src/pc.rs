//! Builds for this PC, all with the same features.

use std::env;
use std::process::Command;

use crate::{paths, setup};

/// Features of the tests on this PC, the same in every part: so that nothing is built a second time with others.
pub const FEATURES: [&str; 2] = [
    "--features",
    "fre-cli/outline,fre-cli/parquet,fre-cli/probe,fre-cli/python,fre-cli/qemu,fre-cli/record,fre-cli/ros2,fre-cli/web,\
     fre-gripper/python,fre-ros2/dds,fre-ros2/python,system-tests/browser,system-tests/python,system-tests/qemu,\
     system-tests/ros2",
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
