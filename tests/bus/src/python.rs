//! The Python that has the references of the tests.

use std::path::{Path, PathBuf};
use std::process::Command;

/// The interpreter with ROBOTIS' own SDK (`dynamixel-sdk` on PyPI): `FRE_PYTHON`, or the one that `cargo xtask setup` makes.
///
/// # Panics
/// It has no SDK.
pub fn python() -> PathBuf {
    python_with("dynamixel_sdk")
}

/// The interpreter, which must have this module.
///
/// # Panics
/// It has not.
pub fn python_with(module: &str) -> PathBuf {
    let default = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/python/bin/python");
    let python = std::env::var_os("FRE_PYTHON").map_or(default, PathBuf::from);
    let found = Command::new(&python).args(["-c", &format!("import {module}")]).output();
    assert!(
        found.is_ok_and(|run| run.status.success()),
        "{} has no {module}: run `cargo xtask setup`, or name another Python in FRE_PYTHON",
        python.display()
    );
    python
}
