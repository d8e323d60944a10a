//! Errors as Python's: `CaseError`, a `ValueError` that knows its key, for input; `OSError` for files that cannot be read or written and for links.

use std::io::ErrorKind;

use fre::fit::measured::MeasuredError;
use fre::study::sweep::SweepError;
use model_core::discretise::DiscretiseError;
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyString;

pyo3::create_exception!(
    fre,
    CaseError,
    PyValueError,
    "Input that cannot be used. `key` is the key at fault with its tables, `line` its line; None where there is none."
);

/// Stands for the file of a case that was not read from one.
pub(crate) const UNNAMED: &str = "case";

/// Gives every `CaseError`, also one that Python code raises, the attributes that handlers read.
pub(crate) fn set_defaults(py: Python<'_>) -> PyResult<()> {
    let class = py.get_type::<CaseError>();
    class.setattr("key", py.None())?;
    class.setattr("line", py.None())
}

/// The error of a key, which its message names.
pub(crate) fn case_error(message: impl Into<String>, key: Option<&str>, line: Option<usize>) -> PyErr {
    Python::attach(|py| {
        let error = CaseError::new_err(message.into());
        let value = error.value(py);
        // An exception takes attributes.
        let _ = value.setattr("key", key.map(|key| PyString::new(py, key)));
        let _ = value.setattr("line", line);
        error
    })
}

/// The error of a case. What was not read from a file has no line to name. One of a file that cannot be read is the system's.
pub(crate) fn of_case(error: &fre::case::CaseError, in_file: bool) -> PyErr {
    let words = error.to_string();
    if let fre::case::CaseError::Unreadable { kind, .. } = error {
        return of_file(*kind, words);
    }
    if in_file {
        return case_error(words, error.key(), error.line());
    }
    let place = |file: &str, line: usize| format!("{file}:{line}: ");
    let start = error.line().map(|line| place(UNNAMED, line));
    let words = start.and_then(|start| words.strip_prefix(&start)).unwrap_or(&words);
    case_error(words, error.key(), None)
}

/// The error of options that do not fit the finger.
pub(crate) fn of_discretise(error: &DiscretiseError) -> PyErr {
    match error {
        DiscretiseError::Design(error) => case_error(format!("finger.{error}"), Some("finger"), None),
        DiscretiseError::TooFewElements { .. } => case_error(error.to_string(), Some("elements"), None),
        DiscretiseError::Samples { .. } => case_error(error.to_string(), Some("samples"), None),
        DiscretiseError::Softness { found } => {
            let message = format!("softness_mm_per_n is {found}; allowed is 0 to 1");
            case_error(message, Some("softness_mm_per_n"), None)
        }
        DiscretiseError::Capacity => case_error(error.to_string(), None, None),
    }
}

/// The error of a sweep.
pub(crate) fn of_sweep(error: &SweepError) -> PyErr {
    match error {
        SweepError::Case(error) => case_error(error.without_place(), error.key(), None),
        SweepError::File { source, .. } => of_file(source.kind(), error.to_string()),
        SweepError::Files(_)
        | SweepError::Part { .. }
        | SweepError::Incomplete { .. }
        | SweepError::Foreign { .. }
        | SweepError::NoFile { .. }
        | SweepError::Unsorted { .. }
        | SweepError::Busy { .. } => PyOSError::new_err(error.to_string()),
        error => {
            let key = match error {
                SweepError::Point { key, .. } => key.as_deref(),
                SweepError::Key(error) => Some(error.key()),
                SweepError::Twice { key } => Some(key.as_str()),
                SweepError::Within { part, .. } => Some(part.as_str()),
                SweepError::Vary { text, .. } => text.split_once('=').map(|(key, _)| key),
                SweepError::Translating => Some("angles_deg"),
                _ => None,
            };
            let words = error.to_string().replace("--vary", "vary").replace("--angles", "angles_deg");
            case_error(words, key, None)
        }
    }
}

/// A `ValueError`.
pub(crate) fn value(message: impl Into<String>) -> PyErr {
    case_error(message, None, None)
}

/// The error of a file: `FileNotFoundError` of one that is missing, another `OSError` else.
pub(crate) fn of_file(kind: ErrorKind, message: String) -> PyErr {
    std::io::Error::new(kind, message).into()
}

/// The error of measurements.
pub(crate) fn of_measured(error: &MeasuredError) -> PyErr {
    match error {
        MeasuredError::Unreadable { source, .. } => of_file(source.kind(), error.to_string()),
        error => value(error.to_string()),
    }
}

/// An `OSError`.
pub(crate) fn system(error: &dyn std::fmt::Display) -> PyErr {
    PyOSError::new_err(error.to_string())
}
