//! Recordings.

use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::PyDict;

#[cfg(not(feature = "record"))]
use crate::error::system;

/// Reads a recording: its reports as columns, its events, its set-up as JSON, and what is missing of it.
#[pyfunction]
pub(crate) fn read_recording(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyDict>> {
    #[cfg(feature = "record")]
    return inside::read(py, path);
    #[cfg(not(feature = "record"))]
    {
        // Nothing is made of it here.
        let _ = py;
        Err(system(&format!("{}: this package was built without recordings", path.display())))
    }
}

#[cfg(feature = "record")]
mod inside {
    use std::path::PathBuf;

    use fre::table::{Column, Values};
    use fre_gripper::record::{RecordError, Recorded, Recording, ReportTable, beginning};
    use fre_gripper::source::{Setup, Told};
    use pyo3::prelude::*;
    use pyo3::types::PyDict;

    use crate::error::{of_file, system};
    use crate::sweep::dictionary;

    /// What a recording holds.
    struct Read {
        setup: Setup,
        columns: Vec<Column>,
        events: Vec<(u64, String)>,
        missing: u64,
        damages: Vec<String>,
        is_cut: bool,
    }

    fn refused(error: &RecordError) -> PyErr {
        match error {
            RecordError::File { source, .. } => of_file(source.kind(), error.to_string()),
            error => system(error),
        }
    }

    fn whole(path: PathBuf) -> PyResult<Read> {
        let mut recording = Recording::open(&path).map_err(|error| refused(&error))?;
        let setup = beginning(&path, &mut recording).map_err(|error| system(&error))?;
        let mut times = Vec::new();
        let mut reports = ReportTable::default();
        let (mut events, mut damages, mut missing) = (Vec::new(), Vec::new(), 0);
        for recorded in recording.by_ref() {
            let (ns, recorded) = recorded.map_err(|error| refused(&error))?;
            match recorded {
                Recorded::Told(Told::Report(report)) => {
                    times.push(Some(ns as i64));
                    reports.take(&report);
                }
                Recorded::Told(Told::Event(notice)) => events.push((notice.time_us, notice.event.to_string())),
                Recorded::Told(_) => {}
                Recorded::Gap(gap) => missing += u64::from(gap.missing),
                Recorded::Damage(damage) => damages.push(damage.to_string()),
            }
        }
        let mut columns = reports.into_table().columns;
        columns.push(Column { name: "log_time_ns".to_owned(), values: Values::Integer(times) });
        Ok(Read { setup, columns, events, missing, damages, is_cut: recording.is_cut() })
    }

    pub(super) fn read(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyDict>> {
        let read = py.detach(|| whole(path))?;
        let found = PyDict::new(py);
        let setup = serde_json::to_string(&read.setup).map_err(|error| system(&error))?;
        found.set_item("setup", setup)?;
        found.set_item("reports", dictionary(py, read.columns)?)?;
        found.set_item("events", read.events)?;
        found.set_item("missing", read.missing)?;
        found.set_item("damages", read.damages)?;
        found.set_item("is_cut", read.is_cut)?;
        Ok(found)
    }
}
