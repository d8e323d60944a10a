//! Random fingers of every scale in single precision against double: how many are trustworthy, how many agree, and what the others came
//! to, by status. The microcontroller's resolution.

use std::collections::BTreeMap;
use std::fmt;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use model_core::discretise::Physics;
use rayon::prelude::*;
use reference_tests::twins::{Solvers, Twins};
use reference_tests::wide::{WideCase, WideCases};

use crate::ladder::{PHYSICS, word};

const SEED: u64 = 13;
/// Part of the force by which single precision may be off.
const AGREE: f64 = 1e-3;

/// What the cases came to in both precisions.
#[derive(Debug)]
pub struct Scales {
    physics: Physics,
    pub cases: usize,
    /// Trustworthy in single precision.
    pub trustworthy: usize,
    /// Trustworthy in both, and of these those whose forces differ by more than [`AGREE`].
    pub both: usize,
    pub apart: usize,
    /// The longest time of a case.
    pub slowest: Duration,
    /// By the statuses in single and double precision: cases.
    pub statuses: BTreeMap<[&'static str; 2], usize>,
    /// Cases of different statuses or forces.
    differing: Vec<(usize, Twins)>,
}

/// Closes so many random cases in both precisions.
pub fn measure(cases: usize, physics: Physics) -> Scales {
    let cases: Vec<WideCase> = WideCases::seeded(SEED).take(cases).collect();
    let twins: Vec<(Twins, Duration)> = cases
        .par_iter()
        .map_init(Solvers::new, |solvers, case| {
            let clock = Instant::now();
            let twins = solvers.close(case, physics);
            (twins, clock.elapsed())
        })
        .collect();
    let mut scales = Scales {
        physics,
        cases: twins.len(),
        trustworthy: 0,
        both: 0,
        apart: 0,
        slowest: Duration::ZERO,
        statuses: BTreeMap::new(),
        differing: Vec::new(),
    };
    for (number, (twins, spent)) in twins.into_iter().enumerate() {
        let (single, double) = (twins.single.status, twins.double.status);
        let is_apart = twins.difference() > AGREE;
        let both = single.is_trustworthy() && double.is_trustworthy();
        scales.slowest = scales.slowest.max(spent);
        scales.trustworthy += usize::from(single.is_trustworthy());
        scales.both += usize::from(both);
        scales.apart += usize::from(both && is_apart);
        *scales.statuses.entry([single.word(), double.word()]).or_default() += 1;
        if single != double || is_apart {
            scales.differing.push((number, twins));
        }
    }
    scales
}

/// One case, described, with both physics.
pub fn look_into(number: usize) -> Result<String> {
    let case = WideCases::seeded(SEED).nth(number).with_context(|| format!("there is no case {number}"))?;
    let close = |physics| format!("{}\n{case:#?}\n{:#?}\n", word(physics), Solvers::new().close(&case, physics));
    Ok(PHYSICS.map(close).concat())
}

impl fmt::Display for Scales {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} random fingers of 4 mm to 2 m, 0.1 MPa to 210 GPa, {}", self.cases, word(self.physics))?;
        let part = 100.0 * self.trustworthy as f64 / self.cases.max(1) as f64;
        writeln!(f, "  trustworthy in f32: {part:.2} %; the slowest took {:.2} s", self.slowest.as_secs_f64())?;
        writeln!(f, "  {:<16} {:<16} {:>6}", "f32", "f64", "cases")?;
        for ([single, double], count) in &self.statuses {
            writeln!(f, "  {single:<16} {double:<16} {count:>6}")?;
        }
        writeln!(f, "  trustworthy in both, and more than 0.1 % apart: {} of {}", self.apart, self.both)?;
        self.differing.iter().try_for_each(|(number, twins)| writeln!(f, "    case {number}: {twins}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_case_is_counted_once() {
        let scales = measure(10, Physics::Extended);
        assert_eq!((scales.cases, scales.statuses.values().sum::<usize>()), (10, 10));
        assert!(scales.apart <= scales.both && scales.both <= scales.trustworthy, "{scales:?}");
        assert!(look_into(3).unwrap().contains("extended"));
    }
}
