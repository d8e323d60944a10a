//! Two thousand random fingers on random circles, in both physics and both precisions, each equilibrium checked by code of its own.

use std::collections::BTreeMap;

use model_core::discretise::{Discretisation, Physics};
use model_core::equilibrium::{Follower, Settings};
use model_core::object::Motion;
use model_core::real::Real;
use model_core::size::Paper;
use model_core::status::Status;
use reference_tests::random::{Case, Cases, centre_in_finger};

const CASES: usize = 2000;
/// Every how many cases the fine model is solved too.
const FINE_EVERY: usize = 4;

/// The same of a place on a contact sample, whatever the model and the precision, mm.
const ON_SAMPLES: f64 = 0.02;

/// What is allowed of a model in one precision.
struct Allowed {
    /// How deep a place of the front beam's outer line between two contact samples may lie inside the object beyond what the contact's
    /// softness gives way, mm.
    between: f64,
    /// Distance of a contact from the surface, mm.
    surface: f64,
    /// Components of a normal.
    normal: f64,
    /// Net force and moment, as parts.
    balance: f64,
    /// Distance of the beams' ends at the tip, mm.
    tip: f64,
}

const FINE: Allowed = Allowed { between: 0.02, surface: 1e-8, normal: 1e-9, balance: 1e-9, tip: 1e-9 };
/// The microcontroller's samples lie up to 3 mm apart, and a circle bulges between two of them.
const REDUCED: Allowed = Allowed { between: 0.05, ..FINE };
const SINGLE: Allowed = Allowed { surface: 2e-4, normal: 2e-4, balance: 2e-4, tip: 3e-4, ..REDUCED };

type Solver<T> = Box<Follower<T, Paper>>;

fn solve<T: Real>(follower: &mut Follower<T, Paper>, case: &Case, how: &Discretisation, max_step: f64) -> Status {
    follower.configure(&case.design, how).expect("a valid design");
    follower
        .set_settings(Settings { max_angle_step: max_step.to_radians(), ..Settings::DEFAULT })
        .expect("an allowed step");
    follower.set_object(case.object(), Motion::Rotating { axis: case.design.motor_axis });
    if !follower.start(case.angle) {
        return Status::OutOfRange;
    }
    follower.follow(case.angle).status
}

/// Places on the front's cubic Hermite curves, eight for each quadratic element, from the elements' ends and middles alone. The clamped
/// base, which is no contact sample and cannot give way, and the first quarter of the first element are left out. An element's end
/// tangents a and b follow from its middle: they are as long as the element, which holds without stretch only, and a − b is eight times
/// the middle's distance from the chord's.
fn places(front: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut places = Vec::new();
    for element in front.windows(3).step_by(2) {
        let [start, middle, end] = [element[0], element[1], element[2]];
        let chord = [end[0] - start[0], end[1] - start[1]];
        let apart = [0, 1].map(|i| 8.0 * (middle[i] - 0.5 * (start[i] + end[i])));
        // The arc's length by Simpson's rule over both halves' chords: a third of what the straight one lacks.
        let halves = [[start, middle], [middle, end]].map(|[p, q]| (q[0] - p[0]).hypot(q[1] - p[1]));
        let broken = halves[0] + halves[1];
        let length = broken + (broken - chord[0].hypot(chord[1])) / 3.0;
        let across = [-apart[1], apart[0]];
        let size = apart[0].hypot(apart[1]);
        let sum = if size > 0.0 {
            let along =
                (4.0 * length * length - size * size).sqrt().copysign(across[0] * chord[0] + across[1] * chord[1]);
            across.map(|x| x * along / size)
        } else {
            chord.map(|x| 2.0 * x)
        };
        for eighth in 1..=8 {
            let t = 0.125 * f64::from(eighth);
            let (h01, h10, h11) = (t * t * (3.0 - 2.0 * t), t * (1.0 - t) * (1.0 - t), t * t * (t - 1.0));
            let (mut place, mut tangents) = (start, [[0.0; 2]; 2]);
            for i in 0..2 {
                tangents[0][i] = 0.5 * (sum[i] + apart[i]);
                tangents[1][i] = 0.5 * (sum[i] - apart[i]);
                place[i] += h01 * chord[i] + h10 * tangents[0][i] + h11 * tangents[1][i];
            }
            places.push(place);
        }
    }
    places.split_off(2)
}

fn fail(what: &str, value: f64) -> Result<(), String> {
    Err(format!("{what}: {value:e}"))
}

/// What an equilibrium must satisfy, computed from the shape and the forces that the solver reports.
fn check<T: Real>(
    follower: &Follower<T, Paper>,
    case: &Case,
    physics: Physics,
    allowed: &Allowed,
) -> Result<(), String> {
    let solution = follower.solution();
    let softness = follower.softness().to_f64();
    let Case { design, radius, .. } = case;
    let (angle, m) = (solution.coordinate(), design.motor_axis);
    let centre = centre_in_finger(design, case.centre, angle);
    let half = 0.5 * design.front.thickness.at(0.0);

    let largest = solution.contacts().fold(0.0_f64, |most, c| most.max(c.force.to_f64()));
    let front: Vec<[f64; 2]> = solution.front().map(|point| point.map(Real::to_f64)).collect();
    let between = if matches!(physics, Physics::Paper) { places(&front) } else { Vec::new() };
    let deep = |places: &[[f64; 2]]| {
        let gap = |place: &[f64; 2]| (place[0] - centre[0]).hypot(place[1] - centre[1]) - radius - half;
        places.iter().map(gap).fold(f64::MAX, f64::min) + softness * largest
    };
    // The base, which cannot give way, is no sample; all other points are.
    if deep(&front[1..]) < -ON_SAMPLES {
        return fail("a front point lies inside the object", deep(&front[1..]));
    }
    if deep(&between) < -allowed.between {
        return fail("the front lies inside the object between two samples", deep(&between));
    }
    let (mut force, mut moment) = ([0.0; 2], 0.0);
    for contact in solution.contacts() {
        let (place, size) = (contact.position.map(Real::to_f64), contact.force.to_f64());
        let offset = [place[0] - centre[0], place[1] - centre[1]];
        let distance = offset[0].hypot(offset[1]);
        if size < 0.0 {
            return fail("a contact pulls", size);
        }
        if (distance - radius + softness * size).abs() > allowed.surface {
            return fail("a contact is off the surface", distance - radius + softness * size);
        }
        for i in 0..2 {
            if (contact.normal[i].to_f64() - offset[i] / distance).abs() > allowed.normal {
                return fail("a force is not along the normal", contact.normal[i].to_f64());
            }
            force[i] -= size * offset[i] / distance;
        }
        moment += (centre[0] - m[0]) * -size * offset[1] / distance - (centre[1] - m[1]) * -size * offset[0] / distance;
    }
    for i in 0..2 {
        let net = solution.force_finger()[i].to_f64();
        if (force[i] - net).abs() > allowed.balance * (1.0 + largest) {
            return fail("the net force is not the sum of the contacts", force[i] - net);
        }
    }
    let torque = solution.motor_torque().to_f64();
    if (torque + moment).abs() > allowed.balance.max(1e-6) * (1.0 + moment.abs()) {
        return fail("the torque is not the force's moment", torque + moment);
    }
    // The beams meet at the tip, and bend no link out of length.
    let tip = solution.tip().map(Real::to_f64);
    let back = solution.back().last().expect("a back beam").map(Real::to_f64);
    if (tip[0] - back[0]).hypot(tip[1] - back[1]) > allowed.tip {
        return fail("the tip is open", tip[0] - back[0]);
    }
    for lamella in solution.lamellae() {
        let [front, back] = lamella.map(|end| end.map(Real::to_f64));
        let length = (front[0] - back[0]).hypot(front[1] - back[1]);
        if length > 28.0 * 1.3 || length <= 0.0 {
            return fail("a lamella has no length", length);
        }
    }
    Ok(())
}

/// τ = d(V + ½ ε Σ μ²)/dα: independent of the multipliers, and only true at an equilibrium. `None` at the end of a branch, where there
/// is no derivative.
fn work_is_torque(follower: &mut Follower<f64, Paper>) -> Option<Result<(), String>> {
    let (angle, torque, softness) =
        (follower.solution().coordinate(), follower.solution().motor_torque(), follower.softness());
    let total = |f: &Follower<f64, Paper>| {
        f.solution().energy() + f.solution().contacts().map(|c| 0.5 * softness * c.force * c.force).sum::<f64>()
    };
    let mut rates = [0.0; 2];
    for (rate, h) in rates.iter_mut().zip([2e-5, 1e-5]) {
        let mut side = [0.0; 2];
        for (energy, by) in side.iter_mut().zip([h, -h]) {
            if !follower.follow(angle + by).status.is_trustworthy() {
                return None;
            }
            *energy = total(follower);
        }
        *rate = (side[0] - side[1]) / (2.0 * h);
    }
    let rate = (4.0 * rates[1] - rates[0]) / 3.0;
    // A contact that opens or closes within the difference leaves a kink of first order in h.
    Some(if (rate - torque).abs() > 1e-3 * torque.abs() + 1e-2 {
        fail("the torque is not the energy's derivative", rate / torque - 1.0)
    } else {
        Ok(())
    })
}

/// Distance of two forces as a part of the second, or of 0.1 N where that is more.
fn apart(single: &Follower<f32, Paper>, double: &Follower<f64, Paper>) -> f64 {
    let (one, other) = (single.solution().force_world().map(f64::from), double.solution().force_world());
    (one[0] - other[0]).hypot(one[1] - other[1]) / other[0].hypot(other[1]).max(0.1)
}

fn random_designs(physics: Physics) {
    let mut double: Solver<f64> = Box::new(Follower::EMPTY);
    let mut single: Solver<f32> = Box::new(Follower::EMPTY);
    let (reduced, fine) = (Discretisation::reduced(physics), Discretisation::fine(physics));
    // Cases by the statuses of the reduced model in double and in single precision and of the fine model.
    let mut table: BTreeMap<[&str; 3], Vec<usize>> = BTreeMap::new();
    let (mut trusted, mut ends, mut off) = ([0; 2], Vec::new(), Vec::new());
    for (number, case) in Cases::seeded(2000).take(CASES).enumerate() {
        let wrong = |which: &str, what: String| panic!("case {number}, {physics:?}, {which}: {what}\n{}", case.file());
        let statuses = [solve(&mut double, &case, &reduced, 1.0), solve(&mut single, &case, &reduced, 1.0)];
        let good = statuses.map(Status::is_trustworthy);
        if good[0] {
            check(&double, &case, physics, &REDUCED).unwrap_or_else(|what| wrong("f64", what));
        }
        if good[1] {
            check(&single, &case, physics, &SINGLE).unwrap_or_else(|what| wrong("f32", what));
        }
        if good == [true; 2] && apart(&single, &double) > 1e-3 {
            off.push((number, apart(&single, &double)));
        }
        if good[0] {
            match work_is_torque(&mut double) {
                Some(result) => result.unwrap_or_else(|what| wrong("f64", what)),
                None => ends.push(number),
            }
        }
        for (count, good) in trusted.iter_mut().zip(good) {
            *count += usize::from(good);
        }
        let mut word = "";
        if !good[0] || number % FINE_EVERY == 0 {
            let status = solve(&mut double, &case, &fine, if good[0] { 1.0 } else { 0.1 });
            if status.is_trustworthy() {
                check(&double, &case, physics, &FINE).unwrap_or_else(|what| wrong("fine", what));
            }
            word = status.word();
        }
        table.entry([statuses[0].word(), statuses[1].word(), word]).or_default().push(number);
    }
    let all = format!("{trusted:?} of {CASES} trusted, ends of branches {ends:?}, f32 off {off:?}\n{table:?}");
    assert!(trusted.iter().all(|&count| count * 100 >= CASES * 99), "{all}");
    assert!((ends.len() + off.len()) * 1000 <= CASES * 5, "{all}");
}

#[test]
fn two_thousand_random_designs_of_the_paper() {
    random_designs(Physics::Paper);
}

#[test]
fn two_thousand_random_designs_extended() {
    random_designs(Physics::Extended);
}
