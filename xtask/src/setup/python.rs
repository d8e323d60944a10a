//! Virtual environments with pinned Python packages.

use super::apt::{self, Otherwise};
use crate::command::{find, output, succeeds};
use crate::paths;
use anyhow::{Context, Result};
use std::fs;
use std::path::PathBuf;
use std::process::Command;

/// A virtual environment.
#[derive(Debug)]
pub struct Environment {
    /// Its folder in `target`.
    name: &'static str,
    /// The pinned requirements; a change makes the environment anew.
    requirements: &'static [&'static str],
}

/// The references of the tests: ROBOTIS' own Dynamixel SDK, the MCAP reader and the message types of Foxglove, Eclipse Cyclone DDS, ROS'
/// parser of URDF, and trimesh.
pub const TESTS: Environment = Environment {
    name: "python",
    requirements: &[
        "dynamixel-sdk==4.1.0",
        "pyserial==3.5",
        "mcap==1.6.0",
        "foxglove-schemas-protobuf==0.4.0",
        "cyclonedds==11.0.1",
        "urdf-parser-py==0.0.4",
        "trimesh==5.2.0",
        "numpy==2.4.6",
    ],
};

/// The peer of the bench.
pub const PEER: Environment = Environment { name: "peer", requirements: &["casadi==3.8.2"] };

/// What builds the Python package, and what its tests need beside it.
pub const PACKAGE: Environment = Environment {
    name: "python-package",
    requirements: &[
        "maturin==1.16.0",
        "numpy==2.4.6",
        "pytest==9.2.0",
        "mypy==2.4.1",
        "matplotlib==3.11.2",
        "pandas==3.1.1",
        "pyarrow==26.0.1",
        "scipy==1.17.1",
        "nbclient==0.11.0",
        "nbformat==5.11.1",
        "ipykernel==7.4.0",
        "ray==2.60.0",
    ],
};

impl Environment {
    /// The interpreter.
    pub fn python(&self) -> PathBuf {
        paths::target().join(self.name).join("bin/python")
    }

    /// Makes the environment if it is not there; what it holds.
    pub fn provide(&self) -> Result<String> {
        let folder = paths::target().join(self.name);
        let stamp = folder.join("requirements.txt");
        let wanted = self.requirements.join("\n");
        if !self.python().exists() || fs::read_to_string(&stamp).ok().as_deref() != Some(&wanted) {
            println!("Python packages: making target/{}", self.name);
            if folder.exists() {
                fs::remove_dir_all(&folder).with_context(|| format!("cannot remove the old target/{}", self.name))?;
            }
            // Debian splits pip's bootstrap from python3.
            if find("python3").is_none() || !succeeds(Command::new("python3").args(["-c", "import ensurepip, venv"])) {
                apt::install(&["python3", "python3-venv"], Otherwise::Fail)?;
            }
            output(Command::new("python3").args(["-m", "venv"]).arg(&folder))?;
            output(
                Command::new(self.python())
                    .args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-input"])
                    .args(self.requirements),
            )?;
            fs::write(&stamp, &wanted)?;
        }
        Ok(self.requirements.join(", "))
    }
}
