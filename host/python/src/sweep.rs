//! Sweeps: a grid of a case's numbers, in parallel.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use fre::files::{Files, Output};
use fre::study::sweep::{self as study, Axis, Ledger, Merge, Progress, Shard, Sweep, SweepError, Tally};
use fre::table::{Column, Kind, Values};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::batch::checked_threads;
use crate::case::Case;
use crate::error::{case_error, of_sweep, value};
use crate::options::Words;

/// Values along one direction of the grid.
#[derive(FromPyObject)]
pub(crate) enum Along {
    /// Of a key.
    Numbers(Vec<f64>),
    /// Resolutions.
    Words(Vec<String>),
}

/// What the file is called that says of which sweep another one is.
const BESIDE: &str = "the file beside out";

/// The axes of a sweep.
fn axes(vary: Vec<(String, Along)>) -> PyResult<Vec<Axis>> {
    let axis = |(key, along): (String, Along)| match along {
        Along::Numbers(values) => Ok(Axis::Key { key: key.replace('[', ".").replace(']', ""), values }),
        Along::Words(words) => {
            let text = format!("{key}={}", words.join(","));
            Axis::parse(&text, fre::study::choice::elements).map_err(|error| of_sweep(&error))
        }
    };
    vary.into_iter().map(axis).collect()
}

/// What the thread that runs a sweep reports, in Python: checked points or rows, done and of how many, and the seconds left.
fn told(py: Python<'_>, progress: Option<&Py<PyAny>>, now: Progress) -> PyResult<()> {
    py.check_signals()?;
    let Some(progress) = progress else { return Ok(()) };
    let (done, total) = now.checked.map_or((now.done, now.total), |[checked, points]| (checked, points));
    progress.call1(py, (now.checked.is_some(), done, total, now.left_s)).map(drop)
}

/// The fields of Python's `Rows`: where the rows of a sweep go, and which.
#[derive(FromPyObject)]
pub(crate) struct RowWords {
    out: Option<PathBuf>,
    parquet: Option<PathBuf>,
    shapes: bool,
    shard: Option<String>,
    points: Option<(usize, usize)>,
}

/// The sweep of a call.
fn sweep_of(
    case: &Case,
    vary: Vec<(String, Along)>,
    angles_deg: Option<Vec<f64>>,
    rows: &RowWords,
    options: Words,
) -> PyResult<Sweep> {
    let (document, options) = ((*case.document()).clone(), options.options()?);
    let sweep = Sweep::new(document, angles_deg.as_deref(), axes(vary)?, options).map_err(|error| of_sweep(&error))?;
    let shard = rows.shard.as_deref().map(|text| {
        let refused = |reason| case_error(format!("shard = \"{text}\": {reason}"), Some("shard"), None);
        text.parse::<Shard>().map_err(refused)
    });
    let points = rows.points.map(|(first, end)| first..end);
    Ok(sweep.only(shard.transpose()?).between(points).with_shapes(rows.shapes))
}

/// Number of points of a sweep, and what says which sweep it is.
#[pyfunction]
pub(crate) fn sweep_identity(
    case: &Case,
    vary: Vec<(String, Along)>,
    angles_deg: Option<Vec<f64>>,
    rows: RowWords,
    options: Words,
) -> PyResult<(usize, String)> {
    let sweep = sweep_of(case, vary, angles_deg, &rows, options)?;
    Ok((sweep.points(), sweep.name()))
}

/// What a column of a sweep holds: number, integer, flag, word or list.
#[pyfunction]
pub(crate) fn column_kind(name: &str) -> &'static str {
    match study::kind(name) {
        Kind::Number | Kind::Single => "number",
        Kind::Integer => "integer",
        Kind::Flag => "flag",
        Kind::Word => "word",
        Kind::List => "list",
    }
}

/// Runs a sweep. Without a file its rows come back as columns; in a file it goes on where it was stopped.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "the arguments of Python's `sweep`, by their names there")]
pub(crate) fn sweep<'py>(
    py: Python<'py>,
    case: &Case,
    vary: Vec<(String, Along)>,
    angles_deg: Option<Vec<f64>>,
    rows: RowWords,
    threads: i64,
    options: Words,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Option<Bound<'py, PyDict>>, Bound<'py, PyDict>)> {
    let threads = checked_threads(threads)?;
    let sweep = sweep_of(case, vary, angles_deg, &rows, options)?;
    let out = rows.out;
    let mut stopped = None;
    let ran = py.detach(|| -> Result<(Tally, Vec<u8>), SweepError> {
        // The Parquet file is made of the rows: it is replaced whenever they are complete.
        let mut files = Files::new(true);
        if let Some(out) = &out {
            files.continued(out, "out")?;
            files.continued(&Ledger::beside(out), BESIDE)?;
        }
        let parquet = rows.parquet.as_deref().map(|path| files.output(path, "parquet")).transpose()?;
        let mut ledger = out.as_deref().map(|path| Ledger::open(path, &sweep)).transpose()?;
        let mut csv = Vec::new();
        let tell = |now: Progress| {
            let went = Python::attach(|py| told(py, progress.as_ref(), now));
            match went {
                Ok(()) => ControlFlow::Continue(()),
                Err(error) => {
                    stopped = Some(error);
                    ControlFlow::Break(())
                }
            }
        };
        let tally = study::run(&sweep, ledger.as_mut(), &mut csv, threads, tell)?;
        if let (Some(rows), Some(parquet)) = (&out, parquet) {
            write_parquet(rows, parquet)?;
        }
        Ok((tally, csv))
    });
    if let Some(stopped) = stopped {
        return Err(stopped);
    }
    let (tally, csv) = ran.map_err(|error| of_sweep(&error))?;
    let columns = if out.is_some() {
        None
    } else {
        let csv = String::from_utf8(csv).map_err(|error| value(error.to_string()))?;
        let table = study::table(&csv).ok_or_else(|| value("the rows of the sweep cannot be read"))?;
        Some(dictionary(py, table.columns)?)
    };
    Ok((columns, counts(py, &tally)?))
}

/// Writes the file of a complete sweep as Parquet.
#[cfg(feature = "parquet")]
fn write_parquet(rows: &Path, parquet: Output) -> Result<(), SweepError> {
    Ok(study::write_parquet(rows, parquet.draft()?)?.finish()?)
}

/// The wheel has Parquet.
#[cfg(not(feature = "parquet"))]
fn write_parquet(_: &Path, _: Output) -> Result<(), SweepError> {
    let reason = "this package was built without Parquet".to_owned();
    Err(SweepError::Part { file: "parquet".to_owned(), reason })
}

/// Makes one file of the files of all shards of a sweep; gives the number of its rows.
#[pyfunction]
pub(crate) fn merge(
    py: Python<'_>,
    shards: Vec<PathBuf>,
    out: PathBuf,
    parquet: Option<PathBuf>,
    overwrite: bool,
) -> PyResult<usize> {
    py.detach(|| {
        let mut files = Files::new(overwrite);
        shards.iter().try_for_each(|shard| files.input(shard, "a shard"))?;
        let rows = files.output(&out, "out")?;
        drop(files.output(&Ledger::beside(&out), BESIDE)?);
        let parquet = parquet.as_deref().map(|path| files.output(path, "parquet")).transpose()?;
        let merge = Merge::of(&shards)?;
        let mut draft = rows.draft()?;
        let count = merge.write(&mut draft)?.rows;
        draft.finish()?;
        merge.name(&out)?;
        if let Some(parquet) = parquet {
            write_parquet(&out, parquet)?;
        }
        Ok(count)
    })
    .map_err(|error: SweepError| of_sweep(&error))
}

/// Columns as a dictionary of arrays, by their names.
pub(crate) fn dictionary(py: Python<'_>, columns: Vec<Column>) -> PyResult<Bound<'_, PyDict>> {
    let dictionary = PyDict::new(py);
    for Column { name, values } in columns {
        let array = match values {
            Values::Number(values) => PyArray1::from_vec(py, values).into_any(),
            Values::Single(values) => PyArray1::from_vec(py, values).into_any(),
            Values::Integer(values) if values.iter().all(Option::is_some) => {
                PyArray1::from_iter(py, values.into_iter().flatten()).into_any()
            }
            Values::Integer(values) => {
                PyArray1::from_iter(py, values.into_iter().map(|value| value.map_or(f64::NAN, |value| value as f64)))
                    .into_any()
            }
            Values::Flag(values) => PyList::new(py, values)?.into_any(),
            Values::Word(values) => PyList::new(py, values)?.into_any(),
            Values::List(values) => {
                PyList::new(py, values.into_iter().map(|list| PyArray1::from_vec(py, list)))?.into_any()
            }
        };
        dictionary.set_item(name, array)?;
    }
    Ok(dictionary)
}

/// What came of a sweep.
fn counts<'py>(py: Python<'py>, tally: &Tally) -> PyResult<Bound<'py, PyDict>> {
    let statuses = PyDict::new(py);
    for (word, count) in &tally.statuses {
        statuses.set_item(word, count)?;
    }
    let dictionary = PyDict::new(py);
    dictionary.set_item("statuses", statuses)?;
    dictionary.set_item("failures", tally.failures.iter().map(|(row, _)| *row).collect::<Vec<_>>())?;
    dictionary.set_item("computed", tally.computed)?;
    dictionary.set_item("resumed", tally.resumed)?;
    Ok(dictionary)
}
