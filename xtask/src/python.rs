//! The Python package: its wheel, built and tested as a user has it, in an environment of its own.

use crate::command::{headline, output, run as run_command};
use crate::pc::{FEATURES, cargo};
use crate::setup::python::PACKAGE;
use crate::{firmware, paths};
use anyhow::{Context, Result};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A test program of the command, for which cargo builds the command as well.
const TESTED: &str = "words";

/// Builds the wheel, installs it in a fresh environment, and runs pytest there.
pub fn test() -> Result<()> {
    let image = firmware::show(firmware::SIMULATED)?;
    headline("the command, whose results those of the package are compared with");
    // As a part of the tests on this PC, whose dependencies differ from a program's alone: nothing is built twice.
    run_command(cargo("test").args(["--quiet", "--no-run", "--workspace", "--test", TESTED]).args(FEATURES))?;
    headline("the wheel");
    let wheel = wheel("dev")?;
    let python = install(&wheel)?;
    headline("tests of the Python package, on the wheel");
    run_command(
        Command::new(&python)
            .args(["-m", "pytest"])
            .current_dir(folder())
            .env("FRE_PROGRAM", paths::target().join("debug/fre"))
            .env("FRE_FIRMWARE_ELF", image)
            // Cargo's own variables would have a build inside a test believe that it is a part of this one.
            .env_remove("CARGO_MANIFEST_DIR"),
    )
}

/// The package's folder.
fn folder() -> PathBuf {
    paths::root().join("host/python")
}

/// Where wheels are built.
fn dist() -> PathBuf {
    paths::target().join("python-wheel/dist")
}

/// The wheel that was built last; none if there is none.
pub fn built() -> Result<Option<PathBuf>> {
    if !dist().exists() {
        return Ok(None);
    }
    let files = dist().read_dir().with_context(|| format!("cannot list {}", dist().display()))?;
    Ok(files.filter_map(|file| Some(file.ok()?.path())).find(|path| path.extension().is_some_and(|e| e == "whl")))
}

/// Builds the wheel with a profile of cargo's; gives its path.
pub fn wheel(profile: &str) -> Result<PathBuf> {
    let out = dist();
    if out.exists() {
        fs::remove_dir_all(&out).context("cannot remove the old wheel")?;
    }
    let maturin = PACKAGE.python().with_file_name("maturin");
    // The settings of the tests' profile: what the wheel shares with them is there already, and its assertions are on. (Cargo takes the
    // name of that profile for a wish to build the tests themselves.)
    let words = ["build", "--profile", profile, "--locked", "--out"];
    run_command(
        Command::new(maturin).args(words).arg(&out).current_dir(folder()).env("CARGO_PROFILE_DEV_OPT_LEVEL", "2"),
    )?;
    built()?.context("maturin has built no wheel")
}

/// Makes a fresh environment with the wheel in it; gives its interpreter. The packages that the tests need are those of the pinned
/// environment: only the package itself is installed anew.
fn install(wheel: &Path) -> Result<PathBuf> {
    let environment = paths::target().join("python-wheel/environment");
    if environment.exists() {
        fs::remove_dir_all(&environment).context("cannot remove the old environment")?;
    }
    output(Command::new(PACKAGE.python()).args(["-m", "venv"]).arg(&environment))?;
    let python = environment.join("bin/python");
    let packages = |python: &Path| -> Result<PathBuf> {
        let purelib = "import sysconfig; print(sysconfig.get_path('purelib'))";
        Ok(output(Command::new(python).args(["-c", purelib]))?.trim().into())
    };
    let (own, pinned) = (packages(&python)?, packages(&PACKAGE.python())?);
    fs::write(own.join("pinned.pth"), format!("{}\n", pinned.display())).context("cannot name the pinned packages")?;
    let install = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-deps", "--no-index"];
    output(Command::new(&python).args(install).arg(wheel))?;
    Ok(python)
}
