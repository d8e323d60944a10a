//! `cargo xtask bench`: every figure that the README quotes, measured in one run.
//!
//! On the target: instructions, flash, RAM and stack, exact and repeatable. On this PC: times, which are not; their ratios are.

mod document;
mod pc;
mod peer;
mod table;
mod target;

use crate::command::headline;
use crate::cross::Cross;
use crate::setup;
use anyhow::{Context, Result, bail};
use std::fs;
use std::path::Path;

/// Measures, prints a table and, if asked, writes the figures as JSON.
pub fn run(arguments: &[&str]) -> Result<()> {
    let json = match arguments {
        [] => None,
        ["--json", file] => Some(Path::new(file)),
        _ => bail!("`bench` takes nothing but `--json FILE`; found `{}`", arguments.join(" ")),
    };
    headline("set-up");
    setup::run(setup::Parts::Firmware)?;
    let cross = Cross::find()?;

    headline("this PC");
    let pc = pc::measure()?;
    print!("{}", table::pc(&pc.times));

    headline("CasADi + IPOPT on the paper's model");
    let peer = peer::measure(&pc.peer)?;
    if let Some(peer) = &peer {
        print!("{}", table::peer(peer));
    }

    headline("how the cost grows");
    pc::show("scaling")?;

    headline("branches");
    pc::show("branches")?;

    headline("the target, in QEMU");
    let images = target::build(&cross)?;
    let rows = target::measure(&images, &pc.forces)?;
    print!("{}", table::target(&rows));

    let document = document::write(&cross.rustc_version()?, &images.opt_level, &rows, &pc.times, peer.as_ref());
    document::check(&document)?;
    println!("\n{}, opt-level {}", document["rustc"].as_str().unwrap_or_default(), images.opt_level);
    if let Some(file) = json {
        fs::write(file, format!("{document:#}\n")).with_context(|| format!("cannot write {}", file.display()))?;
        println!("figures: {}", file.display());
    }
    Ok(())
}
