//! A case on its way: it goes wherever it is sent, from where it is.

use std::sync::Arc;

use fre::study::branch::next_branch;
use fre::study::json::Row;
use fre::study::model::{Model, Options, Precision};
use fre::study::overlap;
use fre::study::place::Place;
use fre::study::run::{Run, Walk};
use fre::study::warnings::warnings;
use pyo3::prelude::*;

use crate::case::Case;
use crate::error::{case_error, of_discretise, value};
use crate::options::Words;

enum Walking {
    Single(Box<Walk<f32>>),
    Double(Box<Walk<f64>>),
}

/// A follower of a case.
#[pyclass(module = "fre._core")]
pub(crate) struct Follower {
    walking: Walking,
    case: Arc<fre::case::Case>,
    model: Model,
    options: Options,
    branch: Option<u32>,
    /// Time that has passed, s; none before any has.
    time_s: Option<f64>,
}

#[pymethods]
impl Follower {
    #[new]
    fn new(case: &Case, options: Words) -> PyResult<Self> {
        let options = options.options()?;
        let case = case.case.clone();
        let (walking, model) = match options.precision {
            Precision::F32 => {
                let walk = Walk::begin(&case, &options).map_err(|error| of_discretise(&error))?;
                let model = walk.model();
                (Walking::Single(Box::new(walk)), model)
            }
            Precision::F64 => {
                let walk = Walk::begin(&case, &options).map_err(|error| of_discretise(&error))?;
                let model = walk.model();
                (Walking::Double(Box::new(walk)), model)
            }
        };
        Ok(Self { walking, case, model, options, branch: Some(1), time_s: None })
    }

    /// Goes to a motor angle (degrees) or distance (mm) within a time, s; the JSON of the place.
    #[pyo3(signature = (to, dt_s = None))]
    fn follow(&mut self, py: Python<'_>, to: f64, dt_s: Option<f64>) -> PyResult<String> {
        let most = if self.case.path.unit() == "°" { fre::case::MAX_ANGLE } else { fre::case::MAX_DISTANCE };
        if to.is_nan() || to.abs() > most {
            return Err(case_error(format!("to = {to}: allowed is {} to {most}", -most), Some("to"), None));
        }
        let seconds = dt_s.unwrap_or(0.0);
        if !(0.0..=fre::case::MAX_TIME).contains(&seconds) {
            let reason = format!("dt_s = {seconds}: allowed is 0 to {:e}", fre::case::MAX_TIME);
            return Err(case_error(reason, Some("dt_s"), None));
        }
        if dt_s.is_some() {
            self.time_s = Some(self.time_s.unwrap_or(0.0) + seconds);
        }
        py.detach(|| {
            let (mut place, snaps): (Place, u32) = match &mut self.walking {
                Walking::Single(walk) => walk.go(to, seconds),
                Walking::Double(walk) => walk.go(to, seconds),
            };
            self.branch = next_branch(self.branch, place.status, snaps);
            place.branch = self.branch;
            place.time_s = self.time_s;
            place.overlap_mm = overlap::depth(&self.case, &place);
            let places = vec![place];
            let run = Run {
                model: self.model,
                first_branch: None,
                warnings: warnings(&self.case, &self.options, &places),
                places,
            };
            serde_json::to_string(&Row::new(&run, &run.places[0])).map_err(|error| value(error.to_string()))
        })
    }
}
