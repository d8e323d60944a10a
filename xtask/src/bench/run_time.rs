//! The whole gripper at work: system tests that print figures, run by name.

use crate::{command, firmware, paths, suite};
use anyhow::Result;
use std::env;
use std::process::Command;

/// A campaign of faults in QEMU: instructions of the dearest tick, and the rate that each board reaches.
pub fn rates() -> Result<()> {
    let image = firmware::show(firmware::SIMULATED)?;
    command::run(test("cost", "the_dearest_tick_and_the_rates").env("FRE_FIRMWARE_ELF", image))
}

/// An hour of virtual time, judged at every tick.
pub fn soak() -> Result<()> {
    command::run(&mut test("faults", "an_hour"))
}

/// Synthetic calibrations; fails if the recommended ones do not keep what is stated.
pub fn calibrations() -> Result<()> {
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(paths::root());
    command::run(command.args(["run", "--quiet", "--release", "--package", "host", "--example", "calibration"]))
}

fn test(program: &str, name: &str) -> Command {
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(paths::root());
    // `--workspace`: as the suite builds them.
    command.args(["test", "--quiet", "--workspace", "--test", program]).args(suite::FEATURES);
    command.args([name, "--", "--exact", "--nocapture"]);
    command
}
