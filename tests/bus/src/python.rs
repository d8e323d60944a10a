//! The Python that has ROBOTIS' own SDK (`dynamixel-sdk` on PyPI).

use std::path::{Path, PathBuf};
use std::process::Command;

/// The interpreter: `FRE_PYTHON`, or the one that `cargo xtask setup` makes.
///
/// # Panics
/// It has no SDK.
pub fn python() -> PathBuf {
    let default = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/python/bin/python");
    let python = std::env::var_os("FRE_PYTHON").map_or(default, PathBuf::from);
    let sdk = Command::new(&python).args(["-c", "import dynamixel_sdk"]).output();
    assert!(
        sdk.is_ok_and(|run| run.status.success()),
        "{} has no dynamixel_sdk: run `cargo xtask setup`, or name another Python in FRE_PYTHON",
        python.display()
    );
    python
}
