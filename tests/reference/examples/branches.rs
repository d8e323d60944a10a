//! Does the step size change the branch? Ten thousand random fingers, each closed on its circle in steps of at most 1° and of
//! at most 0.1°, with both physics; what came out, counted. `cargo xtask bench` prints the table.
//!
//!     cargo run --release -p reference-tests --example branches [CASES] [CASE]
//!
//! With one case's number, that case as a file for `fre solve` and its course at several step sizes.

use std::collections::BTreeMap;
use std::env;

use model_core::discretise::{Discretisation, Physics};
use model_core::equilibrium::{Follower, Settings};
use model_core::object::Motion;
use model_core::size::Paper;
use model_core::status::Status;
use rayon::prelude::*;
use reference_tests::random::{Case, Cases};

const SEED: u64 = 10_000;
const CASES: usize = 10_000;
/// Points of two solutions further apart than this, mm, lie on different branches: converged twins agree to 1e-7.
const APART: f64 = 1e-3;

// Room for more touching samples than the microcontroller has.
type Solver = Follower<f64, Paper>;

/// What a case came to.
struct Course {
    status: Status,
    front: Vec<[f64; 2]>,
    back: Vec<[f64; 2]>,
    force: [f64; 2],
    energy: f64,
    iterations: u32,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let numbers = env::args().skip(1).map(|word| word.parse()).collect::<Result<Vec<usize>, _>>()?;
    let cases: Vec<Case> = Cases::seeded(SEED).take(numbers.first().copied().unwrap_or(CASES)).collect();
    for (physics, word) in [(Physics::Paper, "paper"), (Physics::Extended, "extended")] {
        if let Some(case) = numbers.get(1).and_then(|&number| cases.get(number)) {
            look_into(case, physics, word);
            continue;
        }
        statistics(&cases, physics, word);
    }
    Ok(())
}

fn close(follower: &mut Solver, case: &Case, physics: Physics, step_deg: f64) -> Course {
    let blank =
        |status| Course { status, front: Vec::new(), back: Vec::new(), force: [0.0; 2], energy: 0.0, iterations: 0 };
    if follower.configure(&case.design, &Discretisation::reduced(physics)).is_err() {
        return blank(Status::ContactCapacity);
    }
    follower.set_settings(Settings { max_angle_step: step_deg.to_radians(), ..Settings::DEFAULT });
    follower.set_object(case.object(), Motion::Rotating { axis: case.design.motor_axis });
    if !follower.start(case.angle) {
        return blank(Status::OutOfRange);
    }
    let outcome = follower.follow(case.angle);
    Course {
        status: outcome.status,
        front: follower.front().collect(),
        back: follower.back().collect(),
        force: follower.force_world(),
        energy: follower.energy(),
        iterations: outcome.iterations,
    }
}

/// Largest distance of corresponding points of both beams, mm.
fn apart(a: &Course, b: &Course) -> f64 {
    let points = |of: &Course| of.front.iter().chain(&of.back).copied().collect::<Vec<_>>();
    points(a).iter().zip(points(b)).map(|(p, q)| (p[0] - q[0]).hypot(p[1] - q[1])).fold(0.0, f64::max)
}

fn statistics(cases: &[Case], physics: Physics, word: &str) {
    let pairs: Vec<[Course; 2]> = cases
        .par_iter()
        .map_init(
            || Box::new(Solver::EMPTY),
            |follower, case| [1.0, 0.1].map(|step| close(follower, case, physics, step)),
        )
        .collect();
    let mut table: BTreeMap<(&str, &str), [usize; 2]> = BTreeMap::new();
    let mut differing = Vec::new();
    for (number, [coarse, fine]) in pairs.iter().enumerate() {
        let entry = table.entry((coarse.status.word(), fine.status.word())).or_default();
        entry[0] += 1;
        let both = coarse.status.is_trustworthy() && fine.status.is_trustworthy();
        if both && apart(coarse, fine) > APART {
            entry[1] += 1;
            differing.push(number);
        }
    }
    println!("{} random fingers and circles, {word}: status at steps of at most 1° and 0.1°", cases.len());
    println!("  {:<16} {:<16} {:>6} {:>15}", "1°", "0.1°", "cases", "other branch");
    for ((coarse, fine), [count, other]) in &table {
        println!("  {coarse:<16} {fine:<16} {count:>6} {other:>15}");
    }
    let iterations =
        |of: usize| pairs.iter().map(|pair| f64::from(pair[of].iterations)).sum::<f64>() / pairs.len() as f64;
    println!("  iterations per case: {:.1} and {:.1}", iterations(0), iterations(1));
    println!(
        "  another branch at 1° steps: {} of {} ({:.2} in 1,000)",
        differing.len(),
        cases.len(),
        1e3 * differing.len() as f64 / cases.len() as f64
    );
    for number in differing {
        let [coarse, fine] = &pairs[number];
        println!(
            "    case {number}: {} {:.3} N {:.4} N·mm, {} {:.3} N {:.4} N·mm, {:.2} mm apart",
            coarse.status,
            coarse.force[0].hypot(coarse.force[1]),
            coarse.energy,
            fine.status,
            fine.force[0].hypot(fine.force[1]),
            fine.energy,
            apart(coarse, fine)
        );
    }
}

/// One case at several step sizes, and where its courses part.
fn look_into(case: &Case, physics: Physics, word: &str) {
    println!("{word}\n{}", case.file());
    let mut follower = Box::new(Solver::EMPTY);
    for step in [2.0, 1.0, 0.5, 0.25, 0.1, 0.03, 0.01] {
        let course = close(&mut follower, case, physics, step);
        println!(
            "  {step:5}° steps: {:<12} {:9.4} N {:10.5} N·mm {:6} iterations",
            course.status.word(),
            course.force[0].hypot(course.force[1]),
            course.energy,
            course.iterations
        );
    }
    let mut parted = 0;
    let mut at = case.touch;
    while at < case.angle && parted < 4 {
        at = (at + 0.1_f64.to_radians()).min(case.angle);
        let here = Case { angle: at, ..case.clone() };
        let [coarse, fine, finest] = [1.0, 0.1, 0.01].map(|step| close(&mut follower, &here, physics, step));
        let apart = [apart(&coarse, &finest), apart(&fine, &finest)];
        if apart.iter().any(|&apart| apart > APART) {
            parted += 1;
            println!(
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
            );
        }
    }
}
