//! Reports of a gripper or a bus, as Python takes them.

use std::time::{Duration, Instant};

use fre_gripper::record::{COLUMNS, Cell};
use fre_gripper::source::Told;
use messages::{Grasp, Report};
use pyo3::prelude::*;
use pyo3::types::{PyFloat, PyInt, PyString, PyTuple};

use crate::error::case_error;

/// A report's columns, in their order.
fn cells<'py>(py: Python<'py>, report: &Report) -> PyResult<Bound<'py, PyTuple>> {
    let cell = |(_, of): &(&str, fn(&Report) -> Cell)| match of(report) {
        Cell::Integer(value) => PyInt::new(py, value).into_any(),
        Cell::Number(value) => PyFloat::new(py, value.into()).into_any(),
        Cell::Word(word) => PyString::intern(py, word).into_any(),
    };
    PyTuple::new(py, COLUMNS.iter().map(cell))
}

/// A grasp as three tuples: its own numbers, those of a free object (its status first), and the margin's. `None` takes the place of what a grasp
/// does not have.
fn grasp<'py>(py: Python<'py>, grasp: &Grasp) -> PyResult<Bound<'py, PyAny>> {
    let [sum_x, sum_y] = grasp.sum;
    let own = (grasp.sequence, grasp.is_trustworthy, sum_x, sum_y, grasp.squeeze, grasp.balance);
    let free = grasp.free.map(|free| {
        let [x, y] = free.shift;
        (free.status.word(), x, y, free.turn.to_degrees(), free.residual)
    });
    let margin = grasp.margin.map(|margin| {
        let direction = margin.direction.to_degrees();
        (margin.least, direction, margin.across, margin.couple, margin.slips, margin.carried, margin.age)
    });
    Ok((own, free, margin).into_pyobject(py)?.into_any())
}

/// When so many seconds are over; none if that is farther away than a clock goes, or infinitely far.
pub(crate) fn deadline(key: &str, seconds: f64) -> PyResult<Option<Instant>> {
    if seconds.is_nan() || seconds < 0.0 {
        return Err(case_error(format!("{key} = {seconds}: allowed is 0 and more"), Some(key), None));
    }
    Ok(Duration::try_from_secs_f64(seconds).ok().and_then(|wait| Instant::now().checked_add(wait)))
}

/// A report, an event as its time (µs) and its words, or a grasp as its own, a free object's and the margin's numbers; none of what Python does
/// not take.
pub(crate) fn python<'py>(py: Python<'py>, told: &Told) -> PyResult<Option<Bound<'py, PyAny>>> {
    Ok(Some(match told {
        Told::Report(report) => cells(py, report)?.into_any(),
        Told::Event(notice) => (notice.time_us, notice.event.to_string()).into_pyobject(py)?.into_any(),
        Told::Grasp(of) => grasp(py, of)?,
        Told::Shape(_) | Told::Setup(_) => return Ok(None),
    }))
}
