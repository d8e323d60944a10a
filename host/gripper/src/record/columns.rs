//! The columns of a table of reports, defined once: for the CSV and for whatever else has tables.

use std::fmt;

use fre::table::{Column, Kind, Table, Values};
use messages::Report;
use model_core::estimator::Interval;

/// A report's value in a column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cell {
    /// A whole number.
    Integer(i64),
    /// A number; in words it has the digits that single precision needs.
    Number(f32),
    /// A word.
    Word(&'static str),
}

impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Integer(value) => value.fmt(f),
            Self::Number(value) => value.fmt(f),
            Self::Word(word) => f.write_str(word),
        }
    }
}

use Cell::{Integer, Number, Word};

/// A column: its name, and its value of a report.
pub type ReportColumn = (&'static str, fn(&Report) -> Cell);

/// The columns. New ones are added at the end only.
pub const COLUMNS: [ReportColumn; 32] = [
    ("sequence", |report| Integer(report.sequence.into())),
    ("time_us", |report| Integer(report.time_us as i64)),
    ("motor_angle_deg", |report| Number(report.estimate.motor_angle.to_degrees())),
    ("goal_deg", |report| Number(report.goal.to_degrees())),
    ("position_counts", |report| Integer(report.position.into())),
    ("current_ma", |report| Number(report.current)),
    ("status", |report| Word(report.estimate.status.word())),
    ("age", |report| Integer(report.estimate.age.into())),
    ("force_x_n", |report| Number(report.estimate.force[0])),
    ("force_y_n", |report| Number(report.estimate.force[1])),
    ("contact_x_mm", |report| Number(report.estimate.contact_centre[0])),
    ("contact_y_mm", |report| Number(report.estimate.contact_centre[1])),
    ("contact_extent_mm", |report| Number(report.estimate.contact_extent)),
    ("torque_nmm", |report| Number(report.estimate.torque)),
    ("distance_mm", |report| Number(report.estimate.distance)),
    ("iterations", |report| Integer(report.estimate.iterations.into())),
    ("residual_nmm", |report| Number(report.estimate.residual)),
    ("cost", |report| Integer(report.cost.into())),
    ("finger", |report| Integer(report.finger.into())),
    ("phase", |report| Word(report.phase.word())),
    // Per degree: a radian's worth times π/180.
    ("force_x_per_deg_n", |report| Number(report.estimate.force_per_angle[0].to_radians())),
    ("force_y_per_deg_n", |report| Number(report.estimate.force_per_angle[1].to_radians())),
    ("standard_deviation_n", |report| Number(report.estimate.standard_deviation)),
    ("sensitivity_age", |report| Integer(report.estimate.sensitivity_age.into())),
    // With friction; not a number without, and while an end is not known.
    ("force_interval_low_n", |report| end(report, |interval| interval.magnitude[0])),
    ("force_interval_high_n", |report| end(report, |interval| interval.magnitude[1])),
    ("normal_interval_low_n", |report| end(report, |interval| interval.normal[0])),
    ("normal_interval_high_n", |report| end(report, |interval| interval.normal[1])),
    ("torque_interval_low_nmm", |report| end(report, |interval| interval.torque[0])),
    ("torque_interval_high_nmm", |report| end(report, |interval| interval.torque[1])),
    // While a rib is near its buckling load: the rib, from 1 at the base, and its load; else 0.
    ("loaded_rib", |report| Integer(report.estimate.loaded_rib.map_or(0, |loaded| i64::from(loaded.rib) + 1))),
    ("rib_load_percent", |report| Integer(report.estimate.loaded_rib.map_or(0, |loaded| loaded.percent.into()))),
];

fn end(report: &Report, of: fn(&Interval) -> f32) -> Cell {
    Number(report.estimate.interval.as_ref().map_or(f32::NAN, of))
}

/// Reports as a table of typed columns.
#[derive(Clone, Debug, PartialEq)]
pub struct ReportTable(Table);

impl Default for ReportTable {
    fn default() -> Self {
        let blank = Report::blank(0);
        let column = |(name, cell): &ReportColumn| Column {
            name: (*name).to_owned(),
            values: Values::empty(match cell(&blank) {
                Integer(_) => Kind::Integer,
                Number(_) => Kind::Single,
                Word(_) => Kind::Word,
            }),
        };
        Self(Table { columns: COLUMNS.iter().map(column).collect() })
    }
}

impl ReportTable {
    /// Takes a report, a row.
    pub fn take(&mut self, report: &Report) {
        for (column, (_, cell)) in self.0.columns.iter_mut().zip(&COLUMNS) {
            match (&mut column.values, cell(report)) {
                (Values::Integer(values), Integer(value)) => values.push(Some(value)),
                (Values::Single(values), Number(value)) => values.push(value),
                (Values::Word(values), Word(word)) => values.push(Some(word.to_owned())),
                // A column has one kind of cells.
                _ => {}
            }
        }
    }

    /// The table.
    pub fn table(&self) -> &Table {
        &self.0
    }

    /// The table, to be gone on with by itself.
    pub fn into_table(self) -> Table {
        self.0
    }

    /// Forgets the rows.
    pub fn clear(&mut self) {
        self.0.clear();
    }
}

#[cfg(test)]
mod tests {
    use messages::Report;
    use model_core::estimator::Interval;

    use super::super::Csv;
    use super::{COLUMNS, ReportTable};

    #[test]
    fn the_csv_and_the_table_have_the_same_rows() {
        let (mut csv, mut table) = (Csv::new(Vec::new()).unwrap(), ReportTable::default());
        for finger in 0..3 {
            let mut report = Report { current: 0.1, time_us: 7, ..Report::blank(finger) };
            // Without one these cells are no numbers, which are not equal to themselves.
            report.estimate.interval =
                Some(Interval { magnitude: [4.1, 6.2], normal: [3.9, 6.0], torque: [410.0, 530.0] });
            csv.write(&report).unwrap();
            table.take(&report);
        }
        let text = String::from_utf8(csv.finish().unwrap()).unwrap();
        let names: Vec<&str> = text.lines().next().unwrap().split(',').collect();
        assert_eq!(names, COLUMNS.map(|(name, _)| name));
        let mut again = table.clone();
        again.clear();
        let fills = |line: &str| again.0.take(line);
        assert!(text.lines().skip(1).all(fills));
        assert_eq!(again, table);
        assert_eq!(table.table().rows(), 3);
    }
}
