//! `cargo xtask setup`: finds, installs or builds what the other commands need. One line per part; under a second when nothing is missing.

mod apt;
mod cross_target;
pub mod python;

use crate::command::{find, output};
use crate::paths;
use anyhow::{Context, Result, bail};
use apt::Otherwise;
use std::fs::{self, File};
use std::process::Command;

/// What is wanted.
#[derive(Clone, Copy, PartialEq)]
pub enum Parts {
    /// To build firmware and run it: QEMU and the cross target.
    Firmware,
    /// And the Python packages that the protocol tests compare against, what builds and tests our own, and the browser that the live page
    /// is tested in.
    Everything,
    /// And CalculiX.
    EverythingAndFea,
}

/// Provides the parts; every part is tried, then whatever is missing is one error.
pub fn run(parts: Parts) -> Result<()> {
    fs::create_dir_all(paths::target()).context("cannot create the target folder")?;
    // Two commands may be started at once; the second waits and finds everything there.
    let lock = File::create(paths::target().join("setup.lock"))?;
    lock.lock().context("cannot lock the set-up")?;

    type Part = (&'static str, fn() -> Result<String>);
    let mut wanted: Vec<Part> = vec![("QEMU", qemu), ("cross target", cross_target::provide)];
    if parts != Parts::Firmware {
        wanted.push(("Python packages", || python::TESTS.provide()));
        wanted.push(("tools of the Python package", || python::PACKAGE.provide()));
        wanted.push(("Chromium", chromium));
    }
    if parts == Parts::EverythingAndFea {
        wanted.push(("CalculiX", calculix));
    }
    let mut missing = Vec::new();
    for (name, provide) in wanted {
        match provide() {
            Ok(found) => println!("{name}: {found}"),
            Err(error) => missing.push(format!("{name}: {error:#}")),
        }
    }
    if !missing.is_empty() {
        bail!("the set-up is incomplete\n{}", missing.join("\n"));
    }
    Ok(())
}

fn qemu() -> Result<String> {
    if find(fre_qemu::PROGRAM).is_none() {
        apt::install(&[fre_qemu::PROGRAM], Otherwise::Backports)?;
    }
    let version = output(Command::new(fre_qemu::PROGRAM).arg("--version"))?;
    Ok(version.lines().next().unwrap_or_default().to_owned())
}

fn chromium() -> Result<String> {
    if find("chromium").is_none() {
        apt::install(&["chromium"], Otherwise::Fail)?;
    }
    let chromium = find("chromium").context("chromium is installed, but `chromium` is not in PATH")?;
    Ok(chromium.display().to_string())
}

fn calculix() -> Result<String> {
    if find("ccx").is_none() {
        apt::install(&["calculix-ccx"], Otherwise::Fail)?;
    }
    let ccx = find("ccx").context("calculix-ccx is installed, but `ccx` is not in PATH")?;
    Ok(ccx.display().to_string())
}
