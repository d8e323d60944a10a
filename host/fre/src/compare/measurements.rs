//! A case against measurements.

use std::ops::ControlFlow;
use std::path::Path;

use super::comparison::{Comparison, Reference, Row};
use super::error::CompareError;
use super::notes::doubts;
use super::order::Order;
use super::outlying::{mark_outliers, outlying_points};
use super::pictures::residual_chart;
use crate::case::Case;
use crate::fit::measured::Measured;
use crate::study::model::Options;
use crate::study::run::{self, Progress};

/// Compares a case with the measurements of a file. The measured places, in the given order, replace those of the case.
///
/// # Errors
/// The file has another coordinate than the case's motion, or the finger cannot be discretised as asked.
pub fn with_measurements(
    case: &mut Case,
    options: &Options,
    measured: &Measured,
    file: &Path,
    order: Order,
) -> Result<Comparison, CompareError> {
    with_measurements_watched(case, options, measured, file, order, |_| ControlFlow::Continue(()))
}

/// As [`with_measurements`], calling `watch` after every place that is solved; it stops the work by [`ControlFlow::Break`].
///
/// # Errors
/// As there, or the work was stopped.
pub fn with_measurements_watched(
    case: &mut Case,
    options: &Options,
    measured: &Measured,
    file: &Path,
    order: Order,
    watch: impl FnMut(Progress<'_>) -> ControlFlow<()>,
) -> Result<Comparison, CompareError> {
    case.refuse_memory("a comparison with measurements").map_err(CompareError::Memory)?;
    let needed = case.path.along();
    if measured.coordinate != needed {
        let (found, needed) = (measured.coordinate.column(), needed.column());
        return Err(CompareError::Coordinate { file: file.display().to_string(), found, needed });
    }
    let measurements = match order {
        Order::Closing => measured.closing(),
        Order::File => measured.visits(),
    };
    if measurements.is_empty() {
        return Err(CompareError::TorquesAlone { file: file.display().to_string() });
    }
    case.path.set_places(measurements.iter().map(|m| m.place).collect());
    let run = run::solve_watched(case, options, watch)?;
    let mut rows: Vec<Row> = run.places.iter().zip(&measurements).map(|(place, m)| Row::measured(place, m)).collect();
    mark_outliers(&mut rows);
    for (row, (place, measurement)) in rows.iter_mut().zip(run.places.iter().zip(&measurements)) {
        row.outlying_points = outlying_points(measurement, place.front_mm());
        row.leave_outliers_out(place, measurement);
    }
    let picture = rows.iter().any(|row| row.difference_n.is_some()).then(|| residual_chart(case, &rows));
    let left_out = measured.problems.iter().map(|problem| format!("{}:{problem}", file.display())).collect();
    let mut notes = doubts(order, case, measured, &measurements, &rows);
    notes.extend(run.warnings.iter().map(ToString::to_string));
    let model_seconds = run.seconds();
    Ok(Comparison { reference: Reference::Measured, rows, model_seconds, fea: None, notes, left_out, picture })
}
