//! Measured readings on one object.

use std::collections::BTreeMap;

use model_core::object::ObjectDesign;

use crate::fit::measured::{Measured, Measurement};
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
    /// Measured motor torque, N·mm, if it was.
    pub torque_nmm: Option<f64>,
    /// Points of the front centreline, finger frame, mm, if there are any.
    pub front_mm: Vec<Point>,
}

impl Reading {
    /// A force or a torque was measured.
    pub fn has_load(&self) -> bool {
        self.force_n.is_some() || self.torque_nmm.is_some()
    }
}

/// The readings of a place, one for each line with a force or a torque; one with points alone if there is none.
fn of_place(measurement: &Measurement) -> Vec<Reading> {
    let blank = |line| Reading {
        line,
        angle_deg: measurement.place,
        time_s: None,
        force_n: None,
        torque_nmm: None,
        front_mm: Vec::new(),
    };
    let mut lines: BTreeMap<usize, Reading> = BTreeMap::new();
    for &(line, force) in &measurement.forces {
        lines.entry(line).or_insert_with(|| blank(line)).force_n = Some(force);
    }
    for &(line, torque) in &measurement.torques {
        lines.entry(line).or_insert_with(|| blank(line)).torque_nmm = Some(torque);
    }
    let mut readings: Vec<Reading> = lines.into_values().collect();
    if readings.is_empty() {
        readings.push(blank(measurement.line));
    }
    // The outline belongs to the place; it counts once.
    if let Some(first) = readings.first_mut() {
        first.front_mm.clone_from(&measurement.front);
    }
    readings
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
        let mut readings: Vec<Reading> = measured.measurements.iter().flat_map(of_place).collect();
        readings.sort_by_key(|reading| reading.line);
        Self { name: name.to_owned(), object, friction, readings }
    }

    /// The same motion with a place before every reading, so far before it on the way there or at half of a shorter way, and how far each
    /// reading is from its place, degrees, positive where the motion closes; 0 of a reading at the angle of the one before.
    pub(super) fn by_steps(&self, step_deg: f64) -> (Self, Vec<f64>) {
        let mut way = Self { readings: Vec::with_capacity(2 * self.readings.len()), ..self.clone() };
        way.readings.clear();
        let mut steps = Vec::with_capacity(self.readings.len());
        for (index, reading) in self.readings.iter().enumerate() {
            let before = index.checked_sub(1).and_then(|before| self.readings.get(before));
            // The first reading is on the way to the second.
            let came = before.map(|before| reading.angle_deg - before.angle_deg);
            let goes = || Some(self.readings.get(index + 1)?.angle_deg - reading.angle_deg);
            let length = if before.is_some() { came } else { goes() }.unwrap_or(0.0);
            let step = length.signum() * step_deg.min(0.5 * length.abs());
            let step = if length == 0.0 { 0.0 } else { step };
            let time_s = before.and_then(|before| {
                let part = if length == 0.0 { 0.0 } else { step / length };
                Some(reading.time_s? - part * (reading.time_s? - before.time_s?))
            });
            let time_s = time_s.or(reading.time_s);
            let front_mm = Vec::new();
            way.readings.push(Reading { angle_deg: reading.angle_deg - step, time_s, front_mm, ..reading.clone() });
            way.readings.push(Reading { front_mm: Vec::new(), ..reading.clone() });
            steps.push(step);
        }
        (way, steps)
    }

    /// Indices of the readings at which the motion turns round, from closing to opening or back.
    pub(super) fn turns(&self) -> Vec<usize> {
        let mut turns = Vec::new();
        let mut last = 0.0_f64;
        for (index, pair) in self.readings.windows(2).enumerate() {
            let way = pair[1].angle_deg - pair[0].angle_deg;
            if way != 0.0 {
                if way * last < 0.0 {
                    turns.push(index);
                }
                last = way;
            }
        }
        turns
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
            // Points alone tell nothing of the time.
            for reading in of_place(measurement).into_iter().filter(Reading::has_load) {
                let time_s = Some(time(reading.line).ok_or(reading.line)?);
                readings.push(Reading { time_s, ..reading });
            }
        }
        readings.sort_by_key(|reading| reading.line);
        match readings.windows(2).find(|pair| pair[0].time_s >= pair[1].time_s) {
            Some(pair) => Err(pair[1].line),
            None => Ok(Self { name: name.to_owned(), object, friction, readings }),
        }
    }
}
