//! The active set on the dense border: μ ≥ 0, w = D Δμ − b ≥ 0, one of them zero for every row.
//!
//! D is symmetric and may be legitimately indefinite where contacts stabilise the structure, so it is factorised as
//! L B Lᵀ with 1×1 and 2×2 pivots and complete pivoting (Bunch & Parlett, SIAM J. Numer. Anal. 8, 1971); the signs in B
//! are the inertia that the stability test needs.

use crate::real::Real;

/// Bunch and Parlett's (1 + √17)/8: below this ratio of the largest diagonal to the largest entry a 2×2 pivot is taken.
const ALPHA: f64 = 0.640_388_203_202_208_4;
/// Marks the first of two rows of a 2×2 pivot in the pivot order.
const PAIR: u16 = 0x8000;

/// Exchanges rows and columns i and j of a symmetric matrix in full storage.
fn exchange<T: Real>(a: &mut [T], n: usize, stride: usize, i: usize, j: usize) {
    if i == j {
        return;
    }
    for k in 0..n {
        a.swap(i * stride + k, j * stride + k);
    }
    for k in 0..n {
        a.swap(k * stride + i, k * stride + j);
    }
}

/// Factorises the lower triangle of the leading n×n block as L D Lᵀ without interchanges; the number of negative eigenvalues, or
/// none if a pivot falls so far below its diagonal entry that interchanges are called for.
///
/// Where D is positive definite but for the turning of the force, which is almost always, this is all it takes: a quarter of
/// the work of [`factorise`].
fn factorise_in_order<T: Real>(a: &mut [T], n: usize, stride: usize, order: &mut [u16]) -> Option<usize> {
    let mut negative = 0;
    let least = T::EPSILON.sqrt();
    for (i, place) in order.iter_mut().enumerate().take(n) {
        *place = i as u16;
        let (above, row) = a.split_at_mut_checked(i * stride)?;
        let row = row.get_mut(..=i)?;
        let diagonal = row[i];
        // Row i of L times D, then of L: each entry less what the columns before it have taken.
        let mut pivot = diagonal;
        for j in 0..i {
            let other = above.get(j * stride..=j * stride + j)?;
            let mut value = row[j];
            for (&x, &l) in row[..j].iter().zip(other) {
                value -= x * l;
            }
            row[j] = value;
        }
        for j in 0..i {
            let value = row[j];
            let l = value / *above.get(j * stride + j)?;
            pivot -= value * l;
            row[j] = l;
        }
        if pivot.abs() <= least * diagonal.abs() {
            return None;
        }
        negative += usize::from(pivot < T::ZERO);
        row[i] = pivot;
    }
    Some(negative)
}

/// Factorises the leading n×n block in place; returns the number of negative eigenvalues.
///
/// A pivot that vanishes beside the largest entry met is replaced by a small positive one.
pub(crate) fn factorise<T: Real>(a: &mut [T], n: usize, stride: usize, order: &mut [u16]) -> usize {
    let mut negative = 0;
    let mut largest = T::ZERO;
    for i in 0..n {
        order[i] = i as u16;
        for j in 0..n {
            largest = largest.max(a[i * stride + j].abs());
        }
    }
    let least = (largest * T::EPSILON).max(T::of(1e-30));
    let mut k = 0;
    while k < n {
        let (mut r, mut diagonal) = (k, T::ZERO);
        let (mut p, mut q, mut off) = (k, k, T::ZERO);
        for i in k..n {
            if a[i * stride + i].abs() > diagonal {
                (r, diagonal) = (i, a[i * stride + i].abs());
            }
            for j in k..i {
                if a[i * stride + j].abs() > off {
                    (p, q, off) = (i, j, a[i * stride + j].abs());
                }
            }
        }
        if diagonal >= T::of(ALPHA) * off {
            exchange(a, n, stride, k, r);
            order.swap(k, r);
            let mut pivot = a[k * stride + k];
            if pivot.abs() < least {
                pivot = least;
            }
            negative += usize::from(pivot < T::ZERO);
            a[k * stride + k] = pivot;
            let inverse = T::one() / pivot;
            for i in k + 1..n {
                let l = a[i * stride + k] * inverse;
                for j in k + 1..=i {
                    // The upper triangle still holds the undivided column.
                    let v = a[i * stride + j] - l * a[k * stride + j];
                    a[i * stride + j] = v;
                    a[j * stride + i] = v;
                }
                a[i * stride + k] = l;
            }
            k += 1;
        } else {
            exchange(a, n, stride, k, q);
            order.swap(k, q);
            // The exchange may have moved row p.
            let p = if p == k { q } else { p };
            exchange(a, n, stride, k + 1, p);
            order.swap(k + 1, p);
            let (d, e, f) = (a[k * stride + k], a[(k + 1) * stride + k], a[(k + 1) * stride + k + 1]);
            // |e| is the largest entry and both diagonals are smaller than ALPHA |e|: the determinant is negative.
            let inverse = T::one() / (d * f - e * e);
            negative += 1;
            for i in k + 2..n {
                let (u, v) = (a[i * stride + k], a[i * stride + k + 1]);
                let (l, m) = ((u * f - v * e) * inverse, (v * d - u * e) * inverse);
                for j in k + 2..=i {
                    let w = a[i * stride + j] - l * a[k * stride + j] - m * a[(k + 1) * stride + j];
                    a[i * stride + j] = w;
                    a[j * stride + i] = w;
                }
                a[i * stride + k] = l;
                a[i * stride + k + 1] = m;
            }
            order[k] |= PAIR;
            k += 2;
        }
    }
    negative
}

/// Solves with the factors; `x` is in and out, `y` is scratch.
pub(crate) fn solve<T: Real>(a: &[T], n: usize, stride: usize, order: &[u16], x: &mut [T], y: &mut [T]) {
    for i in 0..n {
        y[i] = x[usize::from(order[i] & !PAIR)];
    }
    let mut k = 0;
    while k < n {
        let pair = order[k] & PAIR != 0;
        let width = if pair { 2 } else { 1 };
        for i in k + width..n {
            for c in k..k + width {
                let l = a[i * stride + c];
                y[i] -= l * y[c];
            }
        }
        k += width;
    }
    let mut k = 0;
    while k < n {
        if order[k] & PAIR != 0 {
            let (d, e, f) = (a[k * stride + k], a[(k + 1) * stride + k], a[(k + 1) * stride + k + 1]);
            let inverse = T::one() / (d * f - e * e);
            let (u, v) = (y[k], y[k + 1]);
            y[k] = (u * f - v * e) * inverse;
            y[k + 1] = (v * d - u * e) * inverse;
            k += 2;
        } else {
            y[k] /= a[k * stride + k];
            k += 1;
        }
    }
    for k in (0..n).rev() {
        // Within a pair there is no multiplier: L's block is the identity.
        let first = if k > 0 && order[k - 1] & PAIR != 0 { k + 1 } else { k + 1 + usize::from(order[k] & PAIR != 0) };
        for i in first..n {
            let l = a[i * stride + k];
            y[k] -= l * y[i];
        }
    }
    for i in 0..n {
        x[usize::from(order[i] & !PAIR)] = y[i];
    }
}

/// The border's linear complementarity problem and the room to solve it.
pub(crate) struct Problem<'a, T> {
    /// D, `stride` entries per row.
    pub flexibility: &'a [T],
    pub stride: usize,
    /// Right-hand side b.
    pub rhs: &'a [T],
    /// Present multipliers μ, N.
    pub multiplier: &'a dyn Fn(usize) -> T,
    /// A row that is an equation: always in the set, its multiplier of either sign.
    pub free: Option<usize>,
    /// Gap below which a row that does not touch is taken in, mm.
    pub tolerance: T,
    pub factored: &'a mut [T],
    pub order: &'a mut [u16],
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
    let mut outcome = Settled { settled: false, negative: 0 };
    for j in 0..count {
        delta[j] = if active[j] { T::ZERO } else { -(problem.multiplier)(j) };
    }
    let mut newest = None;
    let mut refused = false;
    for _ in 0..4 * count + 8 {
        outcome.negative = solve_on(problem, count, active, delta);
        // How far towards it the multipliers stay non-negative.
        let mut part = T::one();
        let mut i = 0;
        for j in 0..count {
            if active[j] {
                let (now, then) = ((problem.multiplier)(j) + delta[j], (problem.multiplier)(j) + problem.scratch[i]);
                if then < T::ZERO && problem.free != Some(j) {
                    part = part.min(if now > T::ZERO { now / (now - then) } else { T::ZERO });
                }
                i += 1;
            }
        }
        let mut dropped = false;
        let mut i = 0;
        for j in 0..count {
            if active[j] {
                let multiplier = (problem.multiplier)(j);
                let target = problem.scratch[i];
                i += 1;
                let now = multiplier + delta[j];
                delta[j] = if part == T::one() { target } else { delta[j] + part * (target - delta[j]) };
                let limits = part < T::one()
                    && problem.free != Some(j)
                    && multiplier + target < T::ZERO
                    && multiplier + delta[j] <= now.abs() * T::of(4.0) * T::EPSILON;
                if limits {
                    delta[j] = -multiplier;
                    active[j] = false;
                    dropped = true;
                    refused |= newest == Some(j) && part == T::ZERO;
                }
            }
        }
        if dropped && !refused {
            continue;
        }
        if refused {
            // The row that just came in would have to pull: leave the set as it was before.
            outcome.negative = solve_on(problem, count, active, delta);
            let mut i = 0;
            for j in 0..count {
                if active[j] {
                    delta[j] = problem.scratch[i];
                    i += 1;
                }
            }
            return outcome;
        }
        // Take in the most violated gap.
        let mut worst: Option<(usize, T)> = None;
        for j in (0..count).filter(|&j| !active[j]) {
            let row = &problem.flexibility[j * stride..j * stride + count];
            let mut gap = -problem.rhs[j];
            for m in 0..count {
                gap += row[m] * delta[m];
            }
            if gap < -problem.tolerance && worst.is_none_or(|(_, least)| gap < least) {
                worst = Some((j, gap));
            }
        }
        let Some((j, _)) = worst else {
            outcome.settled = true;
            return outcome;
        };
        active[j] = true;
        newest = Some(j);
    }
    outcome
}

/// Solves for the steps of the active rows (in order, into `scratch`), the others keeping theirs; returns the number of
/// negative eigenvalues of D on the active set.
fn solve_on<T: Real>(problem: &mut Problem<'_, T>, count: usize, active: &[bool], delta: &[T]) -> usize {
    let stride = problem.stride;
    let listed = list(problem, count, active, delta);
    let negative = match factorise_in_order(problem.factored, listed, stride, problem.order) {
        Some(negative) => negative,
        None => {
            list(problem, count, active, delta);
            factorise(problem.factored, listed, stride, problem.order)
        }
    };
    solve(problem.factored, listed, stride, problem.order, problem.scratch, problem.spare);
    negative
}

/// Copies D of the active rows into `factored` and their right-hand sides into `scratch`; the number of active rows.
fn list<T: Real>(problem: &mut Problem<'_, T>, count: usize, active: &[bool], delta: &[T]) -> usize {
    let stride = problem.stride;
    let mut listed = 0;
    for j in (0..count).filter(|&j| active[j]) {
        let row = &problem.flexibility[j * stride..j * stride + count];
        let mut value = problem.rhs[j];
        let mut k = 0;
        for m in 0..count {
            if active[m] {
                problem.factored[listed * stride + k] = row[m];
                k += 1;
            } else if delta[m] != T::ZERO {
                value -= row[m] * delta[m];
            }
        }
        problem.scratch[listed] = value;
        listed += 1;
    }
    listed
}
