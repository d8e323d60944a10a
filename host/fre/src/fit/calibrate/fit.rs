//! The fit: Levenberg and Marquardt's method on the model's sensitivities, with a robust loss.
//!
//! A reading's residual is measured less predicted force over its standard deviation. The angle is uncertain as well as the
//! force, so that deviation is √(σ_F² + (dF/dα·σ_α)²): errors in variables, to first order. Readings that lie far off count less
//! (P. J. Huber, Robust Statistics, 1981; Tukey's biweight rejects them altogether).
//!
//! Steps are taken along the eigenvectors of the information matrix, parameters in units of their [`Parameter::doubt`]. An
//! eigenvector along which the data leave more open than that is left alone and reported: a combination they do not tell.

use model_core::discretise::DiscretiseError;
use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::{Model, Parameter, Prediction, Run, Trial};
use crate::metrics::signed_distance;

/// How a residual of so many standard deviations counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Loss {
    /// Squared, whatever its size.
    Square,
    /// Squared within 1.345 standard deviations, linear beyond: 95 % efficient if nothing is amiss.
    #[default]
    Huber,
    /// Tukey's biweight: of no weight beyond 4.685. The same efficiency; outliers are rejected, but so is all that a bad start
    /// puts far off.
    Tukey,
}

const HUBER: f64 = 1.345;
const TUKEY: f64 = 4.685;
/// Residual that stands for a reading without a trustworthy prediction, in standard deviations.
const LOST: f64 = 30.0;
/// Passes over the readings.
const PASSES: usize = 60;
/// Points of an outline count as at most so many independent ones: they share the camera's errors.
const INDEPENDENT_POINTS: f64 = 10.0;
/// Once what a pass could still gain is less than this, squared standard deviations, the readings keep their deviations and the
/// residuals their scale: where a sample begins to touch, slopes and so deviations jump, and the fit would go to and fro between two sets.
const SETTLED: f64 = 0.25;
/// Where no step makes it better, the fit has ended if less than this was left to gain: a fifth of a standard deviation. (The model's
/// slopes jump where samples begin to touch; the best place may be such an edge.)
const EDGE: f64 = 0.04;
/// Shift, in doubts, of the differences that an outline's derivatives are made of.
const SHIFT: f64 = 1e-3;

impl Loss {
    /// ρ(u), its derivative ψ over u (the weight) and ψ′.
    fn of(self, u: f64) -> (f64, f64, f64) {
        let size = u.abs();
        match self {
            Self::Huber if size > HUBER => (HUBER * (size - 0.5 * HUBER), HUBER / size, 0.0),
            Self::Tukey => {
                let rest = 1.0 - (u / TUKEY).powi(2);
                let flat = TUKEY * TUKEY / 6.0;
                if rest <= 0.0 {
                    return (flat, 0.0, 0.0);
                }
                let slope = rest * (rest - 4.0 * (u / TUKEY).powi(2));
                (flat * (1.0 - rest.powi(3)), rest * rest, slope)
            }
            _ => (0.5 * u * u, 1.0, 1.0),
        }
    }
}

/// What is known of the measurements, and how residuals count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Standard deviation of a measured force, N.
    pub force_n: f64,
    /// Of a measured angle, degrees.
    pub angle_deg: f64,
    /// Of a point of an outline, mm.
    pub outline_mm: f64,
    /// The loss.
    pub loss: Loss,
}

impl Default for Noise {
    /// A force sensor of 0.02 N, angles rounded to a servo's count (0.088°/√12), outlines within 0.3 mm.
    fn default() -> Self {
        Self { force_n: 0.02, angle_deg: 360.0 / 4096.0 / 12_f64.sqrt(), outline_mm: 0.3, loss: Loss::default() }
    }
}

/// A parameter's outcome.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Which.
    pub parameter: Parameter,
    /// Where the fit began.
    pub start: f64,
    /// Fitted value.
    pub value: f64,
    /// Standard deviation.
    pub standard_deviation: f64,
    /// False if the data do not tell it apart from others: value and deviation then say little.
    pub determined: bool,
}

/// A combination that the data do not tell.
#[derive(Clone, Debug, PartialEq)]
pub struct Combination {
    /// Changes of the parameters, in their units, that go together and change nothing that was measured.
    pub terms: Vec<(Parameter, f64)>,
}

/// A reading's force and what the fit says of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Residual {
    /// Index of the run.
    pub run: usize,
    /// Line of its file.
    pub line: usize,
    /// Measured angle, degrees.
    pub angle_deg: f64,
    /// Measured and predicted force, N; none without a trustworthy solution.
    pub measured_n: f64,
    /// Predicted force, N; none without a trustworthy solution.
    pub predicted_n: Option<f64>,
    /// Standard deviation of their difference, N.
    pub standard_deviation_n: f64,
    /// Weight that the loss left it, 0 … 1.
    pub weight: f64,
}

impl Residual {
    /// Measured less predicted, N.
    pub fn difference_n(&self) -> Option<f64> {
        self.predicted_n.map(|predicted| self.measured_n - predicted)
    }

    /// So far off that it counts for less than half.
    pub fn is_outlier(&self) -> bool {
        self.weight < 0.5
    }
}

/// A finished fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// The values.
    pub trial: Trial,
    /// One per parameter.
    pub estimates: Vec<Estimate>,
    /// Correlations of the estimates, row by row.
    pub correlation: Vec<Vec<f64>>,
    /// What the data do not tell.
    pub undetermined: Vec<Combination>,
    /// Every force, run by run.
    pub residuals: Vec<Residual>,
    /// Points of outlines that took part, and the root mean square of their distances, mm.
    pub outline: Option<(usize, f64)>,
    /// Passes over the readings.
    pub passes: usize,
    /// The last step was small beside the standard deviations.
    pub converged: bool,
    /// Residuals over what the stated noise allows (the standard deviations were made greater by it): 1 if the model holds.
    pub inflation: f64,
}

impl Fit {
    /// Root mean square of the forces' residuals that count, N.
    pub fn rms_n(&self) -> f64 {
        let kept: Vec<f64> =
            self.residuals.iter().filter(|r| !r.is_outlier()).filter_map(Residual::difference_n).collect();
        (kept.iter().map(|d| d * d).sum::<f64>() / kept.len().max(1) as f64).sqrt()
    }
}

/// A term of the sum: residual and derivatives with respect to the parameters in units of their doubt, over the deviation.
struct Row {
    residual: f64,
    gradient: DVector<f64>,
    deviation: f64,
}

/// What no longer changes near the end of a fit.
struct Settled {
    /// [`spread`] of the residuals.
    scale: f64,
    /// Deviations of the rows; none for those without a prediction then.
    deviations: Vec<Option<f64>>,
}

/// Everything at one trial.
struct Point {
    trial: Trial,
    predictions: Vec<Vec<Prediction>>,
    /// Forces in the order of runs and readings, then points of outlines; none for readings without a prediction.
    rows: Vec<Option<Row>>,
}

/// Fits parameters to runs.
///
/// # Errors
/// If the design is refused as it is.
pub fn fit(model: &Model<'_>, runs: &[Run], parameters: &[Parameter], noise: &Noise) -> Result<Fit, DiscretiseError> {
    let doubts: Vec<f64> = parameters.iter().map(|parameter| parameter.doubt(model.design)).collect();
    let mut here = evaluate(model, runs, Trial::start(parameters, model.design), noise, &doubts, None)?;
    let mut damping = 1e-3;
    let mut settled: Option<Settled> = None;
    let (mut passes, mut converged) = (1, false);
    while passes < PASSES && !converged {
        let scale = settled.as_ref().map_or_else(|| spread(&here.rows, noise.loss), |settled| settled.scale);
        let (information, slope) = normal_equations(&here.rows, noise.loss, scale, parameters.len());
        let eigen = SymmetricEigen::new(information);
        let before = cost(&here.rows, None, noise.loss, scale);
        let mut step = DVector::zeros(parameters.len());
        let mut gain = 0.0;
        for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
            if *value >= 1.0 {
                let part = vector.dot(&slope) / (value * (1.0 + damping));
                gain += part * part * value;
                step += vector * part;
            }
        }
        // Within half a doubt per pass: beyond that the model is another.
        let largest = step.amax();
        if largest > 0.5 {
            step *= 0.5 / largest;
        }
        if gain < 1e-6 {
            converged = true;
            break;
        }
        if gain < SETTLED && settled.is_none() {
            let deviations = here.rows.iter().map(|row| row.as_ref().map(|row| row.deviation)).collect();
            settled = Some(Settled { scale, deviations });
        }
        let mut trial = here.trial.clone();
        for ((value, part), doubt) in trial.values.iter_mut().zip(step.iter()).zip(&doubts) {
            *value += part * doubt;
        }
        passes += 1;
        let next = evaluate(model, runs, trial, noise, &doubts, settled.as_ref()).ok();
        let better = next.filter(|next| cost(&next.rows, Some(&here.rows), noise.loss, scale) <= before);
        match better {
            Some(next) => {
                here = next;
                damping = (damping * 0.1_f64).max(1e-9);
            }
            None => {
                damping = if damping < 0.1 { 1.0 } else { damping * 10.0 };
                // No step, however short, makes it better by more than rounding.
                if damping > 1e6 {
                    converged = gain < EDGE;
                    break;
                }
            }
        }
    }
    Ok(finish(model, runs, parameters, noise, here, &doubts, passes, converged))
}

fn evaluate(
    model: &Model<'_>,
    runs: &[Run],
    trial: Trial,
    noise: &Noise,
    doubts: &[f64],
    settled: Option<&Settled>,
) -> Result<Point, DiscretiseError> {
    let kept = |index: usize| settled.and_then(|settled| settled.deviations.get(index).copied().flatten());
    let predict = |trial: &Trial, derivatives| {
        runs.iter().map(|run| model.predict(run, trial, derivatives)).collect::<Result<Vec<_>, _>>()
    };
    let predictions = predict(&trial, true)?;
    let mut rows = Vec::new();
    for (run, predicted) in runs.iter().zip(&predictions) {
        for (reading, prediction) in run.readings.iter().zip(predicted) {
            let Some(measured) = reading.force_n else { continue };
            rows.push(prediction.status.is_trustworthy().then(|| {
                let own = || noise.force_n.hypot(prediction.force_per_deg_n * noise.angle_deg);
                let deviation = kept(rows.len()).unwrap_or_else(own);
                let gradient = prediction.gradient.iter().zip(doubts).map(|(g, doubt)| g * doubt / deviation);
                Row {
                    residual: (measured - prediction.force_n) / deviation,
                    gradient: DVector::from_iterator(doubts.len(), gradient),
                    deviation,
                }
            }));
        }
    }
    if runs.iter().any(|run| run.readings.iter().any(|reading| !reading.front_mm.is_empty())) {
        let mut shifted = Vec::new();
        for (index, doubt) in doubts.iter().enumerate() {
            let mut other = trial.clone();
            other.values[index] += SHIFT * doubt;
            shifted.push(predict(&other, false)?);
        }
        for (r, run) in runs.iter().enumerate() {
            for (i, reading) in run.readings.iter().enumerate() {
                let points = &reading.front_mm;
                let deviation = noise.outline_mm * (points.len() as f64 / INDEPENDENT_POINTS).max(1.0).sqrt();
                for &point in points {
                    let away = |prediction: &Prediction| signed_distance(point, &prediction.front_mm);
                    let here = away(&predictions[r][i]);
                    let there: Option<Vec<f64>> = shifted.iter().map(|other| away(&other[r][i])).collect();
                    rows.push(here.zip(there).map(|(here, there)| Row {
                        // The line moving towards the point is what takes the distance away.
                        residual: here / deviation,
                        gradient: DVector::from_iterator(
                            doubts.len(),
                            there.iter().map(|there| (here - there) / SHIFT / deviation),
                        ),
                        deviation,
                    }));
                }
            }
        }
    }
    Ok(Point { trial, predictions, rows })
}

/// Scale of the residuals: 1, or more if half of them are larger than the stated noise explains.
fn spread(rows: &[Option<Row>], loss: Loss) -> f64 {
    let mut sizes: Vec<f64> = rows.iter().flatten().map(|row| row.residual.abs()).collect();
    if loss == Loss::Square || sizes.is_empty() {
        return 1.0;
    }
    sizes.sort_by(f64::total_cmp);
    // The median of a normal distribution's magnitudes is 0.6745 of its deviation.
    (sizes[sizes.len() / 2] / 0.6745).max(1.0)
}

fn normal_equations(rows: &[Option<Row>], loss: Loss, scale: f64, count: usize) -> (DMatrix<f64>, DVector<f64>) {
    let mut information = DMatrix::zeros(count, count);
    let mut slope = DVector::zeros(count);
    for row in rows.iter().flatten() {
        let (_, weight, _) = loss.of(row.residual / scale);
        information.ger(weight, &row.gradient, &row.gradient, 1.0);
        slope.axpy(weight * row.residual, &row.gradient, 1.0);
    }
    (information, slope)
}

/// Sum of the losses, with the deviations of `reference`, so that a step is not judged better for making readings count less.
fn cost(rows: &[Option<Row>], reference: Option<&[Option<Row>]>, loss: Loss, scale: f64) -> f64 {
    let term = |(index, row): (usize, &Option<Row>)| {
        let size = row.as_ref().map_or(LOST, |row| {
            let other = reference.and_then(|rows| rows[index].as_ref());
            row.residual * other.map_or(1.0, |other| row.deviation / other.deviation)
        });
        loss.of(size / scale).0
    };
    rows.iter().enumerate().map(term).sum()
}

#[allow(clippy::too_many_arguments)]
fn finish(
    model: &Model<'_>,
    runs: &[Run],
    parameters: &[Parameter],
    noise: &Noise,
    here: Point,
    doubts: &[f64],
    passes: usize,
    converged: bool,
) -> Fit {
    let count = parameters.len();
    let scale = spread(&here.rows, noise.loss);
    let losses: Vec<_> = here.rows.iter().flatten().map(|row| (noise.loss.of(row.residual / scale), row)).collect();
    let mut information = DMatrix::zeros(count, count);
    for (_, row) in &losses {
        information.ger(1.0, &row.gradient, &row.gradient, 1.0);
    }
    // Huber's estimate of the covariance (Robust Statistics, 7.6), never below what the stated noise alone gives.
    let rows = losses.len() as f64;
    let squares: f64 = losses.iter().map(|((_, weight, _), row)| (weight * row.residual).powi(2)).sum();
    let slopes: f64 = losses.iter().map(|((_, _, slope), _)| slope).sum::<f64>() / rows.max(1.0);
    let freedom = rows - count as f64;
    let inflation = if freedom > 0.0 && slopes > 0.0 { (squares / freedom / (slopes * slopes)).max(1.0) } else { 1.0 };

    let eigen = SymmetricEigen::new(information);
    let mut covariance = DMatrix::zeros(count, count);
    let mut open = vec![0.0; count];
    let mut undetermined = Vec::new();
    for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
        let vector = vector.into_owned();
        if *value >= 1.0 {
            covariance.ger(inflation / value, &vector, &vector, 1.0);
            continue;
        }
        // As open as it was before.
        covariance.ger(1.0, &vector, &vector, 1.0);
        let largest = vector.iter().zip(doubts).max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
        let sign = largest.map_or(1.0, |(part, _)| part.signum());
        let mut terms = Vec::new();
        for (i, &part) in vector.iter().enumerate() {
            open[i] += part * part;
            if part.abs() > 0.1 {
                terms.push((parameters[i], sign * part * doubts[i]));
            }
        }
        undetermined.push(Combination { terms });
    }
    let deviation: Vec<f64> = (0..count).map(|i| covariance[(i, i)].sqrt()).collect();
    let estimates = parameters.iter().enumerate().map(|(i, &parameter)| Estimate {
        parameter,
        start: parameter.start(model.design),
        value: here.trial.values[i],
        standard_deviation: deviation[i] * doubts[i],
        determined: open[i] < 0.05,
    });
    let correlation =
        (0..count).map(|i| (0..count).map(|j| covariance[(i, j)] / (deviation[i] * deviation[j])).collect()).collect();

    let mut residuals = Vec::new();
    let mut rows = here.rows.iter();
    for (index, (run, predictions)) in runs.iter().zip(&here.predictions).enumerate() {
        for (reading, prediction) in run.readings.iter().zip(predictions) {
            let Some(measured) = reading.force_n else { continue };
            let row = rows.next().and_then(Option::as_ref);
            residuals.push(Residual {
                run: index,
                line: reading.line,
                angle_deg: reading.angle_deg,
                measured_n: measured,
                predicted_n: row.map(|_| prediction.force_n),
                standard_deviation_n: row.map_or(noise.force_n, |row| row.deviation),
                weight: row.map_or(0.0, |row| noise.loss.of(row.residual / scale).1),
            });
        }
    }
    let distances: Vec<f64> = runs
        .iter()
        .zip(&here.predictions)
        .flat_map(|(run, predictions)| run.readings.iter().zip(predictions))
        .flat_map(|(reading, p)| reading.front_mm.iter().filter_map(|&at| signed_distance(at, &p.front_mm)))
        .collect();
    let mean_square = distances.iter().map(|d| d * d).sum::<f64>() / distances.len().max(1) as f64;
    let outline = (!distances.is_empty()).then(|| (distances.len(), mean_square.sqrt()));
    Fit {
        estimates: estimates.collect(),
        correlation,
        undetermined,
        residuals,
        outline,
        passes,
        converged,
        inflation: inflation.sqrt(),
        trial: here.trial,
    }
}
