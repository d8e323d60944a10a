//! The active set on the dense border: μ ≥ 0, w = D Δμ − b ≥ 0, one of them zero for every row.
//!
//! D is symmetric and may be legitimately indefinite where contacts stabilise the structure, so it is factorised as
//! L B Lᵀ with 1×1 and 2×2 pivots and complete pivoting (Bunch & Parlett, SIAM J. Numer. Anal. 8, 1971); the signs in B
//! are the inertia that the stability test needs.

use crate::access::Access;
use crate::contact::Row;
use crate::real::Real;

/// Bunch and Parlett's (1 + √17)/8: below this ratio of the largest diagonal to the largest entry a 2×2 pivot is taken.
const ALPHA: f64 = 0.640_388_203_202_208_4;
/// Marks the first of two rows of a 2×2 pivot in the pivot order.
const PAIR: u16 = 0x8000;

/// Entry in row i and column j. What lies outside of the matrix is zero.
#[inline(always)]
fn entry<T: Real>(a: &[T], stride: usize, i: usize, j: usize) -> T {
    a.at(i * stride + j)
}

/// Exchanges rows and columns i and j of a symmetric matrix in full storage.
fn exchange<T: Real>(a: &mut [T], n: usize, stride: usize, i: usize, j: usize) {
    let mut swap = |from: usize, to: usize| {
        let (x, y) = (a.at(from), a.at(to));
        a.put(from, y);
        a.put(to, x);
    };
    if i == j {
        return;
    }
    for k in 0..n {
        swap(i * stride + k, j * stride + k);
    }
    for k in 0..n {
        swap(k * stride + i, k * stride + j);
    }
}

/// Exchanges two places in the order of the pivots.
fn swap(order: &mut [u16], i: usize, j: usize) {
    let (x, y) = (order.at(i), order.at(j));
    order.put(i, y);
    order.put(j, x);
}

/// Goes on with the factorisation L D Lᵀ without interchanges of the lower triangle of the leading n×n block, the first `done`
/// rows being factorised already; false if a pivot falls so far below its diagonal entry that interchanges are called for.
///
/// Where D is positive definite but for the turning of the force, which is almost always, this is all it takes: a quarter of
/// the work of [`factorise`], and a row that comes last costs no more than its own.
fn factorise_in_order<T: Real>(a: &mut [T], done: usize, n: usize, stride: usize, order: &mut [u16]) -> bool {
    let least = T::EPSILON.sqrt();
    for (i, place) in order.iter_mut().enumerate().take(n).skip(done) {
        *place = i as u16;
        let Some((above, row)) = a.split_at_mut_checked(i * stride) else { return false };
        let Some(row) = row.get_mut(..=i) else { return false };
        let diagonal = row[i];
        // Row i of L times D, then of L: each entry less what the columns before it have taken.
        let mut pivot = diagonal;
        for j in 0..i {
            let Some(other) = above.get(j * stride..j * stride + j) else { return false };
            row[j] -= product(&row[..j], other);
        }
        for j in 0..i {
            let Some(&divisor) = above.get(j * stride + j) else { return false };
            let value = row[j];
            let l = value / divisor;
            pivot -= value * l;
            row[j] = l;
        }
        if pivot.abs() <= least * diagonal.abs() {
            return false;
        }
        row[i] = pivot;
    }
    true
}

/// Σ aᵢ bᵢ over the shorter of both, in two sums: one would wait for itself.
#[inline(always)]
pub(super) fn product<T: Real>(a: &[T], b: &[T]) -> T {
    let count = a.len().min(b.len());
    let ((a, a_left), (b, b_left)) = (a.run(0..count).as_chunks::<2>(), b.run(0..count).as_chunks::<2>());
    let mut sums = [T::ZERO; 2];
    for (a, b) in a.iter().zip(b) {
        sums = [sums[0] + a[0] * b[0], sums[1] + a[1] * b[1]];
    }
    match (a_left.first(), b_left.first()) {
        (Some(&a), Some(&b)) => sums[0] + a * b + sums[1],
        _ => sums[0] + sums[1],
    }
}

/// Factorises the leading n×n block in place; returns the number of negative eigenvalues.
///
/// A pivot that vanishes beside the largest entry met is replaced by a small positive one.
pub(crate) fn factorise<T: Real>(a: &mut [T], n: usize, stride: usize, order: &mut [u16]) -> usize {
    let mut negative = 0;
    let mut largest = T::ZERO;
    for i in 0..n {
        order.put(i, i as u16);
        for j in 0..n {
            largest = largest.max(entry(a, stride, i, j).abs());
        }
    }
    let least = (largest * T::EPSILON).max(T::of(1e-30));
    let mut k = 0;
    while k < n {
        let (mut r, mut diagonal) = (k, T::ZERO);
        let (mut p, mut q, mut off) = (k, k, T::ZERO);
        for i in k..n {
            let here = entry(a, stride, i, i).abs();
            if here > diagonal {
                (r, diagonal) = (i, here);
            }
            for j in k..i {
                let here = entry(a, stride, i, j).abs();
                if here > off {
                    (p, q, off) = (i, j, here);
                }
            }
        }
        if diagonal >= T::of(ALPHA) * off {
            exchange(a, n, stride, k, r);
            swap(order, k, r);
            let mut pivot = entry(a, stride, k, k);
            if pivot.abs() < least {
                pivot = least;
            }
            negative += usize::from(pivot < T::ZERO);
            a.put(k * stride + k, pivot);
            let inverse = T::one() / pivot;
            for i in k + 1..n {
                let l = entry(a, stride, i, k) * inverse;
                for j in k + 1..=i {
                    // The upper triangle still holds the undivided column.
                    let v = entry(a, stride, i, j) - l * entry(a, stride, k, j);
                    a.put(i * stride + j, v);
                    a.put(j * stride + i, v);
                }
                a.put(i * stride + k, l);
            }
            k += 1;
        } else {
            exchange(a, n, stride, k, q);
            swap(order, k, q);
            // The exchange may have moved row p.
            let p = if p == k { q } else { p };
            exchange(a, n, stride, k + 1, p);
            swap(order, k + 1, p);
            let (d, e, f) = pair(a, stride, k);
            // |e| is the largest entry and both diagonals are smaller than ALPHA |e|: the determinant is negative.
            let inverse = T::one() / (d * f - e * e);
            negative += 1;
            for i in k + 2..n {
                let (u, v) = (entry(a, stride, i, k), entry(a, stride, i, k + 1));
                let (l, m) = ((u * f - v * e) * inverse, (v * d - u * e) * inverse);
                for j in k + 2..=i {
                    let w = entry(a, stride, i, j) - l * entry(a, stride, k, j) - m * entry(a, stride, k + 1, j);
                    a.put(i * stride + j, w);
                    a.put(j * stride + i, w);
                }
                a.put(i * stride + k, l);
                a.put(i * stride + k + 1, m);
            }
            order.put(k, order.at(k) | PAIR);
            k += 2;
        }
    }
    negative
}

/// Diagonal, off-diagonal and second diagonal entry of the 2×2 block at k.
fn pair<T: Real>(a: &[T], stride: usize, k: usize) -> (T, T, T) {
    (entry(a, stride, k, k), entry(a, stride, k + 1, k), entry(a, stride, k + 1, k + 1))
}

/// Factorises the leading n×n block of `from` into `a`: in the order of the rows that `place` gives if that does without
/// interchanges.
pub(crate) fn factorise_from<T: Real>(
    from: &[T],
    a: &mut [T],
    n: usize,
    stride: usize,
    order: &mut [u16],
    place: impl Fn(usize) -> usize,
) {
    for i in 0..n {
        for j in 0..=i {
            a.put(i * stride + j, entry(from, stride, place(i), place(j)));
        }
    }
    if factorise_in_order(a, 0, n, stride, order) {
        for (i, order) in order.iter_mut().enumerate().take(n) {
            *order = place(i) as u16;
        }
        return;
    }
    for (into, &from) in a.iter_mut().zip(from).take(n * stride) {
        *into = from;
    }
    factorise(a, n, stride, order);
}

/// Solves with the factors; `x` is in and out, `y` is scratch.
pub(crate) fn solve<T: Real>(a: &[T], n: usize, stride: usize, order: &[u16], x: &mut [T], y: &mut [T]) {
    let (Some(y), Some(order)) = (y.get_mut(..n), order.get(..n)) else { return };
    for (y, &place) in y.iter_mut().zip(order) {
        *y = x.at(usize::from(place & !PAIR));
    }
    // Row by row: what the rows above it, but for the other of its own pair, have taken.
    let mut second = false;
    for i in 0..n {
        let (above, rest) = y.split_at_mut(i);
        let (Some(row), Some(value)) = (a.get(i * stride..), rest.first_mut()) else { return };
        let above = above.get(..i - usize::from(second)).unwrap_or(&[]);
        for (&l, &x) in row.iter().zip(above) {
            *value -= l * x;
        }
        second = !second && order.at(i) & PAIR != 0;
    }
    let mut k = 0;
    while k < n {
        if order.at(k) & PAIR != 0 {
            let (d, e, f) = pair(a, stride, k);
            let inverse = T::one() / (d * f - e * e);
            let (u, v) = (y.at(k), y.at(k + 1));
            y.put(k, (u * f - v * e) * inverse);
            y.put(k + 1, (v * d - u * e) * inverse);
            k += 2;
        } else {
            y.put(k, y.at(k) / entry(a, stride, k, k));
            k += 1;
        }
    }
    for k in (0..n).rev() {
        // Within a pair there is no multiplier: L's block is the identity.
        let second = k > 0 && order.at(k - 1) & PAIR != 0;
        let first = if second { k + 1 } else { k + 1 + usize::from(order.at(k) & PAIR != 0) };
        let mut value = y.at(k);
        let column = a.get(first * stride + k..).unwrap_or(&[]).iter().step_by(stride.max(1));
        for (&l, &y) in column.zip(y.get(first..).unwrap_or(&[])) {
            value -= l * y;
        }
        y.put(k, value);
    }
    for (&y, &place) in y.iter().zip(order) {
        x.put(usize::from(place & !PAIR), y);
    }
}

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
