//! Nonlinear least squares: Levenberg–Marquardt with derivatives by central differences.

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn};

/// Relative step of the differences: near the cube root of the machine's precision.
const STEP: f64 = 6e-6;

/// A minimum of the sum of squares.
pub struct Minimum {
    /// Parameters.
    pub parameters: DVector<f64>,
    /// Residuals there.
    pub residuals: DVector<f64>,
    /// Standard deviations of the parameters, from the residuals' scatter and the Jacobian; none if it is singular or
    /// there are no more residuals than parameters.
    pub deviations: Option<DVector<f64>>,
}

struct Problem<F> {
    parameters: DVector<f64>,
    residuals: F,
}

impl<F: Fn(&DVector<f64>) -> DVector<f64>> Problem<F> {
    fn derivative(&self) -> DMatrix<f64> {
        let columns: Vec<DVector<f64>> = (0..self.parameters.len())
            .map(|column| {
                let mut moved = self.parameters.clone();
                let step = STEP * moved[column].abs().max(1e-2);
                moved[column] += step;
                let above = (self.residuals)(&moved);
                moved[column] -= 2.0 * step;
                (above - (self.residuals)(&moved)) / (2.0 * step)
            })
            .collect();
        DMatrix::from_columns(&columns)
    }
}

impl<F: Fn(&DVector<f64>) -> DVector<f64>> LeastSquaresProblem<f64, Dyn, Dyn> for Problem<F> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, parameters: &DVector<f64>) {
        self.parameters.copy_from(parameters);
    }

    fn params(&self) -> DVector<f64> {
        self.parameters.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let residuals = (self.residuals)(&self.parameters);
        residuals.iter().all(|r| r.is_finite()).then_some(residuals)
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        Some(self.derivative())
    }
}

/// Minimises the sum of the squares of `residuals` from a start; none if it does not come to an end at a finite place.
pub fn minimise(start: DVector<f64>, residuals: impl Fn(&DVector<f64>) -> DVector<f64>) -> Option<Minimum> {
    let (problem, report) = LevenbergMarquardt::new().minimize(Problem { parameters: start, residuals });
    if !report.termination.was_successful() {
        return None;
    }
    let residuals = problem.residuals()?;
    let jacobian = problem.derivative();
    let spare = residuals.len().saturating_sub(jacobian.ncols());
    let deviations = (spare > 0).then(|| (jacobian.transpose() * &jacobian).try_inverse()).flatten().map(|inverse| {
        let variance = residuals.norm_squared() / spare as f64;
        inverse.diagonal().map(|entry| (entry * variance).max(0.0).sqrt())
    });
    Some(Minimum { parameters: problem.parameters, residuals, deviations })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_decay_is_found_again() {
        let model = |p: &DVector<f64>, x: f64| p[0] * (-p[1] * x).exp() + p[2];
        let truth = DVector::from_vec(vec![3.0, 0.7, -1.0]);
        let found = minimise(DVector::from_vec(vec![1.0, 0.1, 0.0]), |p| {
            DVector::from_iterator(20, (0..20).map(|i| model(p, 0.3 * i as f64) - model(&truth, 0.3 * i as f64)))
        })
        .unwrap();
        assert!((found.parameters - truth).amax() < 1e-8);
        assert!(found.deviations.unwrap().amax() < 1e-8);
    }
}
