//! A line through scattered points without shortening its curves: at every place a cubic is fitted to the neighbours, weighted
//! by nearness and against outliers (Cleveland, "Robust Locally Weighted Regression and Smoothing Scatterplots", 1979).

use nalgebra::{DMatrix, DVector};

/// Rounds of weighting against outliers.
const ROUNDS: usize = 4;
/// The fewest neighbours of a cubic.
const FEWEST: usize = 6;

/// A fitted value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fitted {
    /// The curve's value at the place asked for.
    pub value: f64,
    /// Its slope there.
    pub slope: f64,
    /// Standard deviation of a single point from the curve.
    pub scatter: f64,
    /// Standard deviation of `value`.
    pub deviation: f64,
}

/// The curve's value at place 0 from points (place, value) within `reach`; a line through fewer points than a cubic needs;
/// none for fewer than three.
pub fn fit(points: &[(f64, f64)], reach: f64) -> Option<Fitted> {
    let near: Vec<(f64, f64)> = points.iter().copied().filter(|(place, _)| place.abs() < reach).collect();
    if near.len() < 3 {
        return None;
    }
    let columns = if near.len() >= FEWEST { 4 } else { 2 };
    let matrix = DMatrix::from_fn(near.len(), columns, |row, power| (near[row].0 / reach).powi(power as i32));
    let values = DVector::from_iterator(near.len(), near.iter().map(|point| point.1));
    let nearness = near.iter().map(|(place, _)| (1.0 - (place.abs() / reach).powi(3)).powi(3));
    let nearness = DVector::from_iterator(near.len(), nearness);
    let mut weights = nearness.clone();
    let mut solved = None;
    for _ in 0..ROUNDS {
        let weighted = DMatrix::from_fn(near.len(), columns, |row, column| weights[row] * matrix[(row, column)]);
        let inverse = (weighted.transpose() * &matrix).try_inverse()?;
        let coefficients = &inverse * weighted.transpose() * &values;
        let residuals = &values - &matrix * &coefficients;
        let mut sizes: Vec<f64> = residuals.iter().map(|r| r.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        // 1.4826: from the median of absolute values to a normal distribution's standard deviation.
        let freedom = (near.len() as f64 / (near.len() - columns).max(1) as f64).sqrt();
        let scatter = 1.4826 * sizes[sizes.len() / 2] * freedom;
        // Weights of the points in the value at 0.
        let row = inverse.row(0) * weighted.transpose();
        let deviation = scatter * row.norm();
        solved = Some(Fitted { value: coefficients[0], slope: coefficients[1] / reach, scatter, deviation });
        if scatter < 1e-12 {
            break;
        }
        for row in 0..near.len() {
            let far = residuals[row] / (6.0 * scatter);
            weights[row] = nearness[row] * (1.0 - far * far).max(0.0).powi(2);
        }
    }
    solved
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_comes_back_and_an_outlier_does_not_count() {
        let curve = |x: f64| 0.4 + 0.1 * x - 0.05 * x * x + 0.02 * x * x * x;
        let mut points: Vec<_> = (-10..=10).map(|i| 0.25 * f64::from(i)).map(|x| (x, curve(x))).collect();
        assert!((fit(&points, 2.5).unwrap().value - 0.4).abs() < 1e-12);
        points.iter_mut().enumerate().for_each(|(i, p)| p.1 += 0.01 * (i as f64 * 2.3).sin());
        points[12].1 += 3.0;
        let found = fit(&points, 2.5).unwrap();
        assert!((found.value - 0.4).abs() < 0.01 && (found.slope - 0.1).abs() < 0.02, "{found:?}");
        assert!(found.deviation < found.scatter && found.scatter < 0.03, "{found:?}");
        assert_eq!(fit(&points[..2], 9.0), None);
    }
}
