//! How the forces left over answer the object's motion: −dF/dC with friction, in N, mm, and the turn times the object's size.
//!
//! With friction it is not symmetric, and differs with the way: a place that slips is soft, one that sticks stiff.

use super::{magnitude3, newton};

/// By how much each force falls (rows) with each part of the object's step (columns), N/mm.
pub(super) type Slope = [[f64; 3]; 3];

/// What is moved returns. With friction the slope is not symmetric: all its eigenvalues have positive real parts (Routh and Hurwitz).
pub(super) fn returns(slope: &Slope) -> bool {
    let [a, b, c] = slope;
    let trace = a[0] + b[1] + c[2];
    let minors = a[0] * b[1] - a[1] * b[0] + a[0] * c[2] - a[2] * c[0] + b[1] * c[2] - b[2] * c[1];
    let whole = determinant(slope);
    // A hair less, so that a direction in which nothing changes is not a matter of rounding.
    let hair = 1e-3 * (a[0] * b[1] * c[2]).abs();
    trace > 0.0 && whole >= -hair && trace * minors >= whole - hair
}

#[inline(never)]
pub(super) fn plus(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| a[i] + b[i])
}

#[inline(never)]
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// A step of at most a length.
#[inline(never)]
pub(super) fn within(step: [f64; 3], most: f64) -> [f64; 3] {
    let length = magnitude3(&step);
    if length > most { step.map(|part| part * most / length) } else { step }
}

#[inline(never)]
pub(super) fn minus(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| a[i] - b[i])
}

/// Takes into derivatives (rows: what changes; columns: the step's parts) what a step has changed (Broyden's update).
pub(super) fn learn<const N: usize>(derivatives: &mut [[f64; N]; 3], step: &[f64; N], change: &[f64; 3]) {
    let square = dot(step, step);
    if square > 0.0 {
        for (row, change) in derivatives.iter_mut().zip(change) {
            let missing = (change - dot(row, step)) / square;
            add(row, missing, step);
        }
    }
}

#[inline(never)]
fn add(row: &mut [f64], part: f64, step: &[f64]) {
    for (value, step) in row.iter_mut().zip(step) {
        *value += part * step;
    }
}

#[inline(never)]
fn determinant([a, b, c]: &Slope) -> f64 {
    a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])
}

/// The step that a slope answers with these forces; where it has none, or hardly any, that of a stiffer one.
#[inline(never)]
pub(super) fn solve(slope: &Slope, left: &[f64; 3]) -> [f64; 3] {
    let size = slope.iter().flatten().fold(0.0, |most: f64, part| most.max(part.abs()));
    let whole = determinant(slope);
    let is_regular = whole > 1e-6 * size * size * size;
    if !is_regular {
        let symmetric = core::array::from_fn(|i| core::array::from_fn(|j| 0.5 * (slope[i][j] + slope[j][i])));
        return newton(&symmetric, left, 3);
    }
    // Cramer's rule.
    [0, 1, 2].map(|j| {
        let mut with = *slope;
        for (row, &left) in with.iter_mut().zip(left) {
            row[j] = left;
        }
        determinant(&with) / whole
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Not symmetric, as a contact that slips makes it.
    const SLOPE: Slope = [[4.0, 1.0, 0.5], [-2.0, 3.0, 0.2], [0.1, -0.3, 2.0]];

    fn times(slope: &Slope, step: &[f64; 3]) -> [f64; 3] {
        slope.map(|row| dot(&row, step))
    }

    #[test]
    fn a_step_is_the_one_that_the_slope_answers_with_the_forces() {
        let left = [1.0, -2.0, 0.5];
        let found = times(&SLOPE, &solve(&SLOPE, &left));
        assert!(found.iter().zip(&left).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
        // Where nothing answers, the step is bounded all the same.
        let flat = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0; 3]];
        assert!(solve(&flat, &left).iter().all(|part| part.is_finite()));
        assert!((magnitude3(&within([3.0, 4.0, 0.0], 1.0)) - 1.0).abs() < 1e-12);
        assert_eq!(within([0.3, 0.4, 0.0], 1.0), [0.3, 0.4, 0.0]);
    }

    /// What was seen along a step holds afterwards; across it nothing changes.
    #[test]
    fn a_slope_learns_what_a_step_has_changed() {
        let (step, less) = ([0.1, -0.2, 0.05], [0.7, 0.1, -0.2]);
        let mut slope = SLOPE;
        learn(&mut slope, &step, &less);
        let found = times(&slope, &step);
        assert!(found.iter().zip(&less).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
        let across = [0.2, 0.1, 0.0];
        let (now, before) = (times(&slope, &across), times(&SLOPE, &across));
        assert!(now.iter().zip(&before).all(|(a, b)| (a - b).abs() < 1e-12));
    }

    #[test]
    fn what_is_moved_returns_unless_some_direction_gives_way_or_swings_up() {
        assert!(returns(&SLOPE));
        let mut gives = SLOPE;
        gives[1][1] = -1.0;
        assert!(!returns(&gives));
        // Three eigenvalues: 3, and 0.1 ± 2i or −0.1 ± 2i.
        let turning = |real: f64| [[real, -2.0, 0.0], [2.0, real, 0.0], [0.0, 0.0, 3.0]];
        assert!(returns(&turning(0.1)) && !returns(&turning(-0.1)));
        // A turn that nothing answers stays where it is.
        assert!(returns(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0]]));
    }
}
