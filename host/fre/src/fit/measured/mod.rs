//! Measurements from a CSV, for comparison with a case.
//!
//! Header names carry the units; columns may be in any order, others are left aside (and named):
//!
//! | column | meaning |
//! |---|---|
//! | `motor_angle_deg` or `distance_mm` | where along the case's motion it was measured (one of the two is needed) |
//! | `force_n` | magnitude of the net force, N |
//! | `fx_n`, `fy_n` | its components on the object, world frame, N; used for the magnitude where `force_n` has none |
//! | `front_x_mm`, `front_y_mm` | points of the deformed front centreline, finger frame, mm, base to tip: lists separated by blanks, or one point per row |
//! | `motor_torque_nmm` | torque that the contact demands of the motor, N·mm, positive where it resists closing; only the calibration reads it |
//! | `time_s` | time since the motion began with an open hand, s; only the calibration of a material with memory reads it |
//!
//! Written as [`crate::spreadsheet`] reads it; up to 64 MB.
//!
//! Rows of the same place belong together: one may carry the force and many others one point each; forces of one place are
//! averaged. An empty cell is a gap. Lines that begin with `#` and empty lines are left out. A row with a gap in its place, a word where a
//! number belongs, half a point, or nothing measured is left out and reported with its line number.

mod places;

use std::fs::File;
use std::io::Read;
use std::ops::{ControlFlow, Range};
use std::path::Path;

use crate::case::{Coordinate, MAX_ANGLE, MAX_DISTANCE, MAX_TIME};
use crate::metrics::Point;
use crate::spreadsheet::{self, Sheet, decoded, listed};
use places::Places;

/// Columns that mean something.
const COLUMNS: [&str; 9] = [
    "motor_angle_deg",
    "distance_mm",
    "force_n",
    "fx_n",
    "fy_n",
    "front_x_mm",
    "front_y_mm",
    "time_s",
    "motor_torque_nmm",
];
/// Rows that are read between two looks at the watcher.
const ROWS_AT_ONCE: usize = 1 << 14;

/// The largest force that is believed, N: beyond it the unit is another one.
const MAX_FORCE: f64 = 1e5;
/// The same of a torque, N·mm.
const MAX_TORQUE: f64 = 1e7;
/// By how much a magnitude may differ from that of its components: a share, and N.
const SAME_FORCE: [f64; 2] = [0.01, 1e-3];
/// The largest coordinate of a point that is believed, mm: beyond it the unit is another one. No design is a tenth as long.
const MAX_COORDINATE: f64 = 1e4;
/// The largest file that is read: a million points are a tenth of it. What has no end, such as a device, ends here too.
const MAX_BYTES: u64 = 64 << 20;
/// Names that `fre outline` writes beside those that mean something here.
const OWN: [&str; 2] = ["arc_mm", "deviation_mm"];

/// Why a file of measurements cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum MeasuredError {
    /// The watcher stopped the reading.
    #[error("stopped")]
    Stopped,
    /// The file cannot be read.
    #[error("{file}: cannot be read: {source}")]
    Unreadable {
        /// The file.
        file: String,
        /// The system's words.
        source: std::io::Error,
    },
    /// More than is read.
    #[error("{file}: is larger than {} MB; allowed are measurements up to that size", MAX_BYTES >> 20)]
    TooLarge {
        /// The file.
        file: String,
    },
    /// The header lacks a column.
    #[error("{file}:{line}: the header lacks {needed}; it has {found}; known columns: {}", COLUMNS.join(", "))]
    Header {
        /// The file.
        file: String,
        /// Line of the header, from 1.
        line: usize,
        /// What is needed.
        needed: &'static str,
        /// The columns that it has, in the file's words.
        found: String,
    },
    /// A column that means something is there twice, or excludes another one.
    #[error("{file}:{line}: the header has {columns}; allowed is {allowed}")]
    Ambiguous {
        /// The file.
        file: String,
        /// Line of the header, from 1.
        line: usize,
        /// What it has.
        columns: String,
        /// What is allowed.
        allowed: &'static str,
    },
    /// No row can be used.
    #[error("{file}: no row can be used: {reason}")]
    Empty {
        /// The file.
        file: String,
        /// Why: the first row left out, or that there is none.
        reason: String,
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

/// The largest magnitude of a place, as in a case.
fn limit(coordinate: Coordinate) -> f64 {
    match coordinate {
        Coordinate::Angle => MAX_ANGLE,
        Coordinate::Distance => MAX_DISTANCE,
        // No file has a column of times.
        Coordinate::Time => f64::INFINITY,
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
    /// All of them with the lines they are in.
    pub forces: Vec<(usize, f64)>,
    /// Points of the front centreline, finger frame, mm, in the file's order.
    pub front: Vec<Point>,
    /// The line that each of them is in.
    pub front_lines: Vec<usize>,
    /// Motor torques, N·mm, with the lines they are in.
    pub torques: Vec<(usize, f64)>,
    /// Times since the motion began, s, of the lines that have one.
    pub times: Vec<(usize, f64)>,
    /// Sum of the forces, N: a mean of a million readings is not summed anew with each.
    sum: f64,
}

impl Measurement {
    fn at(place: f64, line: usize) -> Self {
        Self {
            line,
            place,
            force: None,
            sum: 0.0,
            forces: Vec::new(),
            front: Vec::new(),
            front_lines: Vec::new(),
            torques: Vec::new(),
            times: Vec::new(),
        }
    }

    fn add_force(&mut self, line: usize, force: f64) {
        self.forces.push((line, force));
        self.sum += force;
        self.force = Some(self.sum / self.forces.len() as f64);
    }

    fn add_point(&mut self, line: usize, point: Point) {
        self.front.push(point);
        self.front_lines.push(line);
    }

    /// The outlines that the points are of, as parts of `front`: several photographs of one place are there one after the
    /// other. A new one begins where the points leap back to where the last one began and go on from there; a single point
    /// that leaps back is a wrong one.
    pub fn outlines(&self) -> Vec<Range<usize>> {
        let gap = |i: usize, j: usize| (self.front[i][0] - self.front[j][0]).hypot(self.front[i][1] - self.front[j][1]);
        let mut outlines = Vec::new();
        let (mut start, mut reach) = (0, 0.0_f64);
        for i in 1..self.front.len() {
            let leaps = gap(i, i - 1) > 0.5 * reach && gap(i, start) < 0.5 * reach;
            if leaps && i + 1 < self.front.len() && gap(i + 1, i) <= gap(i + 1, i - 1) {
                outlines.push(start..i);
                (start, reach) = (i, 0.0);
            }
            reach = reach.max(gap(i, start));
        }
        if !self.front.is_empty() {
            outlines.push(start..self.front.len());
        }
        outlines
    }

    /// The same without some of the forces and points, by their indices.
    pub fn without(&self, forces: &[usize], points: &[usize]) -> Self {
        let mut rest = Self::at(self.place, self.line);
        rest.times.clone_from(&self.times);
        rest.torques.clone_from(&self.torques);
        for (_, &(line, force)) in self.forces.iter().enumerate().filter(|(index, _)| !forces.contains(index)) {
            rest.add_force(line, force);
        }
        let front = self.front_lines.iter().zip(&self.front).enumerate();
        for (_, (&line, &point)) in front.filter(|(index, _)| !points.contains(index)) {
            rest.add_point(line, point);
        }
        rest
    }
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
    /// Columns that mean nothing here, in the file's words.
    pub aside: Vec<String>,
}

impl Measured {
    /// Reads a file.
    ///
    /// # Errors
    /// If it cannot be read, lacks a column, or has no row that can be used.
    pub fn read(path: &Path) -> Result<Self, MeasuredError> {
        let name = path.display().to_string();
        match File::open(path) {
            Ok(file) => Self::read_from(&name, file, |_| ControlFlow::Continue(())),
            Err(source) => Err(MeasuredError::Unreadable { file: name, source }),
        }
    }

    /// Reads what comes from somewhere; `name` stands for it in messages. Calls `watch` every so many rows; it stops the reading by
    /// [`ControlFlow::Break`].
    ///
    /// # Errors
    /// As [`Self::read`], or it was stopped.
    pub fn read_from(
        name: &str,
        from: impl Read,
        watch: impl FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<Self, MeasuredError> {
        let mut bytes = Vec::new();
        match from.take(MAX_BYTES + 1).read_to_end(&mut bytes) {
            Ok(count) if count as u64 > MAX_BYTES => Err(MeasuredError::TooLarge { file: name.to_owned() }),
            Ok(_) => Self::parse_watched(name, &decoded(&bytes), watch),
            Err(source) => Err(MeasuredError::Unreadable { file: name.to_owned(), source }),
        }
    }

    /// Reads a text; `name` stands for the file in messages.
    ///
    /// # Errors
    /// If it lacks a column or has no row that can be used.
    pub fn parse(name: &str, text: &str) -> Result<Self, MeasuredError> {
        Self::parse_watched(name, text, |_| ControlFlow::Continue(()))
    }

    fn parse_watched(
        name: &str,
        text: &str,
        mut watch: impl FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<Self, MeasuredError> {
        let empty = |reason: String| MeasuredError::Empty { file: name.to_owned(), reason };
        let mut sheet = Sheet::new(text, &COLUMNS).ok_or_else(|| empty("it has no text".to_owned()))?;
        let line = sheet.line();
        if let Some(column) = sheet.repeated(&COLUMNS) {
            let columns = format!("{column} more than once");
            let allowed = "each column once";
            return Err(MeasuredError::Ambiguous { file: name.to_owned(), line, columns, allowed });
        }
        let columns = COLUMNS.map(|column| sheet.column(column));
        let lacks = |needed| MeasuredError::Header { file: name.to_owned(), line, needed, found: sheet.found() };
        let coordinate = match (columns[0], columns[1]) {
            (Some(_), None) => Coordinate::Angle,
            (None, Some(_)) => Coordinate::Distance,
            (Some(_), Some(_)) => {
                let (columns, allowed) = ("both motor_angle_deg and distance_mm".to_owned(), "one of them");
                return Err(MeasuredError::Ambiguous { file: name.to_owned(), line, columns, allowed });
            }
            (None, None) => return Err(lacks("motor_angle_deg or distance_mm")),
        };
        for pair in [[3, 4], [5, 6]] {
            if columns[pair[0]].is_some() != columns[pair[1]].is_some() {
                return Err(lacks("the other of a pair (fx_n and fy_n, front_x_mm and front_y_mm)"));
            }
        }
        if [2, 3, 5, 8].iter().all(|&column| columns[column].is_none()) {
            return Err(lacks(
                "a force (force_n, or fx_n and fy_n), a torque (motor_torque_nmm) or points (front_x_mm and front_y_mm)",
            ));
        }
        let known = |name: &str| name.is_empty() || COLUMNS.contains(&name) || OWN.contains(&name);
        let heads = sheet.heads().iter().zip(sheet.names());
        let aside = listed(heads.filter(|(_, name)| !known(name)).map(|(head, _)| head));

        let mut measured = Self { coordinate, measurements: Vec::new(), problems: Vec::new(), aside };
        let (mut places, mut rows, of) = (Places::default(), 0, sheet.lines());
        while let Some(spreadsheet::Row { line, cells }) = sheet.next() {
            rows += 1;
            if rows % ROWS_AT_ONCE == 0 && watch(Progress { line, of }).is_break() {
                return Err(MeasuredError::Stopped);
            }
            match cells.and_then(|cells| Row::read(&sheet, &cells, &columns, coordinate)) {
                Ok(row) => measured.add(line, row, &mut places),
                Err(reason) => measured.problems.push(Problem { line, reason }),
            }
        }
        if measured.measurements.is_empty() {
            let reason = measured.problems.first().map(|problem| format!("the first problem: line {problem}"));
            return Err(empty(reason.unwrap_or_else(|| "it ends with the header".to_owned())));
        }
        Ok(measured)
    }

    fn add(&mut self, line: usize, row: Row, places: &mut Places) {
        let index = places.find(row.place).unwrap_or_else(|| {
            self.measurements.push(Measurement::at(row.place, line));
            let index = self.measurements.len() - 1;
            places.add(row.place, index);
            index
        });
        let measurement = &mut self.measurements[index];
        if let Some(force) = row.force {
            measurement.add_force(line, force);
        }
        row.front.into_iter().for_each(|point| measurement.add_point(line, point));
        measurement.torques.extend(row.torque.map(|torque| (line, torque)));
        measurement.times.extend(row.time.map(|time| (line, time)));
    }

    /// The measurements of forces and points as one closing motion: every place once, in ascending order.
    pub fn closing(&self) -> Vec<Measurement> {
        let mut sorted = self.measurements.clone();
        sorted.retain(|measurement| measurement.force.is_some() || !measurement.front.is_empty());
        sorted.sort_by(|a, b| a.place.total_cmp(&b.place));
        sorted
    }

    /// The same as the motion that the file's order describes: a place is visited again if another one lies between.
    pub fn visits(&self) -> Vec<Measurement> {
        enum Of {
            Force(f64),
            Point(Point),
        }
        let mut rows: Vec<(usize, f64, Of)> = Vec::new();
        for m in &self.measurements {
            rows.extend(m.forces.iter().map(|&(line, force)| (line, m.place, Of::Force(force))));
            rows.extend(m.front_lines.iter().zip(&m.front).map(|(&line, &p)| (line, m.place, Of::Point(p))));
        }
        // Stable: points of a row keep their order.
        rows.sort_by_key(|row| row.0);
        let mut visits: Vec<Measurement> = Vec::new();
        for (line, place, what) in rows {
            if visits.last().is_none_or(|visit| visit.place != place) {
                visits.push(Measurement::at(place, line));
            }
            let Some(visit) = visits.last_mut() else { continue };
            match what {
                Of::Force(force) => visit.add_force(line, force),
                Of::Point(point) => visit.add_point(line, point),
            }
        }
        visits
    }

    /// The first line whose place is less than one before it, if the places also grow somewhere: a motion with a way back.
    pub fn turns_at(&self) -> Option<usize> {
        let visits = self.visits();
        let grows = visits.windows(2).any(|pair| pair[1].place > pair[0].place);
        let back = visits.windows(2).find(|pair| pair[1].place < pair[0].place);
        back.filter(|_| grows).map(|pair| pair[1].line)
    }
}

/// How far a file is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// The line that is read.
    pub line: usize,
    /// Lines of the file.
    pub of: usize,
}

/// A row that can be used.
struct Row {
    place: f64,
    force: Option<f64>,
    front: Vec<Point>,
    torque: Option<f64>,
    time: Option<f64>,
}

impl Row {
    fn read(
        sheet: &Sheet<'_>,
        row: &[String],
        columns: &[Option<usize>; COLUMNS.len()],
        coordinate: Coordinate,
    ) -> Result<Self, String> {
        let cell = |column: usize| {
            columns[column].and_then(|at| row.get(at)).map(String::as_str).filter(|text| !text.is_empty())
        };
        let number = |column: usize| cell(column).map(|text| sheet.number(COLUMNS[column], text)).transpose();
        let place_column = if coordinate == Coordinate::Angle { 0 } else { 1 };
        let place =
            number(place_column)?.ok_or_else(|| format!("{} is empty; needed is a number", coordinate.column()))?;
        let limit = limit(coordinate);
        if place.abs() > limit {
            return Err(format!("{} = {place}; allowed is {} to {limit}", coordinate.column(), -limit));
        }
        let force = match (number(2)?, number(3)?, number(4)?) {
            (Some(force), ..) if force < 0.0 => {
                return Err(format!("force_n = {force}; a magnitude is not negative (components are fx_n, fy_n)"));
            }
            (Some(force), Some(x), Some(y)) if (x.hypot(y) - force).abs() > SAME_FORCE[0] * force + SAME_FORCE[1] => {
                let size = x.hypot(y);
                return Err(format!(
                    "force_n = {force}, but fx_n and fy_n make {size:.4}; allowed is a difference of 1 % + 0.001 N"
                ));
            }
            (Some(force), ..) => Some(force),
            (None, Some(x), Some(y)) => Some(x.hypot(y)),
            (None, None, None) => None,
            _ => return Err("one of fx_n and fy_n is empty; needed are both or none".to_owned()),
        };
        if let Some(force) = force.filter(|&force| force > MAX_FORCE) {
            return Err(format!("a force of {force:e} N; allowed is up to {MAX_FORCE:e} N"));
        }
        let list = |column: usize| -> Result<Vec<f64>, String> {
            let words = cell(column).unwrap_or_default().split_whitespace();
            words.map(|word| sheet.number(COLUMNS[column], word)).collect()
        };
        let (xs, ys) = (list(5)?, list(6)?);
        if xs.len() != ys.len() {
            return Err(format!("front_x_mm has {} numbers, front_y_mm {}; needed are as many", xs.len(), ys.len()));
        }
        let pairs = [(5, &xs), (6, &ys)];
        let far =
            pairs.iter().find_map(|(column, list)| Some((column, list.iter().find(|x| x.abs() > MAX_COORDINATE)?)));
        if let Some((&column, far)) = far {
            let column = COLUMNS[column];
            return Err(format!("{column} = {far:e}; allowed is {:e} to {MAX_COORDINATE:e}", -MAX_COORDINATE));
        }
        let front: Vec<Point> = xs.into_iter().zip(ys).map(|(x, y)| [x, y]).collect();
        let torque = number(8)?;
        if let Some(torque) = torque.filter(|torque| torque.abs() > MAX_TORQUE) {
            return Err(format!("motor_torque_nmm = {torque:e}; allowed is {:e} to {MAX_TORQUE:e}", -MAX_TORQUE));
        }
        if force.is_none() && torque.is_none() && front.is_empty() {
            return Err("has neither a force, nor a torque, nor a point".to_owned());
        }
        let time = number(7)?;
        if let Some(time) = time.filter(|time| !(0.0..=MAX_TIME).contains(time)) {
            return Err(format!("time_s = {time}; allowed is 0 to {MAX_TIME:e}"));
        }
        Ok(Self { place, force, front, torque, time })
    }
}

/// Indices of outliers: values farther from the median than 3.5 scaled median absolute deviations (Iglewicz and Hoaglin,
/// "How to Detect and Handle Outliers", 1993), from five values on. A standard deviation is taken to be at least `least`,
/// below which the values cannot be distinguished: a few that happen to agree make no outlier of the next.
pub fn outliers(values: &[f64], least: f64) -> Vec<usize> {
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
    let deviation = (spread / 0.6745).max(least).max(1e-9);
    (0..values.len()).filter(|&i| (values[i] - middle).abs() > 3.5 * deviation).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outliers_are_far_from_the_rest_and_few_values_have_none() {
        assert_eq!(outliers(&[1.0, 1.1, 0.9, 5.0, 1.05, 0.95], 0.0), vec![3]);
        assert_eq!(outliers(&[1.0, 1.1, 0.9, 1.05, 0.95], 0.0), Vec::<usize>::new());
        assert_eq!(outliers(&[1.0, 9.0, 1.0], 0.0), Vec::<usize>::new());
        assert_eq!(outliers(&[0.0; 6], 0.0), Vec::<usize>::new());
        // Four of five agree by chance; the fifth differs by less than can be measured.
        assert_eq!(outliers(&[0.10, 0.10, 0.11, 0.10, 0.14], 0.0), vec![2, 4]);
        assert_eq!(outliers(&[0.10, 0.10, 0.11, 0.10, 0.14], 0.02), Vec::<usize>::new());
    }
}
