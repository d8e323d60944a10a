//! A motion whose readings determine what is to be fitted, and how well they do before anything was measured.

use std::convert::Infallible;
use std::fmt::Write as _;
use std::ops::RangeInclusive;

use super::{Fit, FitError, Input, Noise, Parameter, Predictor, Quantity, Reading, Trial, fit};
use crate::delimited;
use crate::spreadsheet::{Row, Sheet};

/// Columns of its table.
const COLUMNS: [&str; 2] = ["time_s", "motor_angle_deg"];
/// Readings on a way to the highest angle, or back.
const ON_THE_WAY: u32 = 8;
/// Readings of a closing of a finger without memory.
const CLOSING: u32 = 48;
/// Readings in every decade of the time for which the finger is held.
const PER_DECADE: u32 = 8;
/// The first reading of a finger that is held, s after it has stopped.
const FIRST_S: f64 = 0.1;
/// How long it is held, in times of the slowest term: 5 % of that one's share is left then.
const HELD: f64 = 3.0;
/// How long it rests open, in times for which it was held.
const RESTED: f64 = 2.0;
/// Speeds that differ by less, relatively, are one.
const SAME_SPEED: f64 = 0.02;
/// The second closing is slower than the first by this factor.
const SLOWER: f64 = 10.0;

/// A motion to measure along: the motor moves evenly from place to place, and a force or a torque is read at each.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Time since the beginning with an open hand, s, and motor angle, degrees.
    pub places: Vec<[f64; 2]>,
}

/// Why a table cannot be a plan.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// It is not a table, or has other columns.
    #[error("{file}:{line}: {why}; needed are the columns time_s and motor_angle_deg, with numbers in every row")]
    Table {
        /// The file.
        file: String,
        /// The line.
        line: usize,
        /// What is wrong.
        why: String,
    },
    /// A time that is not after the one before.
    #[error("{file}:{line}: time_s is {time_s}; allowed is more than in the row before, {before_s}")]
    Time {
        /// The file.
        file: String,
        /// The line.
        line: usize,
        /// The time.
        time_s: f64,
        /// The one before.
        before_s: f64,
    },
    /// An angle that is not allowed.
    #[error("{file}:{line}: motor_angle_deg is {angle_deg}; allowed is {least_deg} to {most_deg}")]
    Angle {
        /// The file.
        file: String,
        /// The line.
        line: usize,
        /// The angle.
        angle_deg: f64,
        /// The least allowed.
        least_deg: f64,
        /// The greatest allowed.
        most_deg: f64,
    },
    /// Fewer than two places.
    #[error("{file}: needed are two rows or more")]
    Short {
        /// The file.
        file: String,
    },
}

impl Plan {
    /// From an open hand at `from_deg` to the highest angle `to_deg` with a speed.
    ///
    /// A finger without memory closes evenly; if friction is to be distinguished from the modulus (`there_and_back`), half of the readings are on the
    /// opening. A finger with the terms `prony` ([gᵢ, τᵢ in s]) closes, is held for three times the slowest one's τ with readings evenly in
    /// the logarithm of the time, opens, rests for twice as long, and closes at a tenth of the speed: what fades during the first closing
    /// is what distinguishes it from the second.
    pub fn new(from_deg: f64, to_deg: f64, speed_deg_per_s: f64, prony: &[[f64; 2]], there_and_back: bool) -> Self {
        let mut plan = Self { places: vec![[0.0, from_deg]] };
        let slowest = prony.iter().map(|[_, time]| *time).fold(0.0, f64::max);
        if slowest == 0.0 {
            let count = if there_and_back { CLOSING / 2 } else { CLOSING };
            plan.go(to_deg, speed_deg_per_s, count);
            if there_and_back {
                plan.go(from_deg, speed_deg_per_s, count);
            }
            return plan;
        }
        plan.go(to_deg, speed_deg_per_s, ON_THE_WAY);
        let held_s = HELD * slowest;
        plan.hold(held_s);
        plan.go(from_deg, speed_deg_per_s, if there_and_back { ON_THE_WAY } else { 1 });
        plan.places.push([plan.length_s() + RESTED * held_s, from_deg]);
        plan.go(to_deg, speed_deg_per_s / SLOWER, ON_THE_WAY);
        plan
    }

    /// How long it takes, s.
    pub fn length_s(&self) -> f64 {
        self.places.last().map_or(0.0, |[time, _]| *time)
    }

    fn go(&mut self, to_deg: f64, speed_deg_per_s: f64, readings: u32) {
        let Some(&[begin_s, from_deg]) = self.places.last() else { return };
        let way = to_deg - from_deg;
        for reading in 1..=readings {
            let share = f64::from(reading) / f64::from(readings);
            self.places.push([begin_s + share * way.abs() / speed_deg_per_s, from_deg + share * way]);
        }
    }

    fn hold(&mut self, length_s: f64) {
        let Some(&[begin_s, at_deg]) = self.places.last() else { return };
        let first_s = FIRST_S.min(0.1 * length_s);
        let decades = (length_s / first_s).log10();
        let readings = (decades * f64::from(PER_DECADE)).ceil().max(1.0) as u32;
        for reading in 0..=readings {
            let after_s = first_s * 10.0_f64.powf(decades * f64::from(reading) / f64::from(readings));
            self.places.push([begin_s + after_s, at_deg]);
        }
    }

    /// Reads a table as [`Self::csv`] or a [spreadsheet](crate::spreadsheet) writes it, whose angles lie in a range, degrees; other
    /// columns are left aside.
    ///
    /// # Errors
    /// The line of a cell that should be a number, of a time that is not after the one before, or of an angle beyond the range.
    pub fn parse(file: &str, text: &str, range_deg: RangeInclusive<f64>) -> Result<Self, PlanError> {
        let table = |line: usize, why: String| PlanError::Table { file: file.to_owned(), line, why };
        let mut sheet = Sheet::new(text, &COLUMNS).ok_or_else(|| table(1, "has no text".to_owned()))?;
        if let Some(column) = sheet.repeated(&COLUMNS) {
            return Err(table(sheet.line(), format!("has {column} more than once")));
        }
        let column = |name: &str| {
            sheet
                .column(name)
                .ok_or_else(|| table(sheet.line(), format!("has no column {name}; it has {}", sheet.found())))
        };
        let columns = [column(COLUMNS[0])?, column(COLUMNS[1])?];
        let mut places: Vec<[f64; 2]> = Vec::new();
        while let Some(Row { line, cells }) = sheet.next() {
            let cells = cells.map_err(|why| table(line, why))?;
            let number = |of: usize| {
                let cell = cells.get(columns[of]).map_or("", String::as_str);
                sheet.number(COLUMNS[of], cell).map_err(|why| table(line, why))
            };
            let place = [number(0)?, number(1)?];
            if let Some(&[before_s, _]) = places.last().filter(|[before_s, _]| *before_s >= place[0]) {
                return Err(PlanError::Time { file: file.to_owned(), line, time_s: place[0], before_s });
            }
            if !range_deg.contains(&place[1]) {
                let (least_deg, most_deg) = range_deg.into_inner();
                return Err(PlanError::Angle { file: file.to_owned(), line, angle_deg: place[1], least_deg, most_deg });
            }
            places.push(place);
        }
        if places.len() < 2 {
            return Err(PlanError::Short { file: file.to_owned() });
        }
        Ok(Self { places })
    }

    /// The moves of the motor, one after the other: the first place and the last of each, between which it turns evenly or rests.
    pub fn moves(&self) -> Vec<[[f64; 2]; 2]> {
        let mut moves: Vec<[[f64; 2]; 2]> = Vec::new();
        for (begin, end) in self.places.iter().zip(self.places.iter().skip(1)) {
            let speed = |[from, to]: [[f64; 2]; 2]| (to[1] - from[1]) / (to[0] - from[0]);
            let now = speed([*begin, *end]);
            match moves.last_mut() {
                // A table's rounding makes the speed of a part of a move differ a little from that of the whole.
                Some(last) if (speed(*last) - now).abs() <= SAME_SPEED * now.abs() => last[1] = *end,
                _ => moves.push([*begin, *end]),
            }
        }
        moves
    }

    /// As a table with the columns `time_s` and `motor_angle_deg`; measurements have these and the forces or torques.
    pub fn csv(&self) -> String {
        let mut text = delimited::line(COLUMNS);
        for place in &self.places {
            text += &delimited::line(place.map(|number| format!("{number:.4}")));
        }
        text
    }

    /// The readings of this motion.
    pub(super) fn readings(&self) -> Vec<Reading> {
        let reading = |(index, &[time_s, angle_deg]): (usize, &[f64; 2])| Reading {
            line: index + 2,
            angle_deg,
            time_s: Some(time_s),
            force_n: None,
            torque_nmm: None,
            front_mm: Vec::new(),
        };
        self.places.iter().enumerate().map(reading).collect()
    }
}

/// What readings of these quantities along the plan's runs would determine, if the finger were as its case says: a fit to the model's own
/// values. Readings without a trustworthy solution are left out.
///
/// # Errors
/// As [`fit()`].
pub fn expect(
    model: &Predictor<'_>,
    input: &mut Input,
    parameters: &[Parameter],
    quantities: &[Quantity],
    noise: &Noise,
) -> Result<Fit, FitError<Infallible>> {
    let start = Trial::start(parameters, model.design, model.prony);
    for run in &mut input.runs {
        let predicted = model.predict(run, &start, false)?;
        for (reading, prediction) in run.readings.iter_mut().zip(predicted) {
            let read = |quantity| prediction.status.is_trustworthy() && quantities.contains(&quantity);
            reading.force_n = read(Quantity::Force).then_some(prediction.force.value);
            reading.torque_nmm = read(Quantity::Torque).then_some(prediction.torque.value);
        }
        let all = run.readings.len();
        run.readings.retain(Reading::has_load);
        if let left_out @ 1.. = all - run.readings.len() {
            input.remarks.push(format!("left out: {left_out} places of {} without a trustworthy solution", run.name));
        }
    }
    fit(model, &input.runs, parameters, noise)
}

/// The plan for people: its length, and what it determines.
pub fn plan_text(plan: &Plan, input: &Input, fit: &Fit, noise: &Noise) -> String {
    let (readings, length_s) = (plan.places.len(), plan.length_s());
    let highest = plan.places.iter().map(|[_, angle]| *angle).fold(f64::NEG_INFINITY, f64::max);
    let mut out = format!("{readings} readings in {length_s:.1} s, up to {highest:.3}°");
    let runs = input.runs.len();
    if runs > 1 {
        let _ = write!(out, ", once in front of each of {runs} objects");
    }
    let within = fit
        .quantities()
        .into_iter()
        .map(|quantity| format!("{} within {} {}", quantity.plural(), quantity.deviation(noise), quantity.unit()));
    let within = within.collect::<Vec<_>>().join(" and ");
    let _ = writeln!(out, "; with {within} (standard deviation) they would determine");
    // Writing to a string cannot fail.
    let _ = super::report::write_expected(&mut out, fit);
    input.remarks.iter().for_each(|remark| out += &format!("{remark}\n"));
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_finger_with_memory_is_held_for_its_slowest_term_and_closes_twice() {
        let prony = [[0.15, 1.0], [0.15, 30.0]];
        let plan = Plan::new(0.0, 8.0, 10.0, &prony, false);
        let [closing, held, opening, rest, slow] = plan.moves()[..] else { panic!("{:?}", plan.moves()) };
        assert_eq!(closing, [[0.0, 0.0], [0.8, 8.0]]);
        assert!(held[0] == closing[1] && (held[1][0] - 90.8).abs() < 1e-9 && held[1][1] == 8.0, "{held:?}");
        assert!(opening[1][1] == 0.0 && (opening[1][0] - opening[0][0] - 0.8).abs() < 1e-9, "{opening:?}");
        assert!((rest[1][0] - rest[0][0] - 180.0).abs() < 1e-9 && rest[1][1] == 0.0, "{rest:?}");
        assert!((slow[1][0] - slow[0][0] - 8.0).abs() < 1e-9 && slow[1][1] == 8.0, "{slow:?}");
        // A tenth of a second after it has stopped, and eight in every decade from there.
        let holding: Vec<f64> =
            plan.places.iter().filter(|place| (0.85..=90.8).contains(&place[0])).map(|place| place[0] - 0.8).collect();
        assert!((holding[0] - 0.1).abs() < 1e-9 && holding.len() == 25, "{holding:?}");
        assert!(holding.windows(2).all(|pair| (pair[1] / pair[0]).log10() <= 1.0 / 8.0 + 1e-9), "{holding:?}");
    }

    #[test]
    fn a_finger_without_memory_closes_and_for_friction_opens_too() {
        let closing = Plan::new(0.0, 9.0, 1.0, &[], false);
        assert_eq!((closing.moves().len(), closing.places.len()), (1, 49));
        let back = Plan::new(-1.0, 9.0, 1.0, &[], true);
        assert_eq!((back.moves().len(), back.places.len()), (2, 49));
        assert_eq!(back.places.last(), Some(&[20.0, -1.0]));
    }

    #[test]
    fn a_plan_is_read_as_it_was_written() {
        let plan = Plan::new(0.0, 8.0, 10.0, &[[0.2, 3.0]], true);
        let read = Plan::parse("plan.csv", &plan.csv(), 0.0..=8.0).unwrap();
        let near = |(one, other): (&[f64; 2], &[f64; 2])| (0..2).all(|at| (one[at] - other[at]).abs() <= 5e-5);
        assert!(read.places.len() == plan.places.len() && read.places.iter().zip(&plan.places).all(near));
        assert_eq!(read.moves().len(), plan.moves().len());
    }

    /// Semicolons and decimal commas, as spreadsheets of many countries write them; tabs; capitals, a comment, a byte order mark.
    #[test]
    fn a_plan_is_read_as_spreadsheets_write_it() {
        for text in [
            "time_s;motor_angle_deg\n0;0\n0,5;1,25\n",
            "\u{feff}Time_s;Motor_angle_deg;\r\n# closing\r\n0,0;0;\r\n0,5;1,25;\r\n",
            "sep=|\ntime_s|note|motor_angle_deg\n0|\"a|b\"|0\n0.5||1.25\n",
            "time_s\tmotor_angle_deg\n0\t0\n0,5\t1.25\n",
        ] {
            let plan = Plan::parse("plan.csv", text, 0.0..=8.0).unwrap();
            assert_eq!(plan.places, [[0.0, 0.0], [0.5, 1.25]], "{text:?}");
        }
    }

    #[test]
    fn what_is_no_plan_is_refused_with_its_line() {
        for (text, words) in [
            ("time_s,angle\n0,0\n1,1\n", "m.csv:1: has no column motor_angle_deg; it has time_s, angle;"),
            (
                "time_s,motor_angle_deg\n0,0\n1,fast\n",
                "m.csv:3: motor_angle_deg = \"fast\" is not a finite number (the unit belongs in the header);",
            ),
            ("time_s,motor_angle_deg\n0,0\n1\n", "m.csv:3: has 1 cells, the header 2 (decimals have a point);"),
            (
                "time_s,motor_angle_deg\n0,0\n2,1\n2,2\n",
                "m.csv:4: time_s is 2; allowed is more than in the row before, 2",
            ),
            ("time_s,motor_angle_deg\n0,0\n\n1,12.5\n", "m.csv:4: motor_angle_deg is 12.5; allowed is -10 to 10"),
            ("time_s,motor_angle_deg\n0,0\n", "m.csv: needed are two rows or more"),
        ] {
            let error = Plan::parse("m.csv", text, -10.0..=10.0).unwrap_err().to_string();
            assert!(error.starts_with(words), "{error}");
        }
    }
}
