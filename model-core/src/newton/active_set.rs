//! The active set on the dense border: μ ≥ 0, w = D Δμ − b ≥ 0, one of them zero for every row.
//!
//! D is symmetric and may be legitimately indefinite where contacts stabilise the structure ([`crate::linear::symmetric`]); its negative
//! eigenvalues on the active set are what the stability test needs.

use crate::access::Access;
use crate::contact::Row;
use crate::linear::symmetric::{entry, factorise, factorise_in_order, product, solve};
use crate::real::Real;

/// The border's linear complementarity problem and the room to solve it.
pub(crate) struct Problem<'a, T> {
    /// D, `stride` entries per row.
    pub flexibility: &'a [T],
    pub stride: usize,
    /// Right-hand side b.
    pub rhs: &'a [T],
    /// The rows, with their present multipliers μ, N.
    pub rows: &'a [Row<T>],
    /// A row that is an equation: always in the set, its multiplier of either sign.
    pub free: Option<usize>,
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
    /// Negative eigenvalues of D on the active set.
    pub negative: usize,
    /// How many of the listed rows have their factors, for the next problem with the same D.
    pub factorised: usize,
}

/// Finds the active rows (in and out, warm-started) and the steps Δμ of all rows.
///
/// A primal active-set method: from feasible multipliers, go towards the solution on the present set, but only as far as
/// no multiplier turns negative; rows that reach zero leave, then the most violated gap comes in. On a positive definite
/// D every pass lowers ½ μᵀDμ − cᵀμ, so no set returns; on an indefinite one the passes are bounded and rows that would
/// have to pull at once are left out.
pub(crate) fn settle<T: Real>(
    problem: &mut Problem<'_, T>,
    count: usize,
    active: &mut [bool],
    delta: &mut [T],
) -> Settled {
    let stride = problem.stride;
    let mut outcome = Settled { settled: false, negative: 0, factorised: 0 };
    // All of one length.
    let (Some(rows), Some(active), Some(delta)) =
        (problem.rows.get(..count), active.get_mut(..count), delta.get_mut(..count))
    else {
        return outcome;
    };
    let mut set = Set { listed: 0, factorised: problem.factorised };
    for (j, ((delta, row), &active)) in delta.iter_mut().zip(rows).zip(&*active).enumerate() {
        *delta = if active { T::ZERO } else { -row.multiplier };
        if active {
            set.take_in(problem, j);
        }
    }
    set.factorised = set.factorised.min(set.listed);
    let mut newest = None;
    let mut refused = false;
    for _ in 0..4 * count + 8 {
        outcome.negative = solve_on(problem, &mut set, active, delta);
        outcome.factorised = set.factorised;
        // How far towards it the multipliers stay non-negative.
        let mut part = T::one();
        for (&j, &target) in problem.listed.iter().zip(&*problem.scratch).take(set.listed) {
            let j = usize::from(j);
            let (Some(row), Some(&delta)) = (rows.get(j), delta.get(j)) else { continue };
            let (now, then) = (row.multiplier + delta, row.multiplier + target);
            if then < T::ZERO && problem.free != Some(j) {
                part = part.min(if now > T::ZERO { now / (now - then) } else { T::ZERO });
            }
        }
        let mut dropped = false;
        for (&j, &target) in problem.listed.iter().zip(&*problem.scratch).take(set.listed) {
            let j = usize::from(j);
            let (Some(row), Some(delta), Some(active)) = (rows.get(j), delta.get_mut(j), active.get_mut(j)) else {
                continue;
            };
            let multiplier = row.multiplier;
            let now = multiplier + *delta;
            *delta = if part == T::one() { target } else { *delta + part * (target - *delta) };
            let limits = part < T::one()
                && problem.free != Some(j)
                && multiplier + target < T::ZERO
                && multiplier + *delta <= now.abs() * T::of(4.0) * T::EPSILON;
            if limits {
                *delta = -multiplier;
                *active = false;
                dropped = true;
                refused |= newest == Some(j) && part == T::ZERO;
            }
        }
        if dropped {
            set.drop_idle(problem, active);
            outcome.factorised = set.factorised;
        }
        if dropped && !refused {
            continue;
        }
        if refused {
            // The row that just came in would have to pull: leave the set as it was before.
            outcome.negative = solve_on(problem, &mut set, active, delta);
            outcome.factorised = set.factorised;
            for (&j, &target) in problem.listed.iter().zip(&*problem.scratch).take(set.listed) {
                delta.put(usize::from(j), target);
            }
            return outcome;
        }
        // Take in the most violated gap.
        let mut worst: Option<(usize, T)> = None;
        let matrix = problem.flexibility.chunks(stride.max(1));
        for (j, ((row, &rhs), &active)) in matrix.zip(problem.rhs).zip(&*active).enumerate() {
            if active {
                continue;
            }
            let gap = product(row, delta) - rhs;
            if gap < -problem.tolerance && worst.is_none_or(|(_, least)| gap < least) {
                worst = Some((j, gap));
            }
        }
        let Some(found) = worst.and_then(|(j, _)| active.get_mut(j).map(|active| (j, active))) else {
            outcome.settled = true;
            return outcome;
        };
        *found.1 = true;
        newest = Some(found.0);
        set.take_in(problem, found.0);
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

    /// Leaves out the rows that are not active any more.
    fn drop_idle<T: Real>(&mut self, problem: &mut Problem<'_, T>, active: &[bool]) {
        let mut kept = 0;
        for i in 0..self.listed {
            let row = problem.listed.at(i);
            if active.at(usize::from(row)) {
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
fn solve_on<T: Real>(problem: &mut Problem<'_, T>, set: &mut Set, active: &[bool], delta: &[T]) -> usize {
    let stride = problem.stride;
    let listed = set.listed;
    list(problem, set.factorised, listed);
    right_hand_sides(problem, listed, active, delta);
    let negative = if factorise_in_order(problem.factored, set.factorised, listed, stride, problem.order) {
        set.factorised = listed;
        (0..listed).filter(|&i| entry(problem.factored, stride, i, i) < T::ZERO).count()
    } else {
        set.factorised = 0;
        list(problem, 0, listed);
        factorise(problem.factored, listed, stride, problem.order)
    };
    solve(problem.factored, listed, stride, problem.order, problem.scratch, problem.spare);
    negative
}

/// Copies D of the active rows from the `first` listed one on into `factored`.
fn list<T: Real>(problem: &mut Problem<'_, T>, first: usize, listed: usize) {
    let stride = problem.stride.max(1);
    let places = problem.listed.get(..listed).unwrap_or(&[]);
    let rows = places.iter().zip(problem.factored.chunks_mut(stride)).skip(first);
    for (&j, into) in rows {
        let Some(row) = problem.flexibility.get(usize::from(j) * stride..).and_then(|rows| rows.get(..stride)) else {
            return;
        };
        for (slot, &k) in into.iter_mut().zip(places) {
            *slot = row.at(usize::from(k));
        }
    }
}

/// Right-hand sides of the active rows, the others keeping their steps.
fn right_hand_sides<T: Real>(problem: &mut Problem<'_, T>, listed: usize, active: &[bool], delta: &[T]) {
    let places = problem.listed.get(..listed).unwrap_or(&[]);
    for (value, &j) in problem.scratch.iter_mut().zip(places) {
        *value = problem.rhs.at(usize::from(j));
    }
    for (k, (&active, &delta)) in active.iter().zip(delta).enumerate() {
        if !active && delta != T::ZERO {
            // D is symmetric: its row is its column.
            let row = problem.flexibility.get(k * problem.stride..).unwrap_or(&[]);
            for (value, &j) in problem.scratch.iter_mut().zip(places) {
                *value -= row.at(usize::from(j)) * delta;
            }
        }
    }
}
