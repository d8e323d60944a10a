//! The paper's model by CasADi and IPOPT (`tests/reference/peer.py`), in an environment of its own, beside ours.

use super::pc::number;
use crate::command::{find, output, succeeds};
use crate::paths;
use anyhow::{Context, Result, bail};
use std::fs;
use std::process::Command;

/// The pinned requirement; a change makes the environment anew.
const REQUIREMENT: &str = "casadi==3.8.2";
/// Forces that agree within this share of their size come from the same branch and the same model.
const AGREES: f64 = 1e-6;

/// What a program prints of the problem that both solve.
#[derive(Default)]
pub struct Run {
    /// From the undeformed finger to the last angle, µs.
    cold_us: Vec<f64>,
    /// One count, µs.
    warm_us: Vec<f64>,
    /// Force in the finger frame, N, by where it was read.
    forces: Vec<(String, [f64; 2])>,
}

impl Run {
    /// Takes the words of a line after `peer`.
    pub fn take(&mut self, words: &[&str]) -> Result<()> {
        match words {
            ["cold", time] => self.cold_us.push(number(time)?),
            ["warm", time] => self.warm_us.push(number(time)?),
            ["force", place, x, y] => self.forces.push(((*place).to_owned(), [number(x)?, number(y)?])),
            _ => bail!("a line of the peer's problem reads `{}`", words.join(" ")),
        }
        Ok(())
    }
}

/// Both side by side.
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

/// Solves the same problem with the peer; `None`, and a line that says why, where there is no Python or no package.
pub fn measure(ours: &Run) -> Result<Option<Peer>> {
    if let Err(error) = provide() {
        println!("CasADi + IPOPT is left out: {error:#}");
        return Ok(None);
    }
    let script = paths::root().join("tests/reference/peer.py");
    let text = output(Command::new(python()).arg(&script).env("OMP_NUM_THREADS", "1"))?;
    let mut theirs = Run::default();
    for line in text.lines() {
        match line.split(' ').collect::<Vec<_>>().as_slice() {
            ["peer", words @ ..] => theirs.take(words)?,
            _ => bail!("{} printed `{line}`", script.display()),
        }
    }
    compare(ours, &theirs).map(Some)
}

fn compare(ours: &Run, theirs: &Run) -> Result<Peer> {
    let mut apart = 0.0_f64;
    for (place, [x, y]) in &theirs.forces {
        let (_, [a, b]) = ours
            .forces
            .iter()
            .find(|(other, _)| other == place)
            .with_context(|| format!("our program printed no force at {place}"))?;
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
    sorted.get(sorted.len() / 2).copied().context("a program printed no times")
}

fn python() -> std::path::PathBuf {
    paths::target().join("peer/bin/python")
}

/// Makes the environment if it is not there.
fn provide() -> Result<()> {
    let folder = paths::target().join("peer");
    let stamp = folder.join("requirements.txt");
    if python().exists() && fs::read_to_string(&stamp).ok().as_deref() == Some(REQUIREMENT) {
        return Ok(());
    }
    if find("python3").is_none() || !succeeds(Command::new("python3").args(["-c", "import ensurepip, venv"])) {
        bail!("no python3 with venv");
    }
    println!("Python package {REQUIREMENT}: making target/peer");
    if folder.exists() {
        fs::remove_dir_all(&folder).context("cannot remove the old target/peer")?;
    }
    output(Command::new("python3").args(["-m", "venv"]).arg(&folder))?;
    output(Command::new(python()).args([
        "-m",
        "pip",
        "install",
        "--quiet",
        "--disable-pip-version-check",
        "--no-input",
        REQUIREMENT,
    ]))?;
    fs::write(&stamp, REQUIREMENT)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(lines: &[&str]) -> Run {
        let mut run = Run::default();
        for line in lines {
            run.take(&line.split(' ').collect::<Vec<_>>()).unwrap();
        }
        run
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
}
