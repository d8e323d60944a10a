//! Frictionless contact on the dense border: μ ≥ 0, w = D Δμ − b ≥ 0, one of them zero for every row (32), by an active set.
//!
//! D is symmetric and may be legitimately indefinite where contacts stabilise the structure ([`crate::linear::symmetric`]); its negative
//! eigenvalues on the active set are what the stability test needs.

use super::{ContactState, Row};
use crate::access::Access;
use crate::linear::symmetric::{entry, factorise, factorise_in_order, product, solve};
use crate::real::Real;

/// The border's linear complementarity problem and the room to solve it.
pub(crate) struct Problem<'a, T> {
    /// D, `stride` entries per row.
    pub flexibility: &'a [T],
    pub stride: usize,
    /// Right-hand side b.
    pub rhs: &'a [T],
    /// The rows, with their present states and multipliers μ, N.
    pub rows: &'a [Row<T>],
    /// Gap below which a row that does not touch is taken in, mm.
    pub tolerance: T,
    pub factored: &'a mut [T],
    pub order: &'a mut [u16],
    /// The active rows in the order in which they are factorised.
    pub listed: &'a mut [u16],
    /// How many of them have their factors in `factored`, and their places in `order`, already: from an earlier problem with the same D.
    pub factorised: usize,
    /// Solution on the active set.
    pub scratch: &'a mut [T],
    pub spare: &'a mut [T],
}

/// How the active set came out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Settled {
    /// False if the set still changed when the passes ran out.
    pub settled: bool,
    /// Negative eigenvalues of D on the active set, if it settled.
    pub negative: usize,
    /// How many of the listed rows have their factors, for the next problem with the same D.
    pub factorised: usize,
}

/// Finds the rows' new states, from the present ones on, and the steps Δμ of all rows. A row that may pull is closed for good.
///
/// A primal active-set method: from feasible multipliers, go towards the solution on the present set, but only as far as
/// no multiplier turns negative; rows that reach zero leave, then violated gaps come in: all of them as long as none of these has to
/// leave again at once, then the most violated one. On a positive definite D every pass that moves lowers ½ μᵀDμ − cᵀμ, so no set
/// returns; on an indefinite one the passes are bounded and a row that would have to pull at once is left out.
pub(crate) fn settle<T: Real>(
    problem: &mut Problem<'_, T>,
    count: usize,
    states: &mut [ContactState],
    delta: &mut [T],
) -> Settled {
    let stride = problem.stride;
    let mut outcome = Settled { settled: false, negative: 0, factorised: 0 };
    // All of one length.
    let (Some(rows), Some(states), Some(delta)) =
        (problem.rows.get(..count), states.get_mut(..count), delta.get_mut(..count))
    else {
        return outcome;
    };
    let mut set = Set { listed: 0, factorised: problem.factorised };
    for (j, ((delta, row), state)) in delta.iter_mut().zip(rows).zip(&mut *states).enumerate() {
        *state = row.state;
        *delta = if row.state == ContactState::Closed { T::ZERO } else { -row.multiplier };
        if *state == ContactState::Closed {
            set.take_in(problem, j);
        }
    }
    set.factorised = set.factorised.min(set.listed);
    // Violated gaps come in together until one of them would have to pull; from then on one by one, so that no set returns.
    let (mut newest, mut together) = (None, true);
    let mut refused = false;
    for _ in 0..4 * count + 8 {
        outcome.negative = solve_on(problem, &mut set, states, delta);
        outcome.factorised = set.factorised;
        // How far towards it the multipliers stay non-negative.
        let mut part = T::one();
        for (&j, &target) in problem.listed.iter().zip(&*problem.scratch).take(set.listed) {
            let j = usize::from(j);
            let (Some(row), Some(&delta)) = (rows.get(j), delta.get(j)) else { continue };
            let (now, then) = (row.multiplier + delta, row.multiplier + target);
            if then < T::ZERO && row.only_pushes() {
                part = part.min(if now > T::ZERO { now / (now - then) } else { T::ZERO });
            }
        }
        let mut dropped = false;
        for (&j, &target) in problem.listed.iter().zip(&*problem.scratch).take(set.listed) {
            let j = usize::from(j);
            let (Some(row), Some(delta), Some(state)) = (rows.get(j), delta.get_mut(j), states.get_mut(j)) else {
                continue;
            };
            let multiplier = row.multiplier;
            let now = multiplier + *delta;
            *delta = if part == T::one() { target } else { *delta + part * (target - *delta) };
            let limits = part < T::one()
                && row.only_pushes()
                && multiplier + target < T::ZERO
                && multiplier + *delta <= now.abs() * T::of(4.0) * T::EPSILON;
            if limits {
                *delta = -multiplier;
                *state = ContactState::Open;
                dropped = true;
                together &= part > T::ZERO;
                refused |= newest == Some(j) && part == T::ZERO;
            }
        }
        if dropped {
            set.drop_open(problem, states);
            outcome.factorised = set.factorised;
        }
        if dropped && !refused {
            continue;
        }
        if refused {
            // The row that just came in would have to pull: leave the set as it was before.
            outcome.negative = solve_on(problem, &mut set, states, delta);
            outcome.factorised = set.factorised;
            for (&j, &target) in problem.listed.iter().zip(&*problem.scratch).take(set.listed) {
                delta.put(usize::from(j), target);
            }
            return outcome;
        }
        let mut worst: Option<(usize, T)> = None;
        let (matrix, rhs, before) = (problem.flexibility.chunks(stride.max(1)), problem.rhs, set.listed);
        for (j, ((row, &rhs), state)) in matrix.zip(rhs).zip(&mut *states).enumerate() {
            if *state == ContactState::Closed {
                continue;
            }
            let gap = product(row, delta) - rhs;
            if gap < -problem.tolerance {
                if together {
                    *state = ContactState::Closed;
                    set.take_in(problem, j);
                }
                if worst.is_none_or(|(_, least)| gap < least) {
                    worst = Some((j, gap));
                }
            }
        }
        let Some((most, _)) = worst else {
            outcome.settled = true;
            return outcome;
        };
        if !together && let Some(state) = states.get_mut(most) {
            *state = ContactState::Closed;
            set.take_in(problem, most);
        }
        newest = (set.listed == before + 1).then_some(most);
    }
    outcome
}

/// How many rows are active, and how many of them are factorised already: a row that comes in is the last one, one that leaves takes
/// the factors of those after it along.
struct Set {
    listed: usize,
    factorised: usize,
}

impl Set {
    fn take_in<T: Real>(&mut self, problem: &mut Problem<'_, T>, row: usize) {
        if problem.listed.at(self.listed) != row as u16 {
            self.factorised = self.factorised.min(self.listed);
            problem.listed.put(self.listed, row as u16);
        }
        self.listed += 1;
    }

    /// Leaves out the rows that are closed no more.
    fn drop_open<T: Real>(&mut self, problem: &mut Problem<'_, T>, states: &[ContactState]) {
        let mut kept = 0;
        for i in 0..self.listed {
            let row = problem.listed.at(i);
            if states.at(usize::from(row)) == ContactState::Closed {
                problem.listed.put(kept, row);
                kept += 1;
            } else {
                self.factorised = self.factorised.min(kept);
            }
        }
        self.listed = kept;
    }
}

/// Solves for the steps of the active rows (in their order, into `scratch`), the others keeping theirs; returns the number of
/// negative eigenvalues of D on the active set.
fn solve_on<T: Real>(problem: &mut Problem<'_, T>, set: &mut Set, states: &[ContactState], delta: &[T]) -> usize {
    let stride = problem.stride;
    let listed = set.listed;
    list(problem, set.factorised, listed, true);
    right_hand_sides(problem, listed, states, delta);
    let negative = if factorise_in_order(problem.factored, set.factorised, listed, stride, problem.order) {
        set.factorised = listed;
        (0..listed).filter(|&i| entry(problem.factored, stride, i, i) < T::ZERO).count()
    } else {
        set.factorised = 0;
        list(problem, 0, listed, false);
        factorise(problem.factored, listed, stride, problem.order)
    };
    solve(problem.factored, listed, stride, problem.order, problem.scratch, problem.spare);
    negative
}

/// Copies D of the active rows from the `first` listed one on into `factored`: all of it, or the lower triangle.
fn list<T: Real>(problem: &mut Problem<'_, T>, first: usize, listed: usize, lower: bool) {
    let stride = problem.stride.max(1);
    let places = problem.listed.get(..listed).unwrap_or(&[]);
    let rows = places.iter().zip(problem.factored.chunks_mut(stride)).enumerate().skip(first);
    for (i, (&j, into)) in rows {
        let width = if lower { i + 1 } else { listed };
        let Some(row) = problem.flexibility.get(usize::from(j) * stride..).and_then(|rows| rows.get(..stride)) else {
            return;
        };
        for (slot, &k) in into.iter_mut().zip(places).take(width) {
            *slot = row.at(usize::from(k));
        }
    }
}

/// Right-hand sides of the active rows, the others keeping their steps.
fn right_hand_sides<T: Real>(problem: &mut Problem<'_, T>, listed: usize, states: &[ContactState], delta: &[T]) {
    let places = problem.listed.get(..listed).unwrap_or(&[]);
    for (value, &j) in problem.scratch.iter_mut().zip(places) {
        *value = problem.rhs.at(usize::from(j));
    }
    for (k, (&state, &delta)) in states.iter().zip(delta).enumerate() {
        if state == ContactState::Open && delta != T::ZERO {
            // D is symmetric: its row is its column.
            let row = problem.flexibility.get(k * problem.stride..).unwrap_or(&[]);
            for (value, &j) in problem.scratch.iter_mut().zip(places) {
                *value -= row.at(usize::from(j)) * delta;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::Direction;
    use crate::random_designs::Random;
    use crate::size::Blank;
    use nalgebra::DMatrix;
    use std::vec::Vec;

    /// A row that is closed where its multiplier is not zero.
    fn row(multiplier: f64) -> Row<f64> {
        let state = if multiplier > 0.0 { ContactState::Closed } else { ContactState::Open };
        Row { state, multiplier, ..Row::BLANK }
    }

    fn solved(flexibility: &[f64], rhs: &[f64], rows: &[Row<f64>]) -> (Settled, Vec<ContactState>, Vec<f64>) {
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
        let settled = settle(&mut problem, n, &mut states, &mut delta);
        (settled, states, delta)
    }

    /// A gap that is violated closes, one that would have to pull opens, and a row without bounds pulls.
    #[test]
    fn states_follow_from_gaps_and_multipliers() {
        let diagonal = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        let pulls = Row { direction: Direction::Turning, state: ContactState::Closed, ..Row::BLANK };
        let rows = [row(0.0), row(2.0), pulls];
        let (settled, states, delta) = solved(&diagonal, &[3.0, -5.0, -4.0], &rows);
        assert!(settled.settled && settled.negative == 0);
        assert_eq!(states, [ContactState::Closed, ContactState::Open, ContactState::Closed]);
        assert_eq!(delta, [3.0, -2.0, -4.0]);
    }

    /// The steps solve the complementarity problem: multipliers and gaps are not negative, and one of them is zero.
    #[test]
    fn a_settled_set_is_complementary() {
        let mut random = Random::new(14);
        let mut changed = 0;
        for _ in 0..300 {
            let n = 3 + (4.0 * (1.0 + random.signed())) as usize;
            let root = DMatrix::from_fn(n, n, |_, _| random.signed());
            let matrix = &root * root.transpose() + DMatrix::identity(n, n) * 0.1;
            let rows: Vec<Row<f64>> = (0..n).map(|_| row(random.signed().max(0.0))).collect();
            let rhs: Vec<f64> = (0..n).map(|_| random.signed()).collect();
            let (settled, states, delta) = solved(matrix.as_slice(), &rhs, &rows);
            assert!(settled.settled);
            for (j, row) in rows.iter().enumerate() {
                let multiplier = row.multiplier + delta[j];
                let gap: f64 = (0..n).map(|k| matrix[(j, k)] * delta[k]).sum::<f64>() - rhs[j];
                match states[j] {
                    ContactState::Closed => assert!(multiplier > -1e-9 && gap.abs() < 1e-8, "{multiplier} {gap}"),
                    _ => assert!(multiplier.abs() < 1e-12 && gap > -2e-9, "{multiplier} {gap}"),
                }
                changed += usize::from(states[j] != row.state);
            }
        }
        assert!(changed > 300, "{changed}");
    }

    /// Factors that an earlier settling with the same D has left change nothing but the work.
    #[test]
    fn kept_factors_settle_the_active_set_as_new_ones_do() {
        const STRIDE: usize = 12;
        let mut random = Random::new(13);
        let mut spared = 0;
        for _ in 0..300 {
            let n = 4 + (4.0 * (1.0 + random.signed())) as usize;
            let root = DMatrix::from_fn(n, n, |_, _| random.signed());
            let matrix = &root * root.transpose() + DMatrix::identity(n, n) * 0.1;
            let mut flexibility = [0.0; STRIDE * STRIDE];
            for i in 0..n {
                for j in 0..n {
                    flexibility[i * STRIDE + j] = matrix[(i, j)];
                }
            }
            let multipliers: Vec<f64> = (0..n).map(|_| random.signed().max(0.0)).collect();
            let rows: Vec<Row<f64>> = multipliers.iter().map(|&multiplier| row(multiplier)).collect();
            let (mut factored, mut listed, mut order) = ([0.0; STRIDE * STRIDE], [0; STRIDE], [0; STRIDE]);
            let mut factorised = 0;
            for round in 0..3 {
                let rhs: Vec<f64> = (0..n).map(|_| 0.1 * random.signed()).collect();
                let mut solve = |kept: bool| {
                    let (mut fresh, mut fresh_list, mut fresh_order) =
                        ([0.0; STRIDE * STRIDE], [0; STRIDE], [0; STRIDE]);
                    let (mut states, mut delta) = ([ContactState::Open; STRIDE], [0.0; STRIDE]);
                    let mut problem = Problem {
                        flexibility: &flexibility,
                        stride: STRIDE,
                        rhs: &rhs,
                        rows: &rows,
                        tolerance: 1e-9,
                        factored: if kept { &mut factored } else { &mut fresh },
                        order: if kept { &mut order } else { &mut fresh_order },
                        listed: if kept { &mut listed } else { &mut fresh_list },
                        factorised: if kept { factorised } else { 0 },
                        scratch: &mut [0.0; STRIDE],
                        spare: &mut [0.0; STRIDE],
                    };
                    let settled = settle(&mut problem, n, &mut states, &mut delta);
                    (settled, states, delta)
                };
                let (new, new_states, new_delta) = solve(false);
                let (old, old_states, old_delta) = solve(true);
                assert!(new.settled && old.settled && new.negative == old.negative && new_states == old_states);
                for (a, b) in new_delta.iter().zip(&old_delta) {
                    assert!((a - b).abs() < 1e-11, "{a} against {b}");
                }
                spared += usize::from(round > 0 && factorised > 0);
                factorised = old.factorised;
            }
        }
        assert!(spared > 100, "{spared}");
    }
}
