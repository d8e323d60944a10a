//! The rows of the sum that a fit makes small, and what those of each quantity say of its noise.
//!
//! Each quantity has a scale, degrees of freedom and an inflation of its own: one that fits well does not hide how far another is off. A row
//! counts as a share of an independent measurement, the same everywhere: in the sum, in medians, in means and in the degrees of freedom.

use nalgebra::{DMatrix, DVector};

use super::noise::Loss;
use super::rests::Equations;

/// Residual that stands for a row without a trustworthy prediction, in standard deviations.
const LOST: f64 = 30.0;
/// With fewer degrees of freedom left, a quantity's residuals say nothing of its noise.
const LEAST_FREEDOM: f64 = 0.5;

/// The quantity whose noise a row has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Source {
    Force,
    Torque,
    Outline,
}

/// A value for each source.
#[derive(Clone, Copy, Debug)]
pub(super) struct BySource<T>([T; 3]);

impl<T> BySource<T> {
    /// What the function gives for each.
    fn of(value: impl FnMut(Source) -> T) -> Self {
        Self([Source::Force, Source::Torque, Source::Outline].map(value))
    }

    pub(super) fn at(&self, source: Source) -> &T {
        &self.0[source as usize]
    }

    pub(super) fn all(&self) -> impl Iterator<Item = &T> {
        self.0.iter()
    }
}

/// A row of the sum.
pub(super) struct Row {
    pub(super) source: Source,
    /// The independent measurements that it counts as, up to 1.
    pub(super) share: f64,
    /// None without a prediction.
    pub(super) term: Option<Term>,
}

/// Residual and derivatives with respect to the parameters in units of their doubt, over the deviation.
pub(super) struct Term {
    pub(super) residual: f64,
    pub(super) gradient: DVector<f64>,
    /// The rest whose angle's error it has in it, and the derivative with respect to that.
    pub(super) rest: Option<(usize, f64)>,
    pub(super) deviation: f64,
}

/// Shares and terms of the rows that have a prediction.
fn terms(rows: &[Row]) -> impl Iterator<Item = (&Row, &Term)> {
    rows.iter().filter_map(|row| Some((row, row.term.as_ref()?)))
}

/// Scale of each source's residuals: 1, or more if half of them are larger than the stated noise explains.
pub(super) fn spreads(rows: &[Row], loss: Loss) -> BySource<f64> {
    BySource::of(|source| {
        let of_it = terms(rows).filter(|(row, _)| row.source == source && loss != Loss::Square);
        let mut sizes: Vec<[f64; 2]> = of_it.map(|(row, term)| [term.residual.abs(), row.share]).collect();
        sizes.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let half = 0.5 * sizes.iter().map(|[_, share]| share).sum::<f64>();
        let mut counted = 0.0;
        let median = sizes.iter().find(|[_, share]| {
            counted += share;
            counted > half
        });
        // The median of a normal distribution's magnitudes is 0.6745 of its deviation.
        median.map_or(1.0, |[size, _]| (size / 0.6745).max(1.0))
    })
}

pub(super) fn normal_equations(
    rows: &[Row],
    loss: Loss,
    scales: &BySource<f64>,
    count: usize,
    rests: usize,
) -> Equations {
    let mut equations = Equations::new(count, rests);
    for (row, term) in terms(rows) {
        let (_, weight, _) = loss.of(term.residual / scales.at(row.source));
        equations.add(row.share * weight, term.residual, &term.gradient, term.rest);
    }
    equations
}

/// Sum of the losses, with the deviations of `reference`, so that a step is not judged better for making readings count less.
pub(super) fn cost(rows: &[Row], reference: Option<&[Row]>, loss: Loss, scales: &BySource<f64>) -> f64 {
    let of_row = |(index, row): (usize, &Row)| {
        let size = row.term.as_ref().map_or(LOST, |term| {
            let other = reference.and_then(|rows| rows[index].term.as_ref());
            term.residual * other.map_or(1.0, |other| term.deviation / other.deviation)
        });
        // Small residuals count as squared in standard deviations, whatever the scale: that is what a quantity weighs beside the others.
        let scale = scales.at(row.source);
        row.share * scale * scale * loss.of(size / scale).0
    };
    rows.iter().enumerate().map(of_row).sum()
}

/// What a source's rows say at the end of a fit.
pub(super) struct Evidence {
    /// Information on the parameters, by the stated noise.
    pub(super) information: DMatrix<f64>,
    /// Variance of the residuals over the stated one, at least 1: Huber's estimate (Robust Statistics, 7.6).
    pub(super) inflation: f64,
}

/// What each source's rows say, where `covariance` is the parameters' by the stated noise, and 0 along what was not fitted.
pub(super) fn evidence(
    rows: &[Row],
    equations: &Equations,
    covariance: &DMatrix<f64>,
    loss: Loss,
    scales: &BySource<f64>,
) -> BySource<Evidence> {
    BySource::of(|source| {
        let mut information = DMatrix::zeros(covariance.nrows(), covariance.ncols());
        let (mut count, mut by_errors, mut squares, mut slopes) = (0.0, 0.0, 0.0, 0.0);
        for (Row { share, .. }, term) in terms(rows).filter(|(row, _)| row.source == source) {
            let (gradient, by_error) = equations.beside_errors(&term.gradient, term.rest);
            let (_, weight, slope) = loss.of(term.residual / scales.at(source));
            information.ger(*share, &gradient, &gradient, 1.0);
            count += share;
            by_errors += share * by_error;
            squares += share * (weight * term.residual).powi(2);
            slopes += share * slope;
        }
        // What parameters and errors of the angle take from the rows.
        let freedom = count - by_errors - (covariance * &information).trace();
        let slope = slopes / count;
        let told = freedom > LEAST_FREEDOM && slope > 0.0;
        let inflation = if told { (squares / freedom / (slope * slope)).max(1.0) } else { 1.0 };
        Evidence { information, inflation }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(source: Source, share: f64, residual: f64, gradient: f64) -> Row {
        let gradient = DVector::from_element(1, gradient);
        Row { source, share, term: Some(Term { residual, gradient, rest: None, deviation: 1.0 }) }
    }

    #[test]
    fn a_scale_is_the_median_of_what_the_rows_count() {
        let mut rows: Vec<Row> = [1.0, 4.0, 2.0, 3.0].map(|size| row(Source::Force, 1.0, size, 1.0)).into();
        let scales = spreads(&rows, Loss::Huber);
        assert_eq!((*scales.at(Source::Force), *scales.at(Source::Torque)), (3.0 / 0.6745, 1.0));
        // Outlines are another quantity; one of 1000 points counts as much as one of 10, and more than one of 9.
        rows.extend((0..1000).map(|_| row(Source::Outline, 0.01, 0.1, 0.0)));
        rows.extend((0..9).map(|_| row(Source::Outline, 1.0, 5.0, 0.0)));
        assert_eq!(*spreads(&rows, Loss::Huber).at(Source::Force), 3.0 / 0.6745);
        assert_eq!(*spreads(&rows, Loss::Huber).at(Source::Outline), 1.0);
        rows.extend((0..2).map(|_| row(Source::Outline, 1.0, 6.0, 0.0)));
        assert_eq!(*spreads(&rows, Loss::Huber).at(Source::Outline), 5.0 / 0.6745);
        assert_eq!(*spreads(&rows, Loss::Square).at(Source::Outline), 1.0);
    }

    /// One parameter, 20 forces three standard deviations off, and many points that fit: a force's inflation is that of the forces alone.
    #[test]
    fn a_quantity_that_fits_hides_nothing_of_another() {
        let off = |index: usize| if index.is_multiple_of(2) { 3.0 } else { -3.0 };
        let forces = || (0..20).map(|index| row(Source::Force, 1.0, off(index), 1.0));
        let mut both: Vec<Row> = forces().collect();
        both.extend((0..400).map(|_| row(Source::Outline, 0.05, 0.0, 0.0)));
        for rows in [forces().collect(), both] {
            let scales = spreads(&rows, Loss::Square);
            let equations = normal_equations(&rows, Loss::Square, &scales, 1, 0);
            let covariance = equations.of_parameters().0.try_inverse().unwrap();
            let found = evidence(&rows, &equations, &covariance, Loss::Square, &scales);
            assert!((found.at(Source::Force).inflation - 9.0 * 20.0 / 19.0).abs() < 1e-12);
            assert_eq!((found.at(Source::Outline).inflation, found.at(Source::Torque).inflation), (1.0, 1.0));
        }
    }
}
