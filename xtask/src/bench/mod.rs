//! `cargo xtask bench`: every figure that the README quotes, measured in one run.
//!
//! On the target: instructions, flash, RAM and stack, exact and repeatable. On this PC: times, which are not; their ratios are.

mod document;
mod pc;
mod peer;
mod run_time;
mod table;
mod target;

use crate::command::headline;
use crate::cross::Cross;
use crate::setup;
use anyhow::{Context, Result, bail};
use std::fs;
use std::path::Path;

/// Parts of the bench that can be left out. The target's forces are compared with this PC's, which every part but
/// `rates`, `soak` and `calibration` makes.
const PARTS: &[&str] = &["peer", "scaling", "branches", "target", "rates", "soak", "calibration"];

/// Measures, prints a table and, if asked, writes the figures as JSON; with names of parts, those only.
pub fn run(arguments: &[&str]) -> Result<()> {
    let (json, parts) = match arguments {
        ["--json", file] => (Some(Path::new(file)), PARTS),
        [] => (None, PARTS),
        parts => (None, parts),
    };
    if let Some(unknown) = parts.iter().find(|part| !PARTS.contains(part)) {
        bail!("`bench` takes `--json FILE`, or some of its parts ({}); found `{unknown}`", PARTS.join(", "));
    }
    let wanted = |part| parts.contains(&part);
    headline("set-up");
    setup::run(setup::Parts::Firmware)?;
    let cross = Cross::find()?;

    if wanted("rates") {
        headline("the dearest tick over a campaign of faults in QEMU, and the rates that follow");
        run_time::rates()?;
    }
    if wanted("soak") {
        headline("an hour of gripping on a bus that is never quite well, in a time of its own");
        run_time::soak()?;
    }
    if wanted("calibration") {
        headline("500 synthetic calibrations by each of several protocols");
        run_time::calibrations()?;
    }
    if parts.iter().all(|part| ["rates", "soak", "calibration"].contains(part)) {
        return Ok(());
    }

    headline("this PC");
    let pc = pc::measure()?;
    print!("{}", table::pc(&pc.times));

    let mut peer = None;
    if wanted("peer") {
        headline("CasADi + IPOPT on the paper's model");
        peer = peer::measure(&pc.peer)?;
        if let Some(peer) = &peer {
            print!("{}", table::peer(peer));
        }
    }
    if wanted("scaling") {
        headline("how the cost grows");
        pc::show("scaling")?;
    }
    if wanted("branches") {
        headline("branches");
        pc::show("branches")?;
    }
    if wanted("target") {
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
    }
    Ok(())
}
