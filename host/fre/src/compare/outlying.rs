//! Readings and points of an outline that lie far from the model, compared with the others.

use super::comparison::{OutlyingPoint, Reading, Row};
use crate::fit::measured::{Measurement, outliers};
use crate::metrics::{Point, distance};

/// Part of the largest reference force below which forces are not distinguished: a load cell's accuracy.
pub(super) const LEAST_FORCE: f64 = 0.01;
/// The same of an outline's points, mm.
const LEAST_DISTANCE: f64 = 0.05;

/// Marks readings whose residual lies far from the others'.
pub(super) fn mark_outliers(rows: &mut [Row]) {
    let most = rows.iter().flat_map(|row| &row.readings).map(|reading| reading.force_n).fold(0.0, f64::max);
    let mut known: Vec<&mut Reading> =
        rows.iter_mut().flat_map(|row| &mut row.readings).filter(|reading| reading.difference_n.is_some()).collect();
    let residuals: Vec<f64> = known.iter().filter_map(|reading| reading.difference_n).collect();
    for index in outliers(&residuals, LEAST_FORCE * most) {
        known[index].outlier = true;
    }
    for row in rows {
        row.outlier = row.readings.iter().any(|reading| reading.outlier);
    }
}

/// Points much farther from the model's line, or nearer to it, than the two before and the two behind them: a wrong digit, not a
/// wrong shape. The outermost two of an outline have too few beside them to tell.
pub(super) fn outlying_points(measurement: &Measurement, line: &[Point]) -> Vec<OutlyingPoint> {
    let distances: Vec<f64> = measurement.front.iter().map_while(|&point| distance(point, line)).collect();
    let mut steps = vec![0.0; distances.len()];
    for outline in measurement.outlines() {
        let Some(of_one) = distances.get(outline.clone()) else { break };
        for (index, near) in of_one.windows(5).enumerate() {
            let mut sorted = near.to_vec();
            sorted.sort_by(f64::total_cmp);
            steps[outline.start + index + 2] = near[2] - sorted[2];
        }
    }
    let far = outliers(&steps, LEAST_DISTANCE).into_iter();
    far.filter_map(|index| {
        let (&line, &point_mm) = (measurement.front_lines.get(index)?, measurement.front.get(index)?);
        Some(OutlyingPoint { index, line, point_mm, distance_mm: distances[index] })
    })
    .collect()
}
