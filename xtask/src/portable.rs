//! `model-core` and `fre` on the systems of laptops: checked for them, so that nothing of one system gets in. Only metadata is made,
//! which needs no linker and no libraries of those systems.

use crate::command::{headline, run as run_command};
use crate::cross::{active_sysroot, clear_inherited, debian_cargo};
use crate::paths;
use anyhow::Result;
use std::env;
use std::path::Path;
use std::process::Command;

/// The systems, the one that differs most first.
const TRIPLES: [&str; 2] = ["x86_64-pc-windows-msvc", "aarch64-apple-darwin"];
/// The packages that run on them.
const PACKAGES: [&str; 2] = ["model-core", "fre"];

/// For which of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Systems {
    /// The one that differs most: each takes minutes.
    First,
    /// All: for a release.
    All,
}

/// Checks the packages for each system.
///
/// # Errors
/// A package that does not compile there, or no compiler.
pub fn check(systems: Systems) -> Result<()> {
    let sysroot = active_sysroot()?;
    let count = if systems == Systems::All { TRIPLES.len() } else { 1 };
    for triple in TRIPLES.into_iter().take(count) {
        headline(&format!("{} for {triple}", PACKAGES.join(" and ")));
        let mut command = cargo(has_std(&sysroot, triple));
        command.current_dir(paths::root()).args(["--quiet", "--locked", "--target", triple]);
        command.args(PACKAGES.iter().flat_map(|package| ["--package", package]));
        // A folder of its own: the packages for the PC itself would be built again with this compiler's.
        command.arg("--target-dir").arg(paths::target().join("portable"));
        run_command(&mut command)?;
    }
    Ok(())
}

/// `cargo check`: by the active toolchain where it has the system's `std`; else by Debian's, which checks its own `std` from the
/// sources of the package rust-web-src first.
fn cargo(has_std: bool) -> Command {
    if has_std {
        let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        clear_inherited(&mut command);
        command.arg("check");
        return command;
    }
    let mut command = debian_cargo();
    // The standard library's sources build with the compiler's own features only.
    command.env("RUSTC_BOOTSTRAP", "1").args(["check", "-Zbuild-std=std"]);
    command
}

/// Whether a sysroot has `std` for a system.
fn has_std(sysroot: &Path, triple: &str) -> bool {
    let folder = sysroot.join("lib/rustlib").join(triple).join("lib");
    folder
        .read_dir()
        .is_ok_and(|entries| entries.flatten().any(|entry| entry.file_name().to_string_lossy().starts_with("libstd-")))
}
