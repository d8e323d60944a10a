//! The model of *Geometrico-Static Modelling of a FRE Finger* by CasADi and IPOPT (`tests/reference/peer.py`) beside ours.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::str::FromStr;

use anyhow::{Context, Result, bail};

/// Forces that agree within this share of their size come from the same branch and the same model.
const AGREES: f64 = 1e-6;

/// What a program makes of the problem that both solve.
#[derive(Clone, Debug, Default)]
pub struct Run {
    /// From the undeformed finger to the last angle, µs.
    pub cold_us: Vec<f64>,
    /// One count, µs.
    pub warm_us: Vec<f64>,
    /// Force in the finger frame, N, by where it was read: `cold`, or a count.
    pub forces: Vec<(String, [f64; 2])>,
}

/// Both side by side.
#[derive(Clone, Copy, Debug)]
pub struct Peer {
    pub cold_us: f64,
    pub warm_us: f64,
    pub ratio_cold: f64,
    pub ratio_warm: f64,
    /// Largest difference of the forces, of their size.
    pub apart: f64,
    /// Places at which they were compared.
    pub compared: usize,
}

/// Solves the problem with the peer, a Python program: its lines are its interface.
pub fn run(python: &Path) -> Result<Run> {
    let script: PathBuf = [env!("CARGO_MANIFEST_DIR"), "..", "reference", "peer.py"].iter().collect();
    let mut command = Command::new(python);
    let output = command.arg(&script).env("OMP_NUM_THREADS", "1").output();
    let output = output.with_context(|| format!("cannot start {}", python.display()))?;
    if !output.status.success() {
        bail!("{} ended with {}\n{}", script.display(), output.status, String::from_utf8_lossy(&output.stderr));
    }
    read(&String::from_utf8_lossy(&output.stdout)).with_context(|| format!("what {} printed", script.display()))
}

fn read(text: &str) -> Result<Run> {
    let mut run = Run::default();
    for line in text.lines() {
        match line.split(' ').collect::<Vec<_>>().as_slice() {
            ["peer", "cold", time] => run.cold_us.push(number(time)?),
            ["peer", "warm", time] => run.warm_us.push(number(time)?),
            ["peer", "force", place, x, y] => run.forces.push(((*place).to_owned(), [number(x)?, number(y)?])),
            _ => bail!("`{line}` is none of the peer's lines"),
        }
    }
    Ok(run)
}

/// A number in another program's words.
pub fn number<T: FromStr>(word: &str) -> Result<T> {
    word.parse().ok().with_context(|| format!("`{word}` is not the number it should be"))
}

/// Ratios of the medians; an error if the forces are not the same.
pub fn compare(ours: &Run, theirs: &Run) -> Result<Peer> {
    let mut apart = 0.0_f64;
    for (place, [x, y]) in &theirs.forces {
        let (_, [a, b]) = ours
            .forces
            .iter()
            .find(|(other, _)| other == place)
            .with_context(|| format!("we have no force at {place}"))?;
        let share = (x - a).hypot(y - b) / x.hypot(*y);
        if share.is_nan() || share > AGREES {
            bail!(
                "the force at {place} is ({a}, {b}) N, the peer's ({x}, {y}) N: {share:.1e} apart, allowed is {AGREES:.0e}"
            );
        }
        apart = apart.max(share);
    }
    if theirs.forces.is_empty() {
        bail!("the peer printed no force");
    }
    let [cold, warm, our_cold, our_warm] =
        [&theirs.cold_us, &theirs.warm_us, &ours.cold_us, &ours.warm_us].map(|times| median(times));
    let [cold_us, warm_us, our_cold, our_warm] = [cold?, warm?, our_cold?, our_warm?];
    Ok(Peer {
        cold_us,
        warm_us,
        ratio_cold: cold_us / our_cold,
        ratio_warm: warm_us / our_warm,
        apart,
        compared: theirs.forces.len(),
    })
}

fn median(times: &[f64]) -> Result<f64> {
    let mut sorted = times.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().context("a program has no times")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(lines: &[&str]) -> Run {
        read(&lines.iter().map(|line| format!("peer {line}\n")).collect::<String>()).unwrap()
    }

    #[test]
    fn ratios_are_of_medians() {
        let ours = run(&["cold 2", "cold 4", "cold 900", "warm 1", "force cold 3 4"]);
        let theirs = run(&["cold 80", "warm 100", "warm 300", "warm 200", "force cold 3 4.000001"]);
        let peer = compare(&ours, &theirs).unwrap();
        assert_eq!((peer.ratio_cold, peer.ratio_warm, peer.compared), (20.0, 200.0, 1));
        assert!((peer.apart - 2e-7).abs() < 1e-8, "{}", peer.apart);
    }

    #[test]
    fn another_branch_is_an_error() {
        let ours = run(&["cold 2", "warm 1", "force 90 3 4"]);
        assert!(compare(&ours, &run(&["cold 80", "warm 100", "force 90 3 4.0001"])).is_err());
        assert!(compare(&ours, &run(&["cold 80", "warm 100", "force 91 3 4"])).is_err(), "not where we looked");
        assert!(compare(&ours, &run(&["cold 80", "warm 100"])).is_err(), "nothing compared");
        assert!(compare(&ours, &run(&["warm 100", "force 90 3 4"])).is_err(), "no cold time");
    }

    #[test]
    fn words_that_are_no_figure_are_an_error() {
        for text in ["peer cold", "cold 2", "peer cold fast", "peer force 90 3"] {
            assert!(read(text).is_err(), "{text}");
        }
    }
}
