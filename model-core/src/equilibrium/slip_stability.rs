//! The stability test with friction against the eigenvalues of the whole, unsymmetric tangent, on states of random fingers.

use std::boxed::Box;
use std::vec::Vec;

use nalgebra::DMatrix;

use super::Follower;
use crate::contact::{ContactState, Direction, Row};
use crate::discretise::{Discretisation, Elements, Physics};
use crate::linear::symmetric;
use crate::newton::condense::Diagonal;
use crate::newton::tests::{Place, Rubbing, dense, frozen_points, places};
use crate::newton::turning::Patches;
use crate::object::{Motion, ObjectDesign};
use crate::random_designs::{Random, first_contact, random_case};
use crate::size::Size;

type Solver = Follower<f64, Rubbing>;

/// Negative pivots less those of the closures, and negative eigenvalues of D on the rows that are equations, less the turning's own.
fn inertia(follower: &mut Solver) -> isize {
    let work = &mut follower.work;
    work.contacts.add_turning(Rubbing::CONTACTS);
    let negative = work.factorise(&follower.model, &mut follower.factored, Diagonal { curvature: 1.0, shift: 0.0 });
    let rows = work.contacts.rows();
    let equations: Vec<usize> =
        (0..rows.len()).filter(|&j| matches!(rows[j].state, ContactState::Closed | ContactState::Stick)).collect();
    let count = equations.len();
    let mut matrix: Vec<f64> = Vec::new();
    for &i in &equations {
        matrix.extend(equations.iter().map(|&j| follower.factored.border.flexibility[i * Rubbing::CONTACTS + j]));
    }
    let border = symmetric::factorise(&mut matrix, count, count, &mut vec![0; count]) as isize;
    negative as isize - 2 * follower.model.cells() as isize - (border - work.contacts.turning_negative())
}

/// Touching samples, each with a row that says how it moves along the object.
fn rows_of_dense(follower: &mut Solver) -> usize {
    let rows = follower.work.contacts.rows();
    let mut all: Vec<Row<f64>> = Vec::new();
    for [tangent, normal] in rows.as_chunks::<2>().0.iter().filter(|[_, normal]| normal.touches()) {
        let [x, y] = normal.normal;
        let along = Row { direction: Direction::Turning, normal: [-y, x], softness: 0.0, multiplier: 0.0, ..*normal };
        all.extend([*tangent, *normal, along]);
    }
    follower.work.contacts.rows[..all.len()].copy_from_slice(&all);
    (follower.work.contacts.count, follower.work.contacts.patches) = (all.len(), Patches::NONE);
    all.len()
}

/// Eigenvalues of the unsymmetric tangent in the angles, with a negative real part, and the smallest magnitude of a real part; normals and
/// tangents turn with the object, and what slips keeps τ = ±m μ.
fn eigenvalues(follower: &mut Solver) -> (isize, f64) {
    let count = rows_of_dense(follower);
    let coefficient = follower.work.history.slip.coefficient;
    let Solver { model, timeline, work, .. } = follower;
    let places = places(model, count);
    let frozen = frozen_points(work);
    let matrix = dense(model, &mut timeline.present, work, &frozen, &places);
    let angles = places.iter().filter(|place| matches!(place, Place::Node(_) | Place::Joint(_))).count();
    let x = places.len() - count;
    // Unknowns: angles and λ, then per sample μ, τ of what sticks (else a placeholder), and the way w along the object.
    let n = places.len();
    let mut a = DMatrix::<f64>::zeros(n, n);
    for (sample, [tangent, normal, _]) in work.contacts.rows[..count].as_chunks::<3>().0.iter().enumerate() {
        let (t, p, v) = (x + 3 * sample, x + 3 * sample + 1, x + 3 * sample + 2);
        let sign = match tangent.state {
            ContactState::SlipUp => coefficient,
            ContactState::SlipDown => -coefficient,
            _ => 0.0,
        };
        let sticks = tangent.state == ContactState::Stick;
        for i in 0..n {
            // The pull μ n + τ t of all rows i on sample's unknowns; t is against the direction in which the normal turns.
            a[(i, p)] += matrix[(i, p)] + sign * matrix[(i, t)];
            if sticks {
                a[(i, t)] += matrix[(i, t)];
            }
            let turned = normal.curvature * (normal.multiplier * matrix[(i, v)] + tangent.multiplier * matrix[(i, p)]);
            a[(i, v)] += turned;
        }
        // The softness is that of μ alone.
        a[(p, v)] += normal.softness * normal.curvature * tangent.multiplier;
    }
    for j in 0..x {
        for i in 0..n {
            a[(i, j)] += matrix[(i, j)];
        }
    }
    for (sample, [tangent, ..]) in work.contacts.rows[..count].as_chunks::<3>().0.iter().enumerate() {
        let (t, v) = (x + 3 * sample, x + 3 * sample + 2);
        if tangent.state != ContactState::Stick {
            a.row_mut(t).fill(0.0);
            a[(t, t)] = 1.0;
        }
        // The row along the object is −∂(t̂·P): w + row = 0.
        a[(v, v)] += 1.0;
    }
    let rest = n - angles;
    let (inner, beside) = (a.view((angles, angles), (rest, rest)).clone_owned(), a.view((angles, 0), (rest, angles)));
    let solved = inner.lu().solve(&beside.clone_owned()).expect("a regular block");
    let tangent = a.view((0, 0), (angles, angles)) - a.view((0, angles), (angles, rest)) * solved;
    let values = tangent.complex_eigenvalues();
    let negative = values.iter().filter(|value| value.re < 0.0).count();
    (negative as isize, values.iter().fold(f64::MAX, |least, value| least.min(value.re.abs())))
}

#[test]
fn the_inertia_counts_unstable_directions_of_the_unsymmetric_tangent() {
    let mut random = Random::new(41);
    let how = Discretisation {
        elements: Elements::PerSpan { span: 1, tip_span: 2, hinge: 1 },
        ..Discretisation::estimator(Physics::Extended)
    };
    let (mut states, mut unstable, mut partly, mut differ) = (0, 0, 0, 0);
    let mut follower: Box<Solver> = Box::new(Follower::EMPTY);
    while states < 1000 {
        let (design, round, indentation) = random_case(&mut random);
        let coefficient = 0.1 + 0.9 * random.unit();
        follower.configure(&design, &how).expect("a valid design");
        let object = ObjectDesign::Circle { centre: round.centre, radius: round.radius };
        follower.set_object(object, Motion::Rotating { axis: design.motor_axis });
        follower.set_friction(coefficient).expect("a coefficient in range");
        let first = first_contact(&design, round.centre, round.radius);
        assert!(follower.start(first - 0.001));
        // Closing, a reversal, and closing again.
        let path = (1..=20).map(|k| f64::from(k) / 20.0).chain([0.985, 0.96, 0.9, 0.8, 0.85, 0.9]);
        for part in path {
            if !follower.follow(first + part * indentation).status.is_trustworthy() {
                break;
            }
            // As they are, and under forces beyond those of an equilibrium, where many are unstable.
            for strength in [1.0, 1.5, 2.5] {
                let present = &mut follower.timeline.present;
                present.lambda.iter_mut().flatten().for_each(|force| *force *= strength);
                present.multiplier.iter_mut().for_each(|force| *force *= strength);
                present.tangential.iter_mut().for_each(|force| *force *= strength);
                let at = follower.timeline.at();
                follower.aim(at);
                let object = follower.seen(at);
                let Solver { model, timeline, work, .. } = &mut *follower;
                work.evaluate(model, &timeline.present, &object, 0.0);
                if work.contacts.rows().iter().any(Row::touches) && work.contacts.count <= 24 {
                    let slips =
                        |row: &Row<f64>| row.direction == Direction::Tangent && row.state == ContactState::Stick;
                    let sticks = work.contacts.rows().iter().filter(|row| slips(row)).count();
                    let found = inertia(&mut follower);
                    let Solver { model, timeline, work, .. } = &mut *follower;
                    work.evaluate(model, &timeline.present, &object, 0.0);
                    let (expected, margin) = eigenvalues(&mut follower);
                    // A state within rounding of a singular one has no inertia to agree on.
                    if margin > 1e-3 {
                        states += 1;
                        unstable += usize::from(expected > 0);
                        partly += usize::from(sticks > 0);
                        if found != expected {
                            assert!(strength != 1.0, "an equilibrium: {found} for {expected}");
                            differ += 1;
                            std::println!(
                                "m {coefficient:.2} at {part}, {strength} times: {found} for {expected}, nearest {margin:.1e}, {sticks} stick"
                            );
                        }
                    }
                }
                follower.show_accepted();
            }
        }
    }
    std::println!("{states} states, {unstable} unstable, {partly} partly stick, {differ} differ");
    assert!(unstable > 100 && partly > 30, "{unstable} {partly}");
    assert!(differ <= states / 200, "{differ}");
}
