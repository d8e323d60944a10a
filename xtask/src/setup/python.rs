//! A virtual environment with the references of the tests: ROBOTIS' own Dynamixel SDK, and the MCAP reader and the
//! message types of Foxglove.

use super::apt::{self, Otherwise};
use crate::command::{find, output, succeeds};
use crate::paths;
use anyhow::{Context, Result};
use std::fs;
use std::process::Command;

/// The pinned requirements; a change makes the environment anew.
const REQUIREMENTS: &[&str] =
    &["dynamixel-sdk==4.1.0", "pyserial==3.5", "mcap==1.6.0", "foxglove-schemas-protobuf==0.4.0"];

/// Makes the environment if it is not there.
pub fn provide() -> Result<String> {
    let folder = paths::target().join("python");
    let stamp = folder.join("requirements.txt");
    let wanted = REQUIREMENTS.join("\n");
    if !paths::python().exists() || fs::read_to_string(&stamp).ok().as_deref() != Some(&wanted) {
        println!("Python packages: making target/python");
        if folder.exists() {
            fs::remove_dir_all(&folder).context("cannot remove the old target/python")?;
        }
        // Debian splits pip's bootstrap from python3.
        if find("python3").is_none() || !succeeds(Command::new("python3").args(["-c", "import ensurepip, venv"])) {
            apt::install(&["python3", "python3-venv"], Otherwise::Fail)?;
        }
        output(Command::new("python3").args(["-m", "venv"]).arg(&folder))?;
        output(
            Command::new(paths::python())
                .args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-input"])
                .args(REQUIREMENTS),
        )?;
        fs::write(&stamp, &wanted)?;
    }
    Ok(REQUIREMENTS.join(", "))
}
