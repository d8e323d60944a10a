//! Does the step size change the branch? Random fingers, each closed on its circle in steps of at most 1° and of at most 0.1°; what
//! came out, counted.

use std::collections::BTreeMap;
use std::fmt;

use anyhow::{Context, Result};
use model_core::discretise::{Discretisation, Physics};
use model_core::equilibrium::{Follower, Settings};
use model_core::object::Motion;
use model_core::size::Paper;
use model_core::status::Status;
use rayon::prelude::*;
use reference_tests::random::{Case, Cases};

use crate::ladder::{PHYSICS, word};

const SEED: u64 = 10_000;
/// Random cases of a full run.
pub const CASES: usize = 10_000;
/// Points of two solutions further apart than this, mm, lie on different branches: converged twins agree to 1e-7.
const APART: f64 = 1e-3;

// Room for more touching samples than the microcontroller has.
type Solver = Follower<f64, Paper>;

/// What a case came to.
#[derive(Clone, Debug)]
pub struct Course {
    pub status: Status,
    front: Vec<[f64; 2]>,
    back: Vec<[f64; 2]>,
    /// World frame, N.
    pub force: [f64; 2],
    /// N·mm.
    pub energy: f64,
    pub iterations: u32,
}

/// A case whose courses at both step sizes are trustworthy and not the same.
#[derive(Clone, Debug)]
pub struct Parted {
    pub number: usize,
    pub coarse: Course,
    pub fine: Course,
}

/// What the cases came to at steps of at most 1° and 0.1°.
#[derive(Clone, Debug)]
pub struct Statistics {
    physics: Physics,
    pub cases: usize,
    /// By both statuses: cases, and those on another branch.
    pub statuses: BTreeMap<[&'static str; 2], [usize; 2]>,
    /// Per case, at both step sizes.
    pub mean_iterations: [f64; 2],
    pub parted: Vec<Parted>,
}

fn close(follower: &mut Solver, case: &Case, physics: Physics, step_deg: f64) -> Course {
    let blank =
        |status| Course { status, front: Vec::new(), back: Vec::new(), force: [0.0; 2], energy: 0.0, iterations: 0 };
    if follower.configure(&case.design, &Discretisation::reduced(physics)).is_err() {
        return blank(Status::ContactCapacity);
    }
    follower
        .set_settings(Settings { max_angle_step: step_deg.to_radians(), ..Settings::DEFAULT })
        .expect("an allowed step");
    follower.set_object(case.object(), Motion::Rotating { axis: case.design.motor_axis });
    if !follower.start(case.angle) {
        return blank(Status::OutOfRange);
    }
    let outcome = follower.follow(case.angle);
    Course {
        status: outcome.status,
        front: follower.solution().front().collect(),
        back: follower.solution().back().collect(),
        force: follower.solution().force_world(),
        energy: follower.solution().energy(),
        iterations: outcome.iterations,
    }
}

impl Course {
    /// Largest distance of corresponding points of both beams, mm.
    fn apart(&self, other: &Self) -> f64 {
        let points = |of: &Self| of.front.iter().chain(&of.back).copied().collect::<Vec<_>>();
        points(self).iter().zip(points(other)).map(|(p, q)| (p[0] - q[0]).hypot(p[1] - q[1])).fold(0.0, f64::max)
    }

    fn magnitude(&self) -> f64 {
        self.force[0].hypot(self.force[1])
    }
}

/// Closes so many random cases at both step sizes.
pub fn count(cases: usize, physics: Physics) -> Statistics {
    let cases: Vec<Case> = Cases::seeded(SEED).take(cases).collect();
    let pairs: Vec<[Course; 2]> = cases
        .par_iter()
        .map_init(
            || Box::new(Solver::EMPTY),
            |follower, case| [1.0, 0.1].map(|step| close(follower, case, physics, step)),
        )
        .collect();
    let mean = |of: &dyn Fn(&[Course; 2]) -> u32| {
        pairs.iter().map(|pair| f64::from(of(pair))).sum::<f64>() / pairs.len().max(1) as f64
    };
    let mean_iterations = [mean(&|[coarse, _]| coarse.iterations), mean(&|[_, fine]| fine.iterations)];
    let mut statuses: BTreeMap<_, [usize; 2]> = BTreeMap::new();
    let mut parted = Vec::new();
    for (number, [coarse, fine]) in pairs.into_iter().enumerate() {
        let [count, other] = statuses.entry([coarse.status.word(), fine.status.word()]).or_default();
        *count += 1;
        let both = coarse.status.is_trustworthy() && fine.status.is_trustworthy();
        if both && coarse.apart(&fine) > APART {
            *other += 1;
            parted.push(Parted { number, coarse, fine });
        }
    }
    Statistics { physics, cases: cases.len(), statuses, mean_iterations, parted }
}

/// One case at several step sizes, and where its courses part, with both physics.
pub fn look_into(number: usize) -> Result<String> {
    let case = Cases::seeded(SEED).nth(number).with_context(|| format!("there is no case {number}"))?;
    Ok(PHYSICS.map(|physics| course_of(&case, physics)).concat())
}

fn course_of(case: &Case, physics: Physics) -> String {
    let mut lines = vec![word(physics).to_owned(), case.file()];
    let mut follower = Box::new(Solver::EMPTY);
    for step in [2.0, 1.0, 0.5, 0.25, 0.1, 0.03, 0.01] {
        let course = close(&mut follower, case, physics, step);
        lines.push(format!(
            "  {step:5}° steps: {:<12} {:9.4} N {:10.5} N·mm {:6} iterations",
            course.status.word(),
            course.magnitude(),
            course.energy,
            course.iterations
        ));
    }
    let mut parted = 0;
    let mut at = case.touch;
    while at < case.angle && parted < 4 {
        at = (at + 0.1_f64.to_radians()).min(case.angle);
        let here = Case { angle: at, ..case.clone() };
        let [coarse, fine, finest] = [1.0, 0.1, 0.01].map(|step| close(&mut follower, &here, physics, step));
        let apart = [coarse.apart(&finest), fine.apart(&finest)];
        if apart.iter().any(|&apart| apart > APART) {
            parted += 1;
            lines.push(format!(
                "  at {:7.3}°: 1° {} {:.4} N·mm, 0.1° {} {:.4} N·mm, 0.01° {} {:.4} N·mm; {:.3} and {:.3} mm from the last",
                at.to_degrees(),
                coarse.status,
                coarse.energy,
                fine.status,
                fine.energy,
                finest.status,
                finest.energy,
                apart[0],
                apart[1]
            ));
        }
    }
    lines.join("\n") + "\n"
}

impl fmt::Display for Statistics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (cases, physics) = (self.cases, word(self.physics));
        writeln!(f, "{cases} random fingers and circles, {physics}: status at steps of at most 1° and 0.1°")?;
        writeln!(f, "  {:<16} {:<16} {:>6} {:>15}", "1°", "0.1°", "cases", "other branch")?;
        for ([coarse, fine], [count, other]) in &self.statuses {
            writeln!(f, "  {coarse:<16} {fine:<16} {count:>6} {other:>15}")?;
        }
        let [coarse, fine] = self.mean_iterations;
        writeln!(f, "  iterations per case: {coarse:.1} and {fine:.1}")?;
        let parted = self.parted.len();
        let share = 1e3 * parted as f64 / cases.max(1) as f64;
        writeln!(f, "  another branch at 1° steps: {parted} of {cases} ({share:.2} in 1,000)")?;
        for Parted { number, coarse, fine } in &self.parted {
            writeln!(
                f,
                "    case {number}: {} {:.3} N {:.4} N·mm, {} {:.3} N {:.4} N·mm, {:.2} mm apart",
                coarse.status,
                coarse.magnitude(),
                coarse.energy,
                fine.status,
                fine.magnitude(),
                fine.energy,
                coarse.apart(fine)
            )?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_case_is_counted_once() {
        let statistics = count(20, Physics::Paper);
        assert_eq!(statistics.cases, 20);
        assert_eq!(statistics.statuses.values().map(|[cases, _]| cases).sum::<usize>(), 20);
        let [coarse, fine] = statistics.mean_iterations;
        assert!(0.0 < coarse && coarse < fine, "{coarse} {fine}");
        assert!(statistics.to_string().contains("20 random fingers and circles, paper"));
    }
}
