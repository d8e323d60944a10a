//! What a run in QEMU needs so that the cycles of the real chips are measured: the plugin, and the boards' images.

use crate::cross::built;
use crate::firmware;
use crate::pc::cargo;
use anyhow::{Context, Result};
use std::path::PathBuf;
use std::process::Command;

/// Builds the plugin and the images of these boards, and names them in the command's environment.
pub fn provide(command: &mut Command, boards: &[&str]) -> Result<()> {
    command.env("FRE_CYCLES_PLUGIN", plugin()?);
    let images: Vec<PathBuf> = boards.iter().map(|board| firmware::show(board)).collect::<Result<_>>()?;
    command.env("FRE_BOARD_IMAGES", std::env::join_paths(images).context("a folder's name has a colon")?);
    Ok(())
}

/// Builds the plugin, with optimisation: it sees every instruction.
fn plugin() -> Result<PathBuf> {
    let mut build = cargo("build");
    build.args(["--quiet", "--release", "--package", "cycles-plugin"]);
    let messages = built(&mut build)?;
    let is_plugin = |name: &&str| name.ends_with(std::env::consts::DLL_SUFFIX);
    let files = messages.iter().filter(|message| message["target"]["name"] == "cycles_plugin");
    let file = files
        .filter_map(|message| message["filenames"].as_array()?.iter().filter_map(|name| name.as_str()).find(is_plugin))
        .next();
    file.map(PathBuf::from).context("cargo named no plugin")
}
