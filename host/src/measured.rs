//! Measurements from a CSV, for comparison with a case.
//!
//! Header names carry the units; columns may stand in any order, others are left aside:
//!
//! | column | meaning |
//! |---|---|
//! | `motor_angle_deg` or `distance_mm` | where along the case's motion it was measured (one of the two is needed) |
//! | `force_n` | magnitude of the net force, N |
//! | `fx_n`, `fy_n` | its components on the object, world frame, N; used for the magnitude where `force_n` has none |
//! | `front_x_mm`, `front_y_mm` | points of the deformed front centreline, finger frame, mm, base to tip: lists separated by blanks, or one point per row |
//!
//! Rows of the same place belong together: one may carry the force and many others one point each; forces of one place are
//! averaged. An empty cell is a gap. Lines that begin with `#` and empty lines are left out. A row with a gap in its place, a word where a
//! number belongs, half a point, or nothing measured is left out and reported with its line number.

use std::path::Path;

use crate::case::{MAX_ANGLE, MAX_DISTANCE};
use crate::metrics::Point;

/// Places closer than this are the same one.
const SAME_PLACE: f64 = 1e-6;

/// Columns that mean something.
const COLUMNS: [&str; 7] = ["motor_angle_deg", "distance_mm", "force_n", "fx_n", "fy_n", "front_x_mm", "front_y_mm"];

/// Why a file of measurements cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum MeasuredError {
    /// The file cannot be read.
    #[error("{file}: cannot be read: {source}")]
    Unreadable {
        /// The file.
        file: String,
        /// The system's words.
        source: std::io::Error,
    },
    /// The header lacks a column.
    #[error("{file}:{line}: the header lacks {needed}; known columns: {}", COLUMNS.join(", "))]
    Header {
        /// The file.
        file: String,
        /// Line of the header, from 1.
        line: usize,
        /// What is needed.
        needed: &'static str,
    },
    /// Cells are separated by something else.
    #[error(
        "{file}:{line}: the cells of a row are separated by commas, decimals by a point; this file has another separator"
    )]
    Separator {
        /// The file.
        file: String,
        /// Line of the header, from 1.
        line: usize,
    },
    /// No row can be used.
    #[error("{file}: no row can be used{}", .first.as_ref().map(|problem| format!("; the first problem: line {problem}")).unwrap_or_default())]
    Empty {
        /// The file.
        file: String,
        /// The first row left out, if there was one.
        first: Option<String>,
    },
}

/// A row that was left out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// Line of the file, from 1.
    pub line: usize,
    /// What is wrong and what is allowed.
    pub reason: String,
}

impl std::fmt::Display for Problem {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.line, self.reason)
    }
}

/// What the places of a file are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coordinate {
    /// Motor angles, degrees.
    MotorAngle,
    /// Distances of a translated base, mm.
    Distance,
}

impl Coordinate {
    /// The column's name.
    pub fn column(self) -> &'static str {
        match self {
            Self::MotorAngle => COLUMNS[0],
            Self::Distance => COLUMNS[1],
        }
    }
}

impl Coordinate {
    /// The largest magnitude, as in a case.
    fn limit(self) -> f64 {
        match self {
            Self::MotorAngle => MAX_ANGLE,
            Self::Distance => MAX_DISTANCE,
        }
    }
}

/// What was measured at one place.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// Line of its first row, from 1.
    pub line: usize,
    /// Place, degrees or mm.
    pub place: f64,
    /// Magnitude of the force, N; the mean of several.
    pub force: Option<f64>,
    /// All of them with the lines they stand in.
    pub forces: Vec<(usize, f64)>,
    /// Points of the front centreline, finger frame, mm, in the file's order.
    pub front: Vec<Point>,
}

/// A file of measurements.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// What the places are.
    pub coordinate: Coordinate,
    /// One entry per place, in the file's order.
    pub measurements: Vec<Measurement>,
    /// Rows that were left out.
    pub problems: Vec<Problem>,
}

impl Measured {
    /// Reads a file.
    ///
    /// # Errors
    /// If it cannot be read, lacks a column, or has no row that can be used.
    pub fn read(path: &Path) -> Result<Self, MeasuredError> {
        let name = path.display().to_string();
        match std::fs::read(path) {
            // A byte that is not UTF-8 spoils its cell, not the file.
            Ok(bytes) => Self::parse(&name, &String::from_utf8_lossy(&bytes)),
            Err(source) => Err(MeasuredError::Unreadable { file: name, source }),
        }
    }

    /// Reads a text; `name` stands for the file in messages.
    ///
    /// # Errors
    /// If it lacks a column or has no row that can be used.
    pub fn parse(name: &str, text: &str) -> Result<Self, MeasuredError> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let mut lines =
            text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty() && !line.trim_start().starts_with('#'));
        let empty = |first: Option<String>| MeasuredError::Empty { file: name.to_owned(), first };
        let (header_line, header) = lines.next().ok_or_else(|| empty(None))?;
        if !header.contains(',') && header.contains([';', '\t']) {
            return Err(MeasuredError::Separator { file: name.to_owned(), line: header_line + 1 });
        }
        let names: Vec<String> = cells(header).map(str::to_ascii_lowercase).collect();
        let columns = COLUMNS.map(|column| names.iter().position(|name| name == column));
        let lacks = |needed| MeasuredError::Header { file: name.to_owned(), line: header_line + 1, needed };
        let coordinate = match (columns[0], columns[1]) {
            (Some(_), None) => Coordinate::MotorAngle,
            (None, Some(_)) => Coordinate::Distance,
            (Some(_), Some(_)) => return Err(lacks("a single place: it has both motor_angle_deg and distance_mm")),
            (None, None) => return Err(lacks("motor_angle_deg or distance_mm")),
        };
        for pair in [[3, 4], [5, 6]] {
            if columns[pair[0]].is_some() != columns[pair[1]].is_some() {
                return Err(lacks("the other of a pair (fx_n and fy_n, front_x_mm and front_y_mm)"));
            }
        }
        if [2, 3, 5].iter().all(|&column| columns[column].is_none()) {
            return Err(lacks("a force (force_n, or fx_n and fy_n) or points (front_x_mm and front_y_mm)"));
        }

        let mut measured = Self { coordinate, measurements: Vec::new(), problems: Vec::new() };
        for (index, line) in lines {
            let row: Vec<&str> = cells(line).collect();
            let read = if row.len() == names.len() {
                Row::read(&row, &columns, coordinate)
            } else {
                Err(format!("has {} cells, the header {}", row.len(), names.len()))
            };
            match read {
                Ok(row) => measured.add(index + 1, row),
                Err(reason) => measured.problems.push(Problem { line: index + 1, reason }),
            }
        }
        if measured.measurements.is_empty() {
            return Err(empty(measured.problems.first().map(Problem::to_string)));
        }
        Ok(measured)
    }

    fn add(&mut self, line: usize, row: Row) {
        let known = self.measurements.iter().position(|m| (m.place - row.place).abs() < SAME_PLACE);
        let index = known.unwrap_or_else(|| {
            let new = Measurement { line, place: row.place, force: None, forces: Vec::new(), front: Vec::new() };
            self.measurements.push(new);
            self.measurements.len() - 1
        });
        let measurement = &mut self.measurements[index];
        if let Some(force) = row.force {
            measurement.forces.push((line, force));
            let sum: f64 = measurement.forces.iter().map(|(_, force)| force).sum();
            measurement.force = Some(sum / measurement.forces.len() as f64);
        }
        measurement.front.extend(row.front);
    }
}

/// A row that can be used.
struct Row {
    place: f64,
    force: Option<f64>,
    front: Vec<Point>,
}

impl Row {
    fn read(row: &[&str], columns: &[Option<usize>; 7], coordinate: Coordinate) -> Result<Self, String> {
        let cell = |column: usize| columns[column].and_then(|at| row.get(at)).copied().filter(|text| !text.is_empty());
        let number = |column: usize| cell(column).map(|text| number(COLUMNS[column], text)).transpose();
        let place_column = if coordinate == Coordinate::MotorAngle { 0 } else { 1 };
        let place =
            number(place_column)?.ok_or_else(|| format!("{} is empty; needed is a number", coordinate.column()))?;
        let limit = coordinate.limit();
        if place.abs() > limit {
            return Err(format!("{} = {place}; allowed is {} to {limit}", coordinate.column(), -limit));
        }
        let force = match (number(2)?, number(3)?, number(4)?) {
            (Some(force), ..) if force < 0.0 => return Err(format!("force_n = {force}; a magnitude is not negative")),
            (Some(force), ..) => Some(force),
            (None, Some(x), Some(y)) => Some(x.hypot(y)),
            (None, None, None) => None,
            _ => return Err("one of fx_n and fy_n is empty; needed are both or none".to_owned()),
        };
        let list = |column: usize| -> Result<Vec<f64>, String> {
            let words = cell(column).unwrap_or_default().split_whitespace();
            words.map(|word| self::number(COLUMNS[column], word)).collect()
        };
        let (xs, ys) = (list(5)?, list(6)?);
        if xs.len() != ys.len() {
            return Err(format!("front_x_mm has {} numbers, front_y_mm {}; needed are as many", xs.len(), ys.len()));
        }
        let front: Vec<Point> = xs.into_iter().zip(ys).map(|(x, y)| [x, y]).collect();
        if force.is_none() && front.is_empty() {
            return Err("has neither a force nor a point".to_owned());
        }
        Ok(Self { place, force, front })
    }
}

fn number(column: &str, text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(format!("{column} = \"{text}\" is not a finite number")),
    }
}

/// Cells of a line, without blanks and quotation marks around them.
fn cells(line: &str) -> impl Iterator<Item = &str> {
    line.split(',').map(|cell| cell.trim().trim_matches('"').trim())
}

/// Indices of outliers: values farther from the median than 3.5 scaled median absolute deviations (Iglewicz and Hoaglin,
/// "How to Detect and Handle Outliers", 1993), from five values on.
pub fn outliers(values: &[f64]) -> Vec<usize> {
    let median = |values: &mut Vec<f64>| {
        values.sort_by(f64::total_cmp);
        let n = values.len();
        0.5 * (values[(n - 1) / 2] + values[n / 2])
    };
    if values.len() < 5 {
        return Vec::new();
    }
    let middle = median(&mut values.to_vec());
    let spread = median(&mut values.iter().map(|value| (value - middle).abs()).collect());
    // 0.6745: the median absolute deviation of a normal distribution over its standard deviation.
    let far = |value: f64| 0.6745 * (value - middle).abs() > 3.5 * spread.max(1e-9);
    (0..values.len()).filter(|&i| far(values[i])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outliers_are_far_from_the_rest_and_few_values_have_none() {
        assert_eq!(outliers(&[1.0, 1.1, 0.9, 5.0, 1.05, 0.95]), vec![3]);
        assert_eq!(outliers(&[1.0, 1.1, 0.9, 1.05, 0.95]), Vec::<usize>::new());
        assert_eq!(outliers(&[1.0, 9.0, 1.0]), Vec::<usize>::new());
        assert_eq!(outliers(&[0.0; 6]), Vec::<usize>::new());
    }
}
