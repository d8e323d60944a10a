//! The fit: Levenberg and Marquardt's method on the model's sensitivities, with a robust loss.
//!
//! A reading's residual is measured less predicted force, or torque, over its standard deviation. The angle is uncertain as well as the
//! force, so that deviation is √(σ_F² + (dF/dα·σ_α)²): errors in variables, to first order. With friction dF/dα is that on the reading's
//! own way, and the angle of the last turn is uncertain, too, for all readings after it together. Readings that lie far off count less
//! (P. J. Huber, Robust Statistics, 1981; Tukey's biweight rejects them altogether).
//!
//! Points of an outline share the camera's errors: n of them count as at most 10 independent ones, each as 10/n of one. Residuals may be
//! larger than the stated noise allows; how much is estimated for every quantity on its own, and the standard deviations grow with it.
//!
//! Steps are taken along the eigenvectors of the information matrix, parameters in units of their [`Parameter::doubt`]. An
//! eigenvector along which the data leave more open than that is left alone and reported: a combination they do not tell. So is a
//! parameter whose standard deviation is larger than that once the residuals' true size is in it.

use std::convert::Infallible;
use std::ops::ControlFlow;

use model_core::discretise::DiscretiseError;
use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::noise::{Loss, Noise};
use super::parameter::Parameter;
use super::predictor::{Predicted, Prediction, Predictor};
use super::readings::{Reading, Readings};
use super::rests::{Rests, Shared};
use super::rows::{self, BySource, Row, Source, Term};
use super::trial::Trial;
use crate::metrics::signed_distance;

/// Passes over the readings.
const PASSES: usize = 60;
/// Points of an outline count as at most so many independent ones.
const INDEPENDENT_POINTS: f64 = 10.0;
/// Once what a pass could still gain is less than this, squared standard deviations, the readings keep their deviations and the
/// residuals their scale: where a sample begins to touch, slopes and so deviations jump, and the fit would go to and fro between two sets.
const SETTLED: f64 = 0.25;
/// Where no step makes it better, the fit has ended if less than this was left to gain: a fifth of a standard deviation. (The model's
/// slopes jump where samples begin to touch; the best place may be such an edge.)
const EDGE: f64 = 0.04;
/// Shift, in doubts, of the differences that an outline's derivatives are made of.
const SHIFT: f64 = 1e-3;

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
    /// False if the data do not tell it apart from others, or leave it less certain than it was before ([`Parameter::doubt`]): value and
    /// deviation then say little.
    pub determined: bool,
}

/// A combination that the data do not tell.
#[derive(Clone, Debug, PartialEq)]
pub struct Combination {
    /// Changes of the parameters, in their units, that go together and change nothing that was measured.
    pub terms: Vec<(Parameter, f64)>,
}

/// What was measured of a reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Magnitude of the force, N.
    Force,
    /// Torque of the motor, N·mm.
    Torque,
}

impl Quantity {
    /// All of them, in the order in which a fit has them of a reading.
    pub const ALL: [Self; 2] = [Self::Force, Self::Torque];

    /// Its unit.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Force => "N",
            Self::Torque => "N·mm",
        }
    }

    /// What several values of it are called.
    pub(super) fn plural(self) -> &'static str {
        match self {
            Self::Force => "forces",
            Self::Torque => "torques",
        }
    }

    /// Its measured value.
    fn measured(self, reading: &Reading) -> Option<f64> {
        match self {
            Self::Force => reading.force_n,
            Self::Torque => reading.torque_nmm,
        }
    }

    fn predicted(self, prediction: &Prediction) -> &Predicted {
        match self {
            Self::Force => &prediction.force,
            Self::Torque => &prediction.torque,
        }
    }

    fn source(self) -> Source {
        match self {
            Self::Force => Source::Force,
            Self::Torque => Source::Torque,
        }
    }

    /// Standard deviation of a measured value.
    pub(super) fn deviation(self, noise: &Noise) -> f64 {
        match self {
            Self::Force => noise.force_n,
            Self::Torque => noise.torque_nmm,
        }
    }

    /// What was measured of a reading, and its values.
    fn of(reading: &Reading) -> impl Iterator<Item = (Self, f64)> {
        Self::ALL.into_iter().filter_map(|quantity| Some((quantity, quantity.measured(reading)?)))
    }
}

/// A reading's force or torque, in the quantity's unit, and what the fit says of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Residual {
    /// Index of the run.
    pub run: usize,
    /// Line of its file.
    pub line: usize,
    /// Measured angle, degrees.
    pub angle_deg: f64,
    /// What was measured.
    pub quantity: Quantity,
    /// Measured value.
    pub measured: f64,
    /// Predicted value; none without a trustworthy solution.
    pub predicted: Option<f64>,
    /// Standard deviation of their difference.
    pub standard_deviation: f64,
    /// Weight that the loss left it, 0 … 1.
    pub weight: f64,
}

impl Residual {
    /// Measured less predicted.
    pub fn difference(&self) -> Option<f64> {
        self.predicted.map(|predicted| self.measured - predicted)
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
    /// Every force and torque, run by run.
    pub residuals: Vec<Residual>,
    /// Points of outlines that took part, and the root mean square of their distances, mm.
    pub outline: Option<(usize, f64)>,
    /// Passes over the readings.
    pub passes: usize,
    /// The last step was small beside the standard deviations.
    pub converged: bool,
    /// Residuals over what the stated noise allows; the standard deviations have it in them.
    pub inflation: Inflation,
}

/// Residuals of each quantity over what its stated noise allows: 1 if the model holds, or if too little was measured to say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inflation {
    /// Of forces, and of the angles that they were read at.
    pub force: f64,
    /// Of torques; of their angles if no forces were read there.
    pub torque: f64,
    /// Of points of outlines.
    pub outline: f64,
}

impl Inflation {
    /// Of a quantity.
    pub fn of(&self, quantity: Quantity) -> f64 {
        match quantity {
            Quantity::Force => self.force,
            Quantity::Torque => self.torque,
        }
    }

    /// The largest.
    pub fn largest(&self) -> f64 {
        self.force.max(self.torque).max(self.outline)
    }
}

impl Fit {
    /// The quantities that have residuals; force if none has.
    pub fn quantities(&self) -> Vec<Quantity> {
        let found: Vec<Quantity> = Quantity::ALL.into_iter().filter(|&q| self.of(q).next().is_some()).collect();
        if found.is_empty() { vec![Quantity::Force] } else { found }
    }

    /// The residuals of a quantity.
    pub fn of(&self, quantity: Quantity) -> impl Iterator<Item = &Residual> {
        self.residuals.iter().filter(move |residual| residual.quantity == quantity)
    }

    /// Root mean square of a quantity's residuals without its outliers, in its unit; 0 without any.
    pub fn rms(&self, quantity: Quantity) -> f64 {
        rms(self.of(quantity).filter(|residual| !residual.is_outlier()))
    }

    /// The same with its outliers.
    pub fn rms_of_all(&self, quantity: Quantity) -> f64 {
        rms(self.of(quantity))
    }

    /// How many of a quantity's residuals are outliers. Readings without a solution have no residual.
    pub fn outliers(&self, quantity: Quantity) -> usize {
        self.of(quantity).filter(|residual| residual.is_outlier() && residual.predicted.is_some()).count()
    }
}

/// Root mean square of residuals; 0 without any.
fn rms<'a>(residuals: impl Iterator<Item = &'a Residual>) -> f64 {
    let (count, sum) =
        residuals.filter_map(Residual::difference).fold((0, 0.0), |(count, sum), d| (count + 1, sum + d * d));
    (sum / f64::from(count.max(1))).sqrt()
}

/// What no longer changes near the end of a fit.
struct Settled {
    /// [`rows::spreads`] of the residuals.
    scales: BySource<f64>,
    /// Deviations of the rows; none for those without a prediction then.
    deviations: Vec<Option<f64>>,
}

/// Everything at one trial.
struct Point {
    trial: Trial,
    /// The rests' errors of the angle, in its standard deviations.
    errors: Vec<f64>,
    predictions: Vec<Vec<Prediction>>,
    /// Forces and torques in the order of runs and readings, then points of outlines, then the rests' errors.
    rows: Vec<Row>,
}

/// Fits parameters to runs.
///
/// # Errors
/// Nothing is to be fitted, or the design is refused as it is.
pub fn fit(
    model: &Predictor<'_>,
    runs: &[Readings],
    parameters: &[Parameter],
    noise: &Noise,
) -> Result<Fit, FitError<Infallible>> {
    fit_watched(model, runs, parameters, noise, |_| ControlFlow::Continue(()))
}

/// How far a fit is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Passes over the readings that are done.
    pub passes: usize,
    /// The most that there may be; most fits need fewer.
    pub most: usize,
    /// What the next pass may still gain, squared standard deviations; none before the first step.
    pub gain: Option<f64>,
}

/// Why a fit has no results; `B` is what the watcher stops it with.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FitError<B> {
    /// Nothing is to be fitted.
    #[error("at least one parameter to fit is needed; allowed is {}", Parameter::ALL.map(Parameter::word).join(", "))]
    NoParameters,
    /// The finger cannot be discretised as asked.
    #[error(transparent)]
    Discretise(#[from] DiscretiseError),
    /// The watcher stopped it.
    #[error("stopped")]
    Stopped(B),
}

/// As [`fit()`], calling `watch` after every pass over the readings; it stops the work by [`ControlFlow::Break`].
///
/// # Errors
/// As there, or the work was stopped.
pub fn fit_watched<B>(
    model: &Predictor<'_>,
    runs: &[Readings],
    parameters: &[Parameter],
    noise: &Noise,
    mut watch: impl FnMut(Progress) -> ControlFlow<B>,
) -> Result<Fit, FitError<B>> {
    if parameters.is_empty() {
        return Err(FitError::NoParameters);
    }
    let doubts: Vec<f64> = parameters.iter().map(|parameter| parameter.doubt(model.design, model.prony)).collect();
    let rests = Rests::find(runs, |run| run.friction != 0.0 || parameters.contains(&Parameter::Friction));
    let judge = Judge { model, runs, noise, doubts: &doubts, rests: &rests };
    let mut here = judge.evaluate(Trial::start(parameters, model.design, model.prony), vec![0.0; rests.count], None)?;
    let mut damping = 1e-3;
    let mut settled: Option<Settled> = None;
    let (mut passes, mut converged) = (1, false);
    let mut report = |passes, gain| match watch(Progress { passes, most: PASSES, gain }) {
        ControlFlow::Break(with) => Err(FitError::Stopped(with)),
        ControlFlow::Continue(()) => Ok(()),
    };
    report(passes, None)?;
    while passes < PASSES && !converged {
        let scales = settled.as_ref().map_or_else(|| rows::spreads(&here.rows, noise.loss), |settled| settled.scales);
        let equations = rows::normal_equations(&here.rows, noise.loss, &scales, parameters.len(), rests.count);
        let (information, slope) = equations.of_parameters();
        let eigen = SymmetricEigen::new(information);
        let before = rows::cost(&here.rows, None, noise.loss, &scales);
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
            let deviations = here.rows.iter().map(|row| row.term.as_ref().map(|term| term.deviation)).collect();
            settled = Some(Settled { scales, deviations });
        }
        let mut trial = here.trial.clone();
        for ((value, part), doubt) in trial.values.iter_mut().zip(step.iter()).zip(&doubts) {
            *value += part * doubt;
        }
        let errors = here.errors.iter().zip(equations.steps(&step)).map(|(error, step)| error + step).collect();
        passes += 1;
        let next = judge.evaluate(trial, errors, settled.as_ref()).ok();
        report(passes, Some(gain))?;
        let better = next.filter(|next| rows::cost(&next.rows, Some(&here.rows), noise.loss, &scales) <= before);
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
    Ok(judge.finish(parameters, here, passes, converged))
}

/// What a trial is judged by.
struct Judge<'a> {
    model: &'a Predictor<'a>,
    runs: &'a [Readings],
    noise: &'a Noise,
    doubts: &'a [f64],
    rests: &'a Rests,
}

impl Judge<'_> {
    fn evaluate(&self, trial: Trial, errors: Vec<f64>, settled: Option<&Settled>) -> Result<Point, DiscretiseError> {
        let Self { model, runs, noise, doubts, rests } = *self;
        let kept = |index: usize| settled.and_then(|settled| settled.deviations.get(index).copied().flatten());
        let predict = |trial: &Trial, derivatives| {
            runs.iter().map(|run| model.predict(run, trial, derivatives)).collect::<Result<Vec<_>, _>>()
        };
        let predictions = predict(&trial, true)?;
        let mut rows: Vec<Row> = Vec::new();
        // A rest's error counts among the residuals of what was read there first.
        let mut owners: Vec<Option<Source>> = vec![None; errors.len()];
        for (r, (run, predicted)) in runs.iter().zip(&predictions).enumerate() {
            for (i, (reading, prediction)) in run.readings.iter().zip(predicted).enumerate() {
                for (quantity, measured) in Quantity::of(reading) {
                    let (predicted, of_it) = (quantity.predicted(prediction), quantity.deviation(noise));
                    let (source, shared) = (quantity.source(), rests.of(r, i));
                    if let Some(owner) = shared.and_then(|shared| owners.get_mut(shared.error())) {
                        owner.get_or_insert(source);
                    }
                    let term = prediction.status.is_trustworthy().then(|| {
                        let by_angle = predicted.per_deg * noise.angle_deg;
                        // A shared error of the angle is not one of each reading.
                        let (own, rest) = match shared {
                            None => (of_it.hypot(by_angle), None),
                            Some(Shared::Own(rest)) => (of_it, Some((rest, by_angle))),
                            Some(Shared::Turn(turn)) => {
                                (of_it.hypot(by_angle), Some((turn, predicted.per_turn_deg * noise.angle_deg)))
                            }
                        };
                        let deviation = kept(rows.len()).unwrap_or(own);
                        let error = rest.and_then(|(rest, by)| Some(by * errors.get(rest)?));
                        let shifted = error.unwrap_or(0.0);
                        let gradient = predicted.gradient.iter().zip(doubts).map(|(g, doubt)| g * doubt / deviation);
                        Term {
                            residual: (measured - predicted.value - shifted) / deviation,
                            gradient: DVector::from_iterator(doubts.len(), gradient),
                            rest: rest.map(|(rest, by)| (rest, by / deviation)),
                            deviation,
                        }
                    });
                    rows.push(Row { source, share: 1.0, term });
                }
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
                    let deviation = noise.outline_mm;
                    let share = (INDEPENDENT_POINTS / points.len() as f64).min(1.0);
                    for &point in points {
                        let away = |prediction: &Prediction| signed_distance(point, &prediction.front_mm);
                        let here = away(&predictions[r][i]);
                        let there: Option<Vec<f64>> = shifted.iter().map(|other| away(&other[r][i])).collect();
                        let term = here.zip(there).map(|(here, there)| Term {
                            // The line moving towards the point is what takes the distance away.
                            residual: here / deviation,
                            gradient: DVector::from_iterator(
                                doubts.len(),
                                there.iter().map(|there| (here - there) / SHIFT / deviation),
                            ),
                            rest: None,
                            deviation,
                        });
                        rows.push(Row { source: Source::Outline, share, term });
                    }
                }
            }
        }
        // An error is as probable as the angle's standard deviation says.
        rows.extend(errors.iter().zip(owners).enumerate().map(|(rest, (error, owner))| {
            let gradient = DVector::zeros(doubts.len());
            let term = Some(Term { residual: -error, gradient, rest: Some((rest, 1.0)), deviation: 1.0 });
            Row { source: owner.unwrap_or(Source::Force), share: 1.0, term }
        }));
        Ok(Point { trial, errors, predictions, rows })
    }

    /// The outcome at the last point.
    fn finish(&self, parameters: &[Parameter], here: Point, passes: usize, converged: bool) -> Fit {
        let Self { model, runs, noise, doubts, rests } = *self;
        let count = parameters.len();
        let scales = rows::spreads(&here.rows, noise.loss);
        // By the stated noise, with every row.
        let equations = rows::normal_equations(&here.rows, Loss::Square, &scales, count, rests.count);
        let eigen = SymmetricEigen::new(equations.of_parameters().0);
        let mut covariance = DMatrix::zeros(count, count);
        let mut beyond = DMatrix::zeros(count, count);
        let mut open = vec![0.0; count];
        let mut undetermined = Vec::new();
        for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
            let vector = vector.into_owned();
            if *value >= 1.0 {
                covariance.ger(1.0 / value, &vector, &vector, 1.0);
                continue;
            }
            // As open as it was before.
            beyond.ger(1.0, &vector, &vector, 1.0);
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
        // A quantity's noise, larger than stated, goes into the parameters as far as its rows have determined them.
        let evidence = rows::evidence(&here.rows, &equations, &covariance, noise.loss, &scales);
        let noises = evidence.all().fold(DMatrix::zeros(count, count), |sum, of| sum + &of.information * of.inflation);
        let covariance = &covariance * noises * &covariance;
        let scatter: Vec<f64> = (0..count).map(|i| covariance[(i, i)].sqrt()).collect();
        let covariance = covariance + beyond;
        let deviation: Vec<f64> = (0..count).map(|i| covariance[(i, i)].sqrt()).collect();
        let estimates: Vec<Estimate> = parameters
            .iter()
            .enumerate()
            .map(|(i, &parameter)| {
                let (value, standard_deviation) = (here.trial.values[i], deviation[i] * doubts[i]);
                // Residuals far above the stated noise can leave more open than there was before; and of a positive quantity, a deviation of
                // its own size says nothing.
                let vague = scatter[i] > 1.0 || (parameter.is_positive() && standard_deviation >= value);
                let determined = open[i] < 0.05 && !vague;
                if vague && open[i] < 0.05 {
                    undetermined.push(Combination { terms: vec![(parameter, standard_deviation)] });
                }
                let start = parameter.start(model.design, model.prony);
                Estimate { parameter, start, value, standard_deviation, determined }
            })
            .collect();
        let correlation = (0..count)
            .map(|i| (0..count).map(|j| covariance[(i, j)] / (deviation[i] * deviation[j])).collect())
            .collect();

        let mut residuals = Vec::new();
        let mut rows = here.rows.iter();
        for (index, (run, predictions)) in runs.iter().zip(&here.predictions).enumerate() {
            for (reading, prediction) in run.readings.iter().zip(predictions) {
                for (quantity, measured) in Quantity::of(reading) {
                    let term = rows.next().and_then(|row| row.term.as_ref());
                    let weight = |term: &Term| noise.loss.of(term.residual / scales.at(quantity.source())).1;
                    residuals.push(Residual {
                        run: index,
                        line: reading.line,
                        angle_deg: reading.angle_deg,
                        quantity,
                        measured,
                        predicted: term.map(|_| quantity.predicted(prediction).value),
                        standard_deviation: term.map_or(quantity.deviation(noise), |term| term.deviation),
                        weight: term.map_or(0.0, weight),
                    });
                }
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
        let inflation = |source| evidence.at(source).inflation.sqrt();
        Fit {
            estimates,
            correlation,
            undetermined,
            residuals,
            outline,
            passes,
            converged,
            inflation: Inflation {
                force: inflation(Source::Force),
                torque: inflation(Source::Torque),
                outline: inflation(Source::Outline),
            },
            trial: here.trial,
        }
    }
}
