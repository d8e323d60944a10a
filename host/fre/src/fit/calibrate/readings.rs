//! Measured readings on one object.

use model_core::object::ObjectDesign;

use crate::fit::measured::Measured;
use crate::metrics::Point;

/// One reading.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// Line of the file, from 1.
    pub line: usize,
    /// Measured motor angle, degrees.
    pub angle_deg: f64,
    /// Time since the motion began with an open hand, s; none where it does not matter.
    pub time_s: Option<f64>,
    /// Measured magnitude of the force, N, if it was.
    pub force_n: Option<f64>,
    /// Points of the front centreline, finger frame, mm, if there are any.
    pub front_mm: Vec<Point>,
}

/// Readings on one object, in the order of the motion; of a material with memory in that of their times.
#[derive(Clone, Debug, PartialEq)]
pub struct Readings {
    /// What it is called in messages: its file.
    pub name: String,
    /// The object as the case describes it, world frame.
    pub object: ObjectDesign,
    /// The object's coefficient of friction, as the case has it.
    pub friction: f64,
    /// By increasing angle, in the file's order if the motion opens too, or by increasing time.
    pub readings: Vec<Reading>,
}

impl Readings {
    /// A run of the measurements that belong to a closing motion, and the lines of those left out: rows of the file in which the
    /// angle is less than the greatest before by more than `tolerance_deg` belong to an opening.
    pub fn closing(
        name: &str,
        object: ObjectDesign,
        friction: f64,
        measured: &Measured,
        tolerance_deg: f64,
    ) -> (Self, Vec<usize>) {
        let mut all = Self::all(name, object, friction, measured);
        let mut greatest = f64::NEG_INFINITY;
        let mut left_out = Vec::new();
        all.readings.retain(|reading| {
            let opens = reading.angle_deg < greatest - tolerance_deg;
            greatest = greatest.max(reading.angle_deg);
            if opens {
                left_out.push(reading.line);
            }
            !opens
        });
        all.readings.sort_by(|a, b| a.angle_deg.total_cmp(&b.angle_deg));
        (all, left_out)
    }

    /// A run of all measurements, in the file's order: the way that the finger has come.
    pub fn all(name: &str, object: ObjectDesign, friction: f64, measured: &Measured) -> Self {
        let mut rows: Vec<(usize, f64, Option<f64>, &[Point])> = Vec::new();
        for measurement in &measured.measurements {
            if measurement.forces.is_empty() {
                rows.push((measurement.line, measurement.place, None, &measurement.front));
            }
            for (index, &(line, force)) in measurement.forces.iter().enumerate() {
                // The outline belongs to the place; it counts once.
                let front = if index == 0 { measurement.front.as_slice() } else { &[] };
                rows.push((line, measurement.place, Some(force), front));
            }
        }
        rows.sort_by_key(|row| row.0);
        let reading = |(line, angle_deg, force_n, front): (usize, f64, Option<f64>, &[Point])| Reading {
            line,
            angle_deg,
            time_s: None,
            force_n,
            front_mm: front.to_vec(),
        };
        Self { name: name.to_owned(), object, friction, readings: rows.into_iter().map(reading).collect() }
    }

    /// A run of all measurements along their time, which each row has to have.
    ///
    /// # Errors
    /// The line of the first row without a time, or whose time is not after that of the row before.
    pub fn in_time(name: &str, object: ObjectDesign, friction: f64, measured: &Measured) -> Result<Self, usize> {
        let mut readings: Vec<Reading> = Vec::new();
        for measurement in &measured.measurements {
            let time = |line: usize| {
                let at = measurement.times.binary_search_by_key(&line, |(of, _)| *of).ok()?;
                measurement.times.get(at).map(|(_, time)| *time)
            };
            for (index, &(line, force)) in measurement.forces.iter().enumerate() {
                let front_mm = if index == 0 { measurement.front.clone() } else { Vec::new() };
                let (angle_deg, time_s) = (measurement.place, Some(time(line).ok_or(line)?));
                readings.push(Reading { line, angle_deg, time_s, force_n: Some(force), front_mm });
            }
        }
        readings.sort_by_key(|reading| reading.line);
        match readings.windows(2).find(|pair| pair[0].time_s >= pair[1].time_s) {
            Some(pair) => Err(pair[1].line),
            None => Ok(Self { name: name.to_owned(), object, friction, readings }),
        }
    }
}
