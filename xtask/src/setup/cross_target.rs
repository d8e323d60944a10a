//! Provides libraries for the microcontroller's target: rustup where it may fetch, else Debian's Rust packages.

use super::apt::{self, Otherwise};
use crate::command::{find, line, output, run};
use crate::cross::{self, Cross, TRIPLE};
use crate::paths;
use anyhow::{Context, Result};
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const DEBIAN_PACKAGES: &[&str] = &["rustc-web", "cargo-web", "rust-web-src", "rust-web-clippy"];

/// Provides the target and says where it comes from.
pub fn provide() -> Result<String> {
    let cross = match Cross::find() {
        Ok(cross) => cross,
        Err(_) => {
            fetch_or_build()?;
            Cross::find()?
        }
    };
    let rustc = cross.rustc_version()?;
    Ok(match cross {
        Cross::Active => format!("{TRIPLE} of the active toolchain ({rustc})"),
        Cross::Debian { .. } => format!("{TRIPLE} built with Debian's {rustc}"),
    })
}

fn fetch_or_build() -> Result<()> {
    let rustup_may_fetch = std::env::var_os("RUSTUP_AUTO_INSTALL").is_none_or(|value| value != "0");
    if rustup_may_fetch && find("rustup").is_some() {
        println!("cross target: rustup target add {TRIPLE}");
        return run(Command::new("rustup").args(["target", "add", TRIPLE]));
    }
    if !debian_complete() {
        apt::install(DEBIAN_PACKAGES, Otherwise::Fail)?;
    }
    println!("cross target: building core and alloc for {TRIPLE} (about 40 s, once)");
    build_sysroot()
}

fn debian_complete() -> bool {
    ["/usr/bin/rustc", "/usr/bin/cargo", "/usr/bin/cargo-clippy"].iter().all(|program| Path::new(program).exists())
        && library_source().is_some_and(|source| source.exists())
}

/// `library/` of Debian's sources, where `-Zbuild-std` looks for it.
fn library_source() -> Option<PathBuf> {
    let sysroot = output(Command::new("/usr/bin/rustc").args(["--print", "sysroot"])).ok()?;
    Some(Path::new(sysroot.trim()).join("lib/rustlib/src/rust/library/core/Cargo.toml"))
}

/// Builds `core` and `alloc` of an empty crate and collects them into a sysroot. Bitcode, because fat LTO reads it.
fn build_sysroot() -> Result<()> {
    let sysroot = cross::debian_sysroot();
    let work = paths::target().join("cross/build");
    for folder in [&sysroot, &work, &paths::boards_target()] {
        // The boards' folder too: what was built against another `core` does not link with this one.
        if folder.exists() {
            fs::remove_dir_all(folder).with_context(|| format!("cannot remove {}", folder.display()))?;
        }
    }
    fs::create_dir_all(work.join("src"))?;
    fs::write(
        work.join("Cargo.toml"),
        "[package]\nname = \"sysroot\"\nversion = \"0.0.0\"\nedition = \"2024\"\n[workspace]\n",
    )?;
    fs::write(work.join("src/lib.rs"), "#![no_std]\n")?;

    let mut build = cross::debian_cargo();
    build
        .current_dir(&work)
        .env("RUSTC_BOOTSTRAP", "1")
        .env("RUSTFLAGS", "-Cembed-bitcode=yes")
        .args(["build", "--quiet", "--release", "-Zbuild-std=core,alloc", "--target", TRIPLE])
        .arg("--target-dir")
        .arg(work.join("target"));
    output(&mut build)?;

    let libraries = sysroot.join("lib/rustlib").join(TRIPLE).join("lib");
    fs::create_dir_all(&libraries)?;
    let built = work.join("target").join(TRIPLE).join("release/deps");
    for name in ["libcore-", "liballoc-", "libcompiler_builtins-"] {
        let library =
            find_in(&built, name, "rlib").with_context(|| format!("`{}` made no {name}*.rlib", line(&build)))?;
        fs::copy(&library, libraries.join(library.file_name().unwrap_or(OsStr::new(name))))?;
    }
    link_lld(&sysroot)?;
    let rustc = cross::debian_rustc().context("Debian's rustc does not run")?;
    fs::write(sysroot.join("rustc.txt"), rustc)?;
    fs::remove_dir_all(&work).context("cannot remove the build folder")
}

/// rustc looks for its linker in the sysroot it is given.
fn link_lld(sysroot: &Path) -> Result<()> {
    let rustc = cross::debian_rustc().context("Debian's rustc does not run")?;
    let host = cross::host_of(&rustc).context("`rustc -vV` names no host")?;
    let relative = Path::new("lib/rustlib").join(host).join("bin");
    let bin = sysroot.join(&relative);
    fs::create_dir_all(&bin)?;
    let mut lld = cross::active_sysroot()?.join(&relative).join("rust-lld");
    if !lld.exists() {
        if find("ld.lld").is_none() {
            apt::install(&["lld"], Otherwise::Fail)?;
        }
        lld = find("ld.lld").context("lld is installed, but `ld.lld` is not in PATH")?;
    }
    std::os::unix::fs::symlink(&lld, bin.join("rust-lld")).context("cannot link rust-lld into the sysroot")
}

fn find_in(folder: &Path, prefix: &str, extension: &str) -> Option<PathBuf> {
    folder.read_dir().ok()?.flatten().map(|entry| entry.path()).find(|path| {
        path.extension().is_some_and(|found| found == extension)
            && path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(prefix))
    })
}
