//! Coulomb friction on the dense border: each touching place sticks, or slips one way, on an exact cone |τ| ≤ m μ.
//!
//! | state | equations | while |
//! |---|---|---|
//! | open | μ = τ = 0 | w_n ≥ 0 |
//! | stick | w_n = 0, w_t = 0 | \|τ\| ≤ m μ |
//! | slip σ = ±1 | w_n = 0, τ = σ m μ | μ ≥ 0, σ w_t ≤ 0 |
//!
//! w = D Δ − b are the rows' residuals after the step: a place's gap w_n, and its slip w_t since the last accepted state. A place has two
//! rows, its tangent's before its normal's. D is symmetric; a place that slips gives the column D·n + σ m D·t, so the equations are not,
//! and are solved by [`crate::linear::lu`].
//!
//! Where the beam slides along a round object the normals turn, and the forces with them. The turning row (`newton::turning`) is the force
//! t ϑ Σμ of the normals' turn ϑ; the tangential forces turn along, by n ϑ Σ|τ|, which is so much of that row's multiplier put on the normal
//! beside it ([`turn`]). Without it an iteration leaves that force behind.
//!
//! The order in which states change decides whether they settle. All places change at once, until a set comes again; then only the one
//! that is furthest off does. (a) What sticks beyond its cone slips that way, even if it pulls. (b) Only what slips and pulls opens.
//! (c) What closes slips against its trial slip. (d) What slips the wrong way sticks. If what closes begins by sticking, or what sticks and
//! pulls opens, a reversal of the motion is lost within degrees.

use super::frictionless::{Problem, Settled};
use super::{ContactState, Direction, Row};
use crate::access::Access;
use crate::linear::lu;
use crate::linear::symmetric::{entry, factorise, factorise_in_order, product};
use crate::real::Real;

/// Sets that are remembered: one that comes again ends the changes of all places at once.
const REMEMBERED: usize = 24;

/// Sets that are tried where an iteration's work is bounded: so many, but two once this is spent, the sum of the cubes of their equations.
const FEW_SETS: usize = 3;
const SPENT: usize = 20_000;

/// What the contacts obey.
#[derive(Clone, Copy)]
pub(crate) struct Law<T> {
    /// Coefficient of friction m.
    pub coefficient: T,
    /// How everything that touches slips, whatever it did before; [`ContactState::Open`] if it is free.
    pub forced: ContactState,
    /// Few sets are tried: the next iteration goes on from there.
    pub is_bounded: bool,
}

impl<T> Law<T> {
    fn is_forced(&self) -> bool {
        self.forced != ContactState::Open
    }
}

/// Adds to the rows' steps, or takes away with a `part` of −1, what the turnings put on the normals beside them: the normal is the row before, and
/// gets so much of the turning's multiplier as the tangential forces are of the normal ones.
pub(crate) fn turn<T: Real>(rows: &[Row<T>], part: T, delta: &mut [T]) {
    for (turning, row) in rows.iter().enumerate().filter(|(_, row)| row.direction == Direction::Turning) {
        let turned = row.tilt * delta.at(turning);
        delta.add(turning.wrapping_sub(1), part * turned);
    }
}

/// Finds the rows' new states, from the present ones on, and the steps Δμ, Δτ of all rows: those of the multipliers, without what
/// the turnings put on normals ([`turn`]).
pub(crate) fn settle<T: Real>(
    problem: &mut Problem<'_, T>,
    law: Law<T>,
    count: usize,
    states: &mut [ContactState],
    delta: &mut [T],
) -> Settled {
    let mut outcome = Settled { settled: false, negative: 0, factorised: 0 };
    let (Some(states), Some(delta)) = (states.get_mut(..count), delta.get_mut(..count)) else { return outcome };
    for (state, row) in states.iter_mut().zip(problem.rows) {
        let touches = row.direction == Direction::Tangent && row.state != ContactState::Open;
        *state = if law.is_forced() && touches { law.forced } else { row.state };
    }
    let coefficient = law.coefficient;
    problem.rows = problem.rows.get(..count).unwrap_or(&[]);
    let (mut seen, mut one_by_one, mut work) = ([0_u32; REMEMBERED], false, 0);
    for pass in 0..4 * count + REMEMBERED {
        let mark = fingerprint(states);
        one_by_one |= pass >= REMEMBERED || seen.iter().take(pass).any(|&earlier| earlier == mark);
        if let Some(slot) = seen.get_mut(pass) {
            *slot = mark;
        }
        solve_on(problem, coefficient, states, delta);
        let mut worst: Option<(usize, Change, T)> = None;
        let mut changed = false;
        for tangent in (0..count).filter(|&j| is_tangent(problem.rows, j)) {
            let Some((change, size)) = wanted(problem, law, tangent, states, delta) else { continue };
            if one_by_one {
                if worst.is_none_or(|(_, _, most)| size > most) {
                    worst = Some((tangent, change, size));
                }
            } else {
                change.make(states, tangent);
                changed = true;
            }
        }
        if let Some((tangent, change, _)) = worst {
            change.make(states, tangent);
            changed = true;
        }
        if !changed {
            outcome.settled = true;
            outcome.negative = negative(problem, count, states);
            break;
        }
        let equations = states.iter().filter(|&&state| is_equation(state)).count();
        work += equations * equations * equations;
        if law.is_bounded && (pass + 1 >= FEW_SETS || pass > 0 && work >= SPENT) {
            // The states are new, the steps those of the states before.
            break;
        }
    }
    if !outcome.settled && !law.is_bounded {
        solve_on(problem, coefficient, states, delta);
    }
    turn(problem.rows, -T::one(), delta);
    outcome
}

/// A row is a place's tangent; its normal is the next one.
fn is_tangent<T>(rows: &[Row<T>], row: usize) -> bool {
    rows.get(row).is_some_and(|row| row.direction == Direction::Tangent)
}

/// A place's next state: of its tangent, and of its normal.
#[derive(Clone, Copy)]
struct Change(ContactState, ContactState);

impl Change {
    fn make(self, states: &mut [ContactState], tangent: usize) {
        if let Some([along, normal]) = states.get_mut(tangent..tangent + 2) {
            (*along, *normal) = (self.0, self.1);
        }
    }
}

/// Slip with a tangential force of this sign.
fn slip<T: Real>(towards: T) -> ContactState {
    if towards < T::ZERO { ContactState::SlipDown } else { ContactState::SlipUp }
}

/// What a place wants to become, and by how much its present state is violated, as a length.
fn wanted<T: Real>(
    problem: &Problem<'_, T>,
    law: Law<T>,
    tangent: usize,
    states: &[ContactState],
    delta: &[T],
) -> Option<(Change, T)> {
    let (stride, coefficient) = (problem.stride, law.coefficient);
    let normal = tangent + 1;
    let residual = |row: usize| {
        let run = problem.flexibility.get(row * stride..).unwrap_or(&[]);
        product(run, delta) - problem.rhs.at(row)
    };
    let turned = |row: usize| match problem.rows.get(row + 1) {
        Some(turning) if turning.direction == Direction::Turning => turning.tilt * delta.at(row + 1),
        _ => T::ZERO,
    };
    let total =
        |row: usize| problem.rows.get(row).map_or(T::ZERO, |row| row.multiplier) + (delta.at(row) - turned(row));
    let own = |row: usize| entry(problem.flexibility, stride, row, row).abs();
    let (push, along) = (total(normal), total(tangent));
    match states.at(tangent) {
        ContactState::Stick => {
            let beyond = (along.abs() - coefficient * push.max(T::ZERO)) * own(tangent);
            (beyond > problem.tolerance).then(|| (Change(slip(along), ContactState::Closed), beyond))
        }
        ContactState::SlipUp | ContactState::SlipDown => {
            if push < T::ZERO {
                return Some((Change(ContactState::Open, ContactState::Open), -push * own(normal)));
            }
            if law.is_forced() {
                return None;
            }
            let slid = residual(tangent);
            let wrong = if states.at(tangent) == ContactState::SlipUp { slid } else { -slid };
            (wrong > problem.tolerance).then_some((Change(ContactState::Stick, ContactState::Closed), wrong))
        }
        ContactState::Open | ContactState::Closed => {
            let depth = -residual(normal);
            let closes = || if law.is_forced() { law.forced } else { slip(-residual(tangent)) };
            (depth > problem.tolerance).then(|| (Change(closes(), ContactState::Closed), depth))
        }
    }
}

/// Sign of the tangential force of a place that slips; zero for any other.
fn sign<T: Real>(state: ContactState) -> T {
    match state {
        ContactState::SlipUp => T::one(),
        ContactState::SlipDown => -T::one(),
        _ => T::ZERO,
    }
}

/// The row is an equation of its own: a normal or a turning that is closed, a tangent that sticks.
fn is_equation(state: ContactState) -> bool {
    matches!(state, ContactState::Closed | ContactState::Stick)
}

/// Solves for the steps of all rows in their present states, with what the turnings put on normals.
fn solve_on<T: Real>(problem: &mut Problem<'_, T>, coefficient: T, states: &[ContactState], delta: &mut [T]) {
    let stride = problem.stride.max(1);
    // What is not an equation: open rows give up their multipliers, slipping ones go to the cone of the present normal force.
    for (j, ((delta, row), &state)) in delta.iter_mut().zip(problem.rows).zip(states).enumerate() {
        let towards = coefficient * sign(state);
        let push = problem.rows.get(j + 1).map_or(T::ZERO, |normal| normal.multiplier);
        *delta = if is_equation(state) { T::ZERO } else { towards * push - row.multiplier };
    }
    let (mut listed, mut taking) = (0, 0);
    for (j, _) in states.iter().enumerate().filter(|(_, state)| is_equation(**state)) {
        problem.listed.put(listed, j as u16);
        // What it takes along of the row before it: a normal that slips of its tangent, the turning of the normal beside it.
        let beside = j.checked_sub(1).filter(|&before| is_tangent(problem.rows, before));
        let along = match problem.rows.get(j) {
            Some(turning) if turning.direction == Direction::Turning => turning.tilt,
            _ => beside.map_or(T::ZERO, |tangent| coefficient * sign::<T>(states.at(tangent))),
        };
        problem.spare.put(listed, along);
        if along != T::ZERO {
            problem.order.put(taking, listed as u16);
            taking += 1;
        }
        listed += 1;
    }
    let taking = problem.order.get(..taking).unwrap_or(&[]);
    let places = problem.listed.get(..listed).unwrap_or(&[]);
    for ((into, value), &j) in problem.factored.chunks_mut(stride).zip(&mut *problem.scratch).zip(places) {
        let j = usize::from(j);
        let Some(row) = problem.flexibility.get(j * stride..(j + 1) * stride) else { return };
        *value = problem.rhs.at(j) - product(row, delta);
        for (slot, &k) in into.iter_mut().zip(places) {
            *slot = row.at(usize::from(k));
        }
        for &column in taking {
            let column = usize::from(column);
            into.add(column, problem.spare.at(column) * row.at(usize::from(places.at(column)).wrapping_sub(1)));
        }
    }
    lu::factorise(problem.factored, listed, stride, problem.order);
    lu::solve(problem.factored, listed, stride, problem.order, problem.scratch);
    for (&j, &step) in places.iter().zip(&*problem.scratch) {
        let j = usize::from(j);
        delta.put(j, step);
        if let Some(tangent) = j.checked_sub(1).filter(|&before| is_tangent(problem.rows, before)) {
            let towards = coefficient * sign::<T>(states.at(tangent));
            if towards != T::ZERO {
                delta.add(tangent, towards * step);
            }
        }
    }
    turn(problem.rows, T::one(), delta);
}

/// Negative eigenvalues of D on the rows that are equations: what the stability test compares.
///
/// Under slip the tangent matrix is not symmetric. With normal and tangent of what sticks and the normal only of what slips the count equals
/// that of the matrix's eigenvalues with a negative real part (test `friction_stability`).
fn negative<T: Real>(problem: &mut Problem<'_, T>, count: usize, states: &[ContactState]) -> usize {
    let stride = problem.stride.max(1);
    let mut listed = 0;
    for j in (0..count).filter(|&j| is_equation(states.at(j))) {
        problem.listed.put(listed, j as u16);
        listed += 1;
    }
    copy(problem, listed);
    if factorise_in_order(problem.factored, 0, listed, stride, problem.order) {
        return (0..listed).filter(|&i| entry(problem.factored, stride, i, i) < T::ZERO).count();
    }
    copy(problem, listed);
    factorise(problem.factored, listed, stride, problem.order)
}

/// Copies D of the listed rows.
fn copy<T: Real>(problem: &mut Problem<'_, T>, listed: usize) {
    let stride = problem.stride.max(1);
    let places = problem.listed.get(..listed).unwrap_or(&[]);
    for (into, &j) in problem.factored.chunks_mut(stride).zip(places) {
        let row = problem.flexibility.get(usize::from(j) * stride..).unwrap_or(&[]);
        for (slot, &k) in into.iter_mut().zip(places) {
            *slot = row.at(usize::from(k));
        }
    }
}

/// A number by which sets of states are distinguished (FNV-1a).
fn fingerprint(states: &[ContactState]) -> u32 {
    states.iter().fold(0x811c_9dc5, |hash, &state| (hash ^ state as u32).wrapping_mul(0x0100_0193))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random_designs::Random;
    use crate::size::Blank;
    use nalgebra::DMatrix;
    use std::vec::Vec;

    /// Tangent and normal of a place in these states, with these forces.
    fn place(along: (ContactState, f64), push: f64) -> [Row<f64>; 2] {
        let normal = if along.0 == ContactState::Open { ContactState::Open } else { ContactState::Closed };
        [
            Row { direction: Direction::Tangent, state: along.0, multiplier: along.1, ..Row::BLANK },
            Row { state: normal, multiplier: push, ..Row::BLANK },
        ]
    }

    fn solved(
        flexibility: &[f64],
        rhs: &[f64],
        rows: &[Row<f64>],
        coefficient: f64,
    ) -> (Settled, Vec<ContactState>, Vec<f64>) {
        solved_by(flexibility, rhs, rows, Law { coefficient, forced: ContactState::Open, is_bounded: false })
    }

    fn solved_by(
        flexibility: &[f64],
        rhs: &[f64],
        rows: &[Row<f64>],
        law: Law<f64>,
    ) -> (Settled, Vec<ContactState>, Vec<f64>) {
        let n = rows.len();
        let (mut states, mut delta) = (vec![ContactState::Open; n], vec![0.0; n]);
        let mut problem = Problem {
            flexibility,
            stride: n,
            rhs,
            rows,
            tolerance: 1e-9,
            factored: &mut vec![0.0; n * n],
            order: &mut vec![0; n],
            listed: &mut vec![0; n],
            factorised: 0,
            scratch: &mut vec![0.0; n],
            spare: &mut vec![0.0; n],
        };
        let settled = settle(&mut problem, law, n, &mut states, &mut delta);
        (settled, states, delta)
    }

    /// One place on a support of unit flexibility both ways.
    fn one(rhs: [f64; 2], rows: [Row<f64>; 2]) -> (Vec<ContactState>, [f64; 2]) {
        let (settled, states, delta) = solved(&[1.0, 0.0, 0.0, 1.0], &rhs, &rows, 0.5);
        assert!(settled.settled, "{rhs:?}");
        (states, [0, 1].map(|j| rows[j].multiplier + delta[j]))
    }

    use ContactState::{Closed, Open, SlipDown, SlipUp, Stick};

    #[test]
    fn a_place_sticks_slips_opens_and_closes() {
        // Pressed by 4 more, drawn along by 1: within the cone it sticks; by 3, it slips.
        assert_eq!(one([1.0, 4.0], place((Stick, 0.0), 1.0)), (vec![Stick, Closed], [1.0, 5.0]));
        assert_eq!(one([3.0, 4.0], place((Stick, 0.0), 1.0)), (vec![SlipUp, Closed], [2.5, 5.0]));
        assert_eq!(one([-3.0, 4.0], place((Stick, 0.0), 1.0)), (vec![SlipDown, Closed], [-2.5, 5.0]));
        // Drawn back, what slips sticks; drawn back far, it slips the other way.
        assert_eq!(one([-1.0, 0.0], place((SlipUp, 1.0), 2.0)), (vec![Stick, Closed], [0.0, 2.0]));
        assert_eq!(one([-3.0, 0.0], place((SlipUp, 1.0), 2.0)), (vec![SlipDown, Closed], [-1.0, 2.0]));
        // Lifted, it opens whatever it did.
        assert_eq!(one([0.2, -3.0], place((Stick, 0.1), 2.0)), (vec![Open, Open], [0.0, 0.0]));
        assert_eq!(one([0.2, -3.0], place((SlipDown, -1.0), 2.0)), (vec![Open, Open], [0.0, 0.0]));
        // A gap that is violated closes; where it would not have slipped far, it sticks.
        assert_eq!(one([9.0, 2.0], place((Open, 0.0), 0.0)), (vec![SlipUp, Closed], [1.0, 2.0]));
        assert_eq!(one([0.5, 2.0], place((Open, 0.0), 0.0)), (vec![Stick, Closed], [0.5, 2.0]));
        assert_eq!(one([0.5, -2.0], place((Open, 0.0), 0.0)), (vec![Open, Open], [0.0, 0.0]));
    }

    /// A random support of some places, with its coefficient, rows, and right-hand side.
    fn support(random: &mut Random) -> (DMatrix<f64>, f64, Vec<Row<f64>>, Vec<f64>) {
        let places = 1 + (3.0 * (1.0 + random.signed())) as usize;
        let n = 2 * places;
        let root = DMatrix::from_fn(n, n, |_, _| random.signed());
        let matrix = &root * root.transpose() + DMatrix::identity(n, n) * 0.5;
        let m = 0.1 + 0.9 * random.unit();
        let mut rows = Vec::new();
        for _ in 0..places {
            let push = random.unit();
            rows.extend(match (4.0 * random.unit()) as usize {
                0 => place((Open, 0.0), 0.0),
                1 => place((Stick, m * push * random.signed()), push),
                2 => place((SlipUp, m * push), push),
                _ => place((SlipDown, -m * push), push),
            });
        }
        let rhs = (0..n).map(|_| random.signed()).collect();
        (matrix, m, rows, rhs)
    }

    /// Every place obeys its law with these forces and residuals.
    fn obey(states: &[ContactState], forces: &[f64], residuals: &[f64], m: f64) {
        for tangent in (0..states.len()).step_by(2) {
            let (along, push) = (forces[tangent], forces[tangent + 1]);
            let (slip, gap) = (residuals[tangent], residuals[tangent + 1]);
            let near = |a: f64, b: f64| (a - b).abs() < 1e-7;
            match states[tangent] {
                Open => assert!(near(along, 0.0) && near(push, 0.0) && gap > -1e-8, "{along} {push} {gap}"),
                Stick => assert!(near(slip, 0.0) && near(gap, 0.0) && along.abs() <= m * push + 1e-8),
                SlipUp => assert!(near(along, m * push) && near(gap, 0.0) && push >= 0.0 && slip <= 1e-8),
                SlipDown => assert!(near(along, -m * push) && near(gap, 0.0) && push >= 0.0 && slip >= -1e-8),
                Closed => panic!("a tangent is never only closed"),
            }
        }
    }

    /// Random supports: every place obeys its law to rounding, and nearly all sets settle.
    #[test]
    fn a_settled_set_obeys_the_law() {
        let mut random = Random::new(17);
        let (mut lost, mut met) = (0, [0; 4]);
        for _ in 0..3000 {
            let (matrix, m, rows, rhs) = support(&mut random);
            let n = rows.len();
            let (settled, states, delta) = solved(matrix.as_slice(), &rhs, &rows, m);
            if !settled.settled {
                lost += 1;
                continue;
            }
            let forces: Vec<f64> = (0..n).map(|j| rows[j].multiplier + delta[j]).collect();
            let residuals: Vec<f64> =
                (0..n).map(|j| (0..n).map(|k| matrix[(j, k)] * delta[k]).sum::<f64>() - rhs[j]).collect();
            obey(&states, &forces, &residuals, m);
            for tangent in (0..n).step_by(2) {
                let kind = [Open, Stick, SlipUp, SlipDown].iter().position(|state| *state == states[tangent]);
                met[kind.expect("a tangent's state")] += 1;
            }
        }
        std::println!("{lost} of 3000 sets did not settle; {met:?}");
        assert!(lost <= 30, "{lost}");
        assert!(met.iter().all(|&met| met > 500), "{met:?}");
    }

    /// Where few sets are tried at a time, the next iterations end with a set that obeys the law.
    #[test]
    fn a_search_in_parts_ends_where_the_law_is_obeyed() {
        let mut random = Random::new(18);
        let (mut lost, mut parts) = (0, 0);
        for _ in 0..1000 {
            let (matrix, m, mut rows, mut rhs) = support(&mut random);
            let n = rows.len();
            let law = Law { coefficient: m, forced: Open, is_bounded: true };
            let ended = (0..20).find_map(|part| {
                let (settled, states, delta) = solved_by(matrix.as_slice(), &rhs, &rows, law);
                // As an iteration takes them: rows that do not push leave, and what slips is on its cone.
                let mut change = vec![0.0; n];
                for tangent in (0..n).step_by(2) {
                    let push = rows[tangent + 1].multiplier + delta[tangent + 1];
                    let touches = states[tangent + 1] == Closed && push > 0.0;
                    let along = rows[tangent].multiplier + delta[tangent];
                    let (state, along, push) = match states[tangent] {
                        _ if !touches => (Open, 0.0, 0.0),
                        SlipUp => (SlipUp, m * push, push),
                        SlipDown => (SlipDown, -m * push, push),
                        state => (state, along, push),
                    };
                    let new = place((state, along), push);
                    for (j, new) in (tangent..).zip(new) {
                        change[j] = new.multiplier - rows[j].multiplier;
                        rows[j] = new;
                    }
                }
                for j in 0..n {
                    rhs[j] -= (0..n).map(|k| matrix[(j, k)] * change[k]).sum::<f64>();
                }
                settled.settled.then_some((part, states))
            });
            let Some((part, states)) = ended else {
                lost += 1;
                continue;
            };
            parts += usize::from(part > 0);
            let forces: Vec<f64> = rows.iter().map(|row| row.multiplier).collect();
            let residuals: Vec<f64> = rhs.iter().map(|left| -left).collect();
            obey(&states, &forces, &residuals, m);
        }
        std::println!("{lost} of 1000 did not settle, {parts} in more than one part");
        assert!(lost <= 20 && parts > 100, "{lost} {parts}");
    }

    /// D's negative eigenvalues on normals and sticking tangents.
    #[test]
    fn slipping_tangents_do_not_count_for_the_inertia() {
        let flexibility = [-2.0, 0.1, 0.1, 1.0];
        let sticks = solved(&flexibility, &[0.0, 0.0], &place((Stick, 0.0), 2.0), 0.5).0;
        assert_eq!((sticks.settled, sticks.negative), (true, 1));
        // Slips down: D·n − m D·t.
        let slips = solved(&flexibility, &[-9.0, 0.0], &place((SlipUp, 1.0), 2.0), 0.5);
        assert_eq!((slips.0.negative, &slips.1[..]), (usize::from(slips.1[0] == Stick), &[slips.1[0], Closed][..]));
    }
}
