//! Every figure that the README and the book quote, measured in one run. `cargo xtask bench` builds the images and starts it.
//!
//! On the target: instructions, flash, RAM and stack, exact and repeatable. On this PC: times, which are not; their ratios are.

mod branches;
mod building;
mod calibration;
mod campaign;
mod designs;
mod document;
mod ladder;
mod pc;
mod peer;
mod plates;
mod rates;
mod recordings;
mod scales;
mod scaling;
mod soak;
mod spread;
mod table;
mod target;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result, bail};
use clap::{Parser, ValueEnum};
use ladder::PHYSICS;

/// A part of the bench.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Part {
    /// The worst tick over a campaign of faults in QEMU, and the rates that follow
    Rates,
    /// An hour of gripping on a bus in trouble, in a time of its own
    Soak,
    /// How fast recordings are written and read, and how large they become
    Recordings,
    /// Synthetic calibrations by each of several protocols
    Calibration,
    /// Three design problems, from a preset to the best finger, with finite elements beside it where CalculiX is installed
    Optimise,
    /// Times on this PC
    Pc,
    /// CasADi and IPOPT on the model of "Geometrico-Static Modelling of a FRE Finger", the paper, beside ours
    Peer,
    /// How the cost grows with elements, lamellae and cores
    Scaling,
    /// Whether the step size changes the branch
    Branches,
    /// Fingers of every scale, in both precisions
    Scales,
    /// How much stiffer wide walls bend, by finite elements in three dimensions, where CalculiX is installed
    Plates,
    /// How long the command takes to build, and how large it is
    Build,
    /// Instructions, flash, RAM and stack on the target, in QEMU
    Target,
}

/// Measures and prints tables.
#[derive(Parser)]
#[command(name = "cargo xtask bench")]
struct Options {
    /// Parts to run; without any, all
    #[arg(value_name = "PART")]
    parts: Vec<Part>,
    /// Also write the figures as JSON to this file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Runs of each calibration protocol
    #[arg(long, default_value_t = 500)]
    runs: u64,
    /// Minutes of the part `recordings`
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..=600))]
    minutes: u64,
    /// Random cases of the parts `branches` and `scales`
    #[arg(long, default_value_t = branches::CASES)]
    cases: usize,
    /// One case of the parts `branches` and `scales`, described
    #[arg(long)]
    case: Option<usize>,
    /// Only check the command line
    #[arg(long, hide = true)]
    check: bool,
    /// Folder of the target's images (set by `cargo xtask`)
    #[arg(long, value_name = "FOLDER", hide = true)]
    images: Option<PathBuf>,
    /// Optimisation level of the images (set by `cargo xtask`)
    #[arg(long, default_value = "unknown", hide = true)]
    opt_level: String,
    /// Compiler of the images (set by `cargo xtask`)
    #[arg(long, default_value = "unknown", hide = true)]
    rustc: String,
    /// Python with CasADi (set by `cargo xtask`)
    #[arg(long, value_name = "PYTHON", hide = true)]
    peer_python: Option<PathBuf>,
}

impl Options {
    fn wants(&self, part: Part) -> bool {
        self.parts.is_empty() || self.parts.contains(&part)
    }
}

fn main() -> ExitCode {
    match run(&Options::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn headline(text: &str) {
    println!("\n=== {text}");
}

/// Measures the wanted parts, prints each as it comes, and writes the figures.
fn run(options: &Options) -> Result<()> {
    if options.check {
        return Ok(());
    }
    let rates = measured_if(options.wants(Part::Rates), || {
        headline("the worst tick over a campaign of faults in QEMU, and the rates that follow");
        let rates = rates::measure()?;
        print!("{rates}");
        Ok(rates)
    })?;
    if options.wants(Part::Soak) {
        headline("an hour of gripping on a bus in trouble, in a time of its own");
        print!("{}", soak::measure()?);
    }
    if options.wants(Part::Recordings) {
        headline("recordings: how fast they are written and read, and how large they become");
        print!("{}", recordings::measure(options.minutes)?);
    }
    if options.wants(Part::Calibration) {
        headline(&format!("{} synthetic calibrations by each of several protocols", options.runs));
        let report = calibration::measure(options.runs)?;
        print!("{report}");
        report.check()?;
    }
    if options.wants(Part::Optimise) {
        headline("design optimisation");
        designs::measure()?;
    }
    let times = measured_if(options.wants(Part::Pc), || {
        headline("this PC");
        let times = pc::times()?;
        print!("{}", table::pc(&times));
        Ok(times)
    })?;
    let peer = measured_if(options.wants(Part::Peer), || {
        headline("CasADi + IPOPT on the paper's model");
        peer(options)
    })?;
    if options.wants(Part::Scaling) {
        headline("how the cost grows");
        print!("{}", scaling::measure()?);
    }
    if options.wants(Part::Branches) {
        headline("branches");
        match options.case {
            Some(number) => print!("{}", branches::look_into(number)?),
            None => PHYSICS.iter().for_each(|&physics| print!("{}", branches::count(options.cases, physics))),
        }
    }
    if options.wants(Part::Scales) {
        headline("fingers of every scale, in both precisions");
        match options.case {
            Some(number) => print!("{}", scales::look_into(number)?),
            None => PHYSICS.iter().for_each(|&physics| print!("{}", scales::measure(options.cases, physics))),
        }
    }
    if options.wants(Part::Plates) {
        headline("wide walls between ribs, by finite elements in three dimensions");
        print!("{}", plates::measure()?);
    }
    if options.wants(Part::Build) {
        headline("building the command");
        print!("{}", building::measure()?);
    }
    let rows = measured_if(options.wants(Part::Target), || {
        headline("the target, in QEMU");
        let images = options.images.as_deref().context("the target's images are missing: run `cargo xtask bench`")?;
        let rows = target::measure(images, &pc::forces()?)?;
        print!("{}", table::target(&rows));
        println!("\n{}, opt-level {}", options.rustc, options.opt_level);
        Ok(rows)
    })?;
    let figures = document::Figures {
        rustc: &options.rustc,
        opt_level: &options.opt_level,
        target: rows.as_deref(),
        pc: times.as_deref(),
        peer: peer.flatten(),
        rates: rates.as_ref(),
    };
    options.json.as_deref().map_or(Ok(()), |file| write(file, &figures))
}

fn measured_if<T>(wanted: bool, measure: impl FnOnce() -> Result<T>) -> Result<Option<T>> {
    wanted.then(measure).transpose()
}

/// Both programs on the same problem; none, and a line that says so, where the peer is not installed.
fn peer(options: &Options) -> Result<Option<peer::Peer>> {
    let Some(python) = &options.peer_python else {
        println!("left out: CasADi + IPOPT is not installed");
        return Ok(None);
    };
    let peer = peer::compare(&pc::shared_problem()?, &peer::run(python)?)?;
    print!("{}", table::peer(&peer));
    Ok(Some(peer))
}

fn write(file: &Path, figures: &document::Figures<'_>) -> Result<()> {
    let document::Figures { target, pc, peer, rates, .. } = figures;
    if target.is_none() && pc.is_none() && peer.is_none() && rates.is_none() {
        bail!("none of these parts has figures for {}: `pc`, `peer`, `rates` and `target` have", file.display());
    }
    let document = figures.document();
    figures.check(&document)?;
    fs::write(file, format!("{document:#}\n")).with_context(|| format!("cannot write {}", file.display()))?;
    println!("figures: {}", file.display());
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(words: &[&str]) -> Result<Options, clap::Error> {
        Options::try_parse_from([&["bench"], words].concat())
    }

    #[test]
    fn parts_are_chosen_or_all_are_run() {
        let all = parsed(&["--json", "a.json"]).unwrap();
        assert!(Part::value_variants().iter().all(|part| all.wants(*part)));
        assert_eq!(all.json.as_deref(), Some(Path::new("a.json")));
        let some = parsed(&["pc", "target", "--json", "a.json"]).unwrap();
        assert!(some.wants(Part::Pc) && some.wants(Part::Target) && !some.wants(Part::Soak));
    }

    #[test]
    fn an_unknown_part_is_refused_with_the_parts_there_are() {
        let error = parsed(&["sacling"]).err().unwrap().to_string();
        assert!(error.contains("sacling") && error.contains("scaling") && error.contains("calibration"), "{error}");
    }
}
