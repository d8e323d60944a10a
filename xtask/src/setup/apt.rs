//! Debian packages: never interactive, never removing what is installed.

use crate::command::{find, is_root, output, run, succeeds};
use crate::paths;
use anyhow::{Context, Result, bail};
use std::fs;
use std::process::Command;

/// Where to look when the configured sources cannot provide a package without removing another.
#[derive(Clone, Copy, PartialEq)]
pub enum Otherwise {
    Fail,
    /// The release's backports: a machine that already has newer relatives of the package came by them from there.
    Backports,
}

/// Installs packages, or says which command would.
pub fn install(packages: &[&str], otherwise: Otherwise) -> Result<()> {
    let command_line = format!("apt-get install --no-install-recommends --no-remove {}", packages.join(" "));
    if find("apt-get").is_none() {
        bail!(
            "missing: {}. This machine has no apt-get: install what corresponds to these Debian packages",
            packages.join(", ")
        );
    }
    if !is_root() {
        bail!(
            "missing: {}. Not root, so run this and start again:\n  sudo apt-get update && sudo {command_line}",
            packages.join(", ")
        );
    }
    println!("installing {} from Debian", packages.join(" "));
    output(&mut apt(&["update", "-qq"]))?;
    let plain = ["install", "--yes", "--quiet=2", "--no-install-recommends", "--no-remove"];
    let mut simulation = apt(&plain);
    simulation.arg("--simulate").args(packages);
    if succeeds(&mut simulation) {
        return run_quietly(apt(&plain).args(packages));
    }
    if otherwise == Otherwise::Backports
        && let Some(codename) = debian_codename()
    {
        println!("  {} would displace installed packages; taking the {codename}-backports version", packages.join(" "));
        return from_backports(&codename, &plain, packages);
    }
    run(apt(&plain).args(packages)) // for apt's own words on why not
}

fn apt(arguments: &[&str]) -> Command {
    let mut command = Command::new("apt-get");
    command.env("DEBIAN_FRONTEND", "noninteractive").args(["-o", "DPkg::Lock::Timeout=300"]).args(arguments);
    command
}

fn run_quietly(command: &mut Command) -> Result<()> {
    output(command).map(drop)
}

fn debian_codename() -> Option<String> {
    let release = fs::read_to_string("/etc/os-release").ok()?;
    let value = |key: &str| {
        release
            .lines()
            .find_map(|line| line.strip_prefix(key)?.strip_prefix('='))
            .map(|value| value.trim_matches('"').to_owned())
    };
    (value("ID")? == "debian").then(|| value("VERSION_CODENAME"))?
}

/// One installation with a source list of its own: the machine's configured sources stay as they are.
fn from_backports(codename: &str, plain: &[&str], packages: &[&str]) -> Result<()> {
    let folder = paths::target().join("apt");
    for part in ["lists/partial", "archives/partial"] {
        fs::create_dir_all(folder.join(part)).context("cannot create the package lists' folder")?;
    }
    let sources = folder.join("debian.sources");
    fs::write(
        &sources,
        format!(
            "Types: deb\nURIs: http://deb.debian.org/debian\nSuites: {codename} {codename}-updates {codename}-backports\n\
             Components: main\nSigned-By: /usr/share/keyrings/debian-archive-keyring.gpg\n"
        ),
    )?;
    let own_sources = |arguments: &[&str]| {
        let mut command = apt(&["-o", "APT::Sandbox::User=root", "-o", "Dir::Etc::sourceparts=-"]);
        for (option, path) in [
            ("Dir::Etc::sourcelist", sources.clone()),
            ("Dir::State::lists", folder.join("lists")),
            ("Dir::Cache::archives", folder.join("archives")),
        ] {
            command.arg("-o").arg(format!("{option}={}", path.display()));
        }
        command.args(arguments);
        command
    };
    run_quietly(&mut own_sources(&["update", "-qq"]))?;
    let suite = format!("{codename}-backports");
    run_quietly(own_sources(plain).args(["--target-release", &suite]).args(packages))?;
    fs::remove_dir_all(&folder).context("cannot remove the package lists")
}
