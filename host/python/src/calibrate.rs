//! The model's parameters from measurements.

use std::path::PathBuf;
use std::sync::Arc;

use fre::case::Document;
use fre::draw;
use fre::fit::calibrate::{
    FitError, Input, InputError, Loss, Noise, Parameter, Predictor, Reading, Readings, document, fit_watched,
    fitted_finger, picture, text,
};
use fre::study::model::Precision;
use model_core::drive::Drive;
use pyo3::prelude::*;

use crate::case::Case;
use crate::error::{case_error, of_discretise, of_measured, value};
use crate::options::{Words, word};
use crate::signals::{Signals, stopped};

/// The fields of Python's `Noise`.
#[derive(FromPyObject)]
pub(crate) struct NoiseWords {
    force_sd_n: f64,
    torque_sd_nmm: Option<f64>,
    angle_sd_deg: Option<f64>,
    outline_sd_mm: f64,
    loss: String,
}

impl NoiseWords {
    fn noise(&self) -> PyResult<Noise> {
        let default = Noise::default();
        let positive = |key: &str, found: f64| {
            let refused = || case_error(format!("{key} = {found}: allowed is above 0, up to 1000"), Some(key), None);
            (found > 0.0 && found <= 1000.0).then_some(found).ok_or_else(refused)
        };
        let losses = [("huber", Loss::Huber), ("tukey", Loss::Tukey), ("square", Loss::Square)];
        Ok(Noise {
            force_n: positive("force_sd_n", self.force_sd_n)?,
            torque_nmm: positive("torque_sd_nmm", self.torque_sd_nmm.unwrap_or(default.torque_nmm))?,
            angle_deg: positive("angle_sd_deg", self.angle_sd_deg.unwrap_or(default.angle_deg))?,
            outline_mm: positive("outline_sd_mm", self.outline_sd_mm)?,
            loss: word("loss", &self.loss, &losses)?,
        })
    }
}

/// Measurements with their cases.
fn input(
    measurements: &[PathBuf],
    documents: &[Arc<Document>],
    noise: &NoiseWords,
    both_ways: bool,
) -> PyResult<Input> {
    let named = documents.iter().enumerate().map(|(index, document)| {
        let name = if documents.len() == 1 { "the case".to_owned() } else { format!("case {index}") };
        (name, (**document).clone())
    });
    let input = Input::of(measurements, named.collect(), both_ways, Drive::Rotating);
    let with_torques = noise.torque_sd_nmm.is_some();
    let input = input.and_then(|input| if with_torques { Ok(input) } else { input.without_torques() });
    input.map_err(|error| match error {
        InputError::Measured(error) => of_measured(&error),
        error @ InputError::NoFiles => case_error(format!("measurements: {error}"), Some("measurements"), None),
        error => value(error.to_string()),
    })
}

/// Lets each reading count as often as it was drawn, by its number through all runs. The finger passes the places of all others as well: with
/// friction a force depends on the way there.
fn draw_readings(runs: &mut [Readings], drawn: &[usize]) {
    let mut counts = vec![0; runs.iter().map(|run| run.readings.len()).sum()];
    for &number in drawn {
        if let Some(count) = counts.get_mut(number) {
            *count += 1;
        }
    }
    let mut counts = counts.into_iter();
    for run in runs {
        let readings = std::mem::take(&mut run.readings).into_iter().zip(&mut counts);
        run.readings = readings
            .flat_map(|(reading, count)| match count {
                0 => vec![Reading { force_n: None, torque_nmm: None, front_mm: Vec::new(), ..reading }],
                count => vec![reading; count],
            })
            .collect();
    }
}

/// Number of the readings from which a bootstrap draws.
#[pyfunction]
pub(crate) fn count_readings(
    py: Python<'_>,
    measurements: Vec<PathBuf>,
    cases: Vec<PyRef<'_, Case>>,
    noise: NoiseWords,
    both_ways: bool,
) -> PyResult<usize> {
    if cases.iter().any(|case| !case.case.finger.prony.is_empty()) {
        let key = "finger.material.prony";
        let message = format!(
            "{key}: a bootstrap draws each reading without regard to the others, but with memory each depends on those before it; allowed is an \
             elastic material"
        );
        return Err(case_error(message, Some(key), None));
    }
    let documents: Vec<Arc<Document>> = cases.iter().map(|case| case.document()).collect();
    py.detach(|| {
        let input = input(&measurements, &documents, &noise, both_ways)?;
        Ok(input.runs.iter().map(|run| run.readings.len()).sum())
    })
}

/// Fits parameters, to some of the readings if they are drawn; gives the JSON of `fre calibrate`, its text, the fitted finger's file and a
/// picture.
#[pyfunction]
#[pyo3(signature = (measurements, cases, parameters, noise, both_ways, options, drawn = None))]
#[expect(clippy::too_many_arguments, reason = "the arguments of Python's `calibrate`, by their names there")]
pub(crate) fn calibrate(
    py: Python<'_>,
    measurements: Vec<PathBuf>,
    cases: Vec<PyRef<'_, Case>>,
    parameters: Vec<String>,
    noise: NoiseWords,
    both_ways: bool,
    options: Words,
    drawn: Option<Vec<usize>>,
) -> PyResult<(String, String, String, String)> {
    let options = options.options()?;
    if options.precision != Precision::F64 {
        return Err(case_error("precision = \"f32\": a fit needs f64", Some("precision"), None));
    }
    let deviations = noise.noise()?;
    let words: Vec<(&str, Parameter)> = Parameter::ALL.map(|parameter| (parameter.word(), parameter)).to_vec();
    let parameters = parameters.iter().map(|found| word("fit", found, &words)).collect::<PyResult<Vec<Parameter>>>()?;
    let documents: Vec<Arc<Document>> = cases.iter().map(|case| case.document()).collect();
    py.detach(|| {
        let mut input = input(&measurements, &documents, &noise, both_ways)?;
        if let Some(drawn) = drawn {
            draw_readings(&mut input.runs, &drawn);
        }
        let design = &input.finger.design;
        for (index, parameter) in parameters.iter().enumerate() {
            if parameters[..index].contains(parameter) {
                return Err(case_error(format!("fit names {} twice", parameter.word()), Some("fit"), None));
            }
            if let Some(obstacle) = parameter.obstacle(design, &input.finger.prony, &input.objects, &input.drive) {
                return Err(case_error(format!("fit {}: {obstacle}", parameter.word()), Some("fit"), None));
            }
        }
        let (discretisation, drive, prony) = (options.discretisation, input.drive, input.finger.prony.as_slice());
        let model = Predictor { design, discretisation, drive, prony };
        let mut signals = Signals::new();
        let found = fit_watched(&model, &input.runs, &parameters, &deviations, |_| signals.look());
        let found = signals.or(found.map_err(|error| match error {
            FitError::Discretise(error) => of_discretise(&error),
            FitError::Stopped(()) => stopped(),
            error @ FitError::NoParameters => case_error(format!("fit: {error}"), Some("fit"), None),
        }))?;
        let json = document(&input, &found).to_string();
        let scene = picture(&input.finger.name, &input.runs, &found);
        Ok((json, text(&input, &found), fitted_finger(&input, &found), draw::svg(&scene)))
    })
}
