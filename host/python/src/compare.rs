//! A case against finite elements or measurements.

use std::path::PathBuf;

use fre::compare::{CompareError, Comparison, Order, with_elements_watched, with_measurements_watched};
use fre::draw;
use fre::fit::measured::Measured;
use fre::study::run::Progress;
use pyo3::prelude::*;

use crate::case::Case;
use crate::error::{of_discretise, of_measured, system, value};
use crate::options::{Words, word};
use crate::signals::{Signals, stopped};

/// JSON, text and picture of a comparison.
type Compared = (String, String, Option<String>);

fn written(case: &fre::case::Case, comparison: Comparison) -> PyResult<Compared> {
    let json = comparison.json().map_err(|error| value(error.to_string()))?;
    Ok((json, comparison.text(case), comparison.picture.as_ref().map(draw::svg)))
}

fn refused(error: CompareError) -> PyErr {
    match error {
        CompareError::Discretise(error) => of_discretise(&error),
        CompareError::Fea(error) => system(&error),
        CompareError::Stopped => stopped(),
        error => value(error.to_string()),
    }
}

/// Compares a case with a file of measurements.
#[pyfunction]
pub(crate) fn compare_measured(
    py: Python<'_>,
    case: &Case,
    file: PathBuf,
    order: &str,
    options: Words,
) -> PyResult<Compared> {
    let order = word("order", order, &[("closing", Order::Closing), ("file", Order::File)])?;
    let options = options.options()?;
    let mut case = (*case.case).clone();
    py.detach(|| {
        let measured = Measured::read(&file).map_err(|error| of_measured(&error))?;
        let mut signals = Signals::new();
        let look = |_: Progress<'_>| signals.look();
        let compared = with_measurements_watched(&mut case, &options, &measured, &file, order, look).map_err(refused);
        written(&case, signals.or(compared)?)
    })
}

/// Compares a case with finite elements; CalculiX' files go into a folder.
#[pyfunction]
pub(crate) fn compare_elements(
    py: Python<'_>,
    case: &Case,
    folder: PathBuf,
    mesh: usize,
    options: Words,
) -> PyResult<Compared> {
    let options = options.options()?;
    let case = case.case.clone();
    py.detach(|| {
        // Ctrl-C ends CalculiX, too.
        let mut signals = Signals::new();
        let compared = with_elements_watched(&case, &options, mesh, &folder, |_| signals.look()).map_err(refused);
        written(&case, signals.or(compared)?)
    })
}
