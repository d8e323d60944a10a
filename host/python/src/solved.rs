//! A solved case.

use std::ops::ControlFlow;
use std::sync::OnceLock;

use fre::draw;
use fre::study::json::Row;
use fre::study::model::Options;
use fre::study::pictures::{self, Kind};
use fre::study::run::{self, Run, Unsolved};
use fre::study::{csv, json, text};
use numpy::{PyArray1, PyArray2};
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;

use crate::case::Case;
use crate::error::{of_discretise, value};
use crate::options::{Words, word};
use crate::signals::{Signals, stopped};

/// A case's results, one per place of its motion.
#[pyclass(frozen, module = "fre._core")]
pub(crate) struct Solved {
    case: Case,
    options: Options,
    /// The results as they were read from their JSON, if they were.
    read: Option<Vec<Row>>,
    /// The results themselves; of those that were read, once they are drawn.
    run: OnceLock<Run>,
}

fn solved(case: &Case, options: &Options, mut look: impl FnMut() -> ControlFlow<()>) -> PyResult<Run> {
    run::solve_watched(&case.case, options, |_| look()).map_err(|error| match error {
        Unsolved::Discretise(error) => of_discretise(&error),
        Unsolved::Stopped(()) => stopped(),
    })
}

impl Solved {
    /// Solves a case, looking after every place whether to go on.
    pub(crate) fn of(case: Case, options: &Options, look: impl FnMut() -> ControlFlow<()>) -> PyResult<Self> {
        let run = solved(&case, options, look)?;
        Ok(Self { case, options: *options, read: None, run: run.into() })
    }

    /// The results; solved again if they were read from a file: what draws them needs more than their JSON has.
    fn run(&self) -> PyResult<&Run> {
        if let Some(run) = self.run.get() {
            return Ok(run);
        }
        let mut signals = Signals::new();
        let run = solved(&self.case, &self.options, || signals.look());
        let run = signals.or(run)?;
        Ok(self.run.get_or_init(|| run))
    }

    /// A value of every place, by its JSON.
    fn each<X>(&self, of: impl Fn(&Row) -> X) -> PyResult<Vec<X>> {
        if let Some(rows) = &self.read {
            return Ok(rows.iter().map(of).collect());
        }
        let run = self.run()?;
        Ok(run.places.iter().map(|place| of(&Row::new(run, place))).collect())
    }

    fn column<'py>(&self, py: Python<'py>, of: impl Fn(&Row) -> Option<f64>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(PyArray1::from_vec(py, self.each(|row| of(row).unwrap_or(f64::NAN))?))
    }

    fn pairs<'py>(
        &self,
        py: Python<'py>,
        of: impl Fn(&Row) -> Option<[f64; 2]>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let rows = self.each(|row| of(row).unwrap_or([f64::NAN; 2]).to_vec())?;
        PyArray2::from_vec2(py, &rows).map_err(|error| value(error.to_string()))
    }
}

#[pymethods]
impl Solved {
    /// A solved case from the JSON of its results, as [`Self::json`] has written it.
    #[staticmethod]
    fn from_json(case: &Case, options: Words, text: &str) -> PyResult<Self> {
        let rows = serde_json::from_str(text).map_err(|error| value(error.to_string()))?;
        Ok(Self { case: case.clone(), options: options.options()?, read: Some(rows), run: OnceLock::new() })
    }

    /// The case.
    fn case(&self) -> Case {
        self.case.clone()
    }

    /// Number of places.
    fn __len__(&self) -> usize {
        self.case.case.path.places.len()
    }

    /// The JSON of all places.
    fn json(&self) -> PyResult<String> {
        match &self.read {
            Some(rows) => json::text(rows),
            None => json::json(self.run()?),
        }
        .map_err(|error| value(error.to_string()))
    }

    /// The JSON of one place.
    fn place_json(&self, index: usize) -> PyResult<String> {
        let none = || PyIndexError::new_err("no such place");
        match &self.read {
            Some(rows) => serde_json::to_string(rows.get(index).ok_or_else(none)?),
            None => {
                let run = self.run()?;
                serde_json::to_string(&Row::new(run, run.places.get(index).ok_or_else(none)?))
            }
        }
        .map_err(|error| value(error.to_string()))
    }

    /// The table of `fre solve`.
    fn text(&self) -> PyResult<String> {
        Ok(text::text(&self.case.case, self.run()?))
    }

    /// The CSV of `fre solve`.
    fn csv(&self) -> PyResult<String> {
        Ok(csv::csv(self.run()?))
    }

    /// What a person should know of these results.
    fn warnings(&self) -> PyResult<Vec<String>> {
        Ok(self.run()?.warnings.iter().map(ToString::to_string).collect())
    }

    /// The statuses' words.
    fn statuses(&self) -> PyResult<Vec<&'static str>> {
        self.each(|row| row.status.word())
    }

    /// Motor angles in degrees or distances in mm.
    fn places<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.case.case.path.places)
    }

    /// Times since the motion began, s.
    fn time_s<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.column(py, |row| row.time_s)
    }

    /// Forces on the object, world frame, N: a row per place.
    fn force_n<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.pairs(py, |row| row.force_n)
    }

    /// Their magnitudes, N.
    fn force_magnitude_n<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.column(py, |row| row.force_magnitude_n)
    }

    /// Torques demanded of the motor, N·mm.
    fn motor_torque_nmm<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.column(py, |row| row.motor_torque_nmm)
    }

    /// Elastic energies, N·mm.
    fn energy_nmm<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.column(py, |row| row.energy_nmm)
    }

    /// Tips, finger frame, mm: a row per place.
    fn tip_mm<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        self.pairs(py, |row| row.tip_mm)
    }

    /// A picture: as `fre solve --plot` draws it, or of kinds one below the other, at a place.
    #[pyo3(signature = (kinds, at = None))]
    fn svg(&self, py: Python<'_>, kinds: Vec<String>, at: Option<usize>) -> PyResult<Option<String>> {
        let all = [
            ("finger", Kind::Finger),
            ("force", Kind::Force),
            ("loop", Kind::Loop),
            ("pressure", Kind::Pressure),
            ("strain", Kind::Strain),
        ];
        let kinds = kinds.iter().map(|kind| word("kind", kind, &all)).collect::<PyResult<Vec<Kind>>>()?;
        py.detach(|| {
            let (case, run) = (&self.case.case, self.run()?);
            let scene = match (at, run.last_known()) {
                (None, _) if kinds.is_empty() => pictures::overview(case, run),
                (Some(at), _) if kinds.is_empty() => pictures::stacked(case, run, at, &[Kind::Finger]),
                (Some(at), _) | (None, Some(at)) => pictures::stacked(case, run, at, &kinds),
                (None, None) => None,
            };
            Ok(scene.map(|scene| draw::svg(&scene)))
        })
    }
}

/// Solves a case.
#[pyfunction]
pub(crate) fn solve(py: Python<'_>, case: &Case, options: Words) -> PyResult<Solved> {
    let options = options.options()?;
    let case = case.clone();
    py.detach(|| {
        let mut signals = Signals::new();
        let solved = Solved::of(case, &options, || signals.look());
        signals.or(solved)
    })
}
