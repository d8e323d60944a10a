//! A table of times and motor positions: read whole before the first force is estimated.

use fre::delimited;
use fre::spreadsheet::{Row, Sheet};
use messages::Calibration;

/// The column of times.
const TIME: &str = "time_s";
/// Columns of which one says where the motor is.
const POSITIONS: [(&str, Unit); 3] =
    [("angle_deg", Unit::Degrees), ("angle_rad", Unit::Radians), ("position_counts", Unit::Counts)];
/// The same for a message.
const ONE_OF: &str = "`angle_deg`, `angle_rad` or `position_counts`";
/// All of them.
const KNOWN: [&str; 4] = [TIME, POSITIONS[0].0, POSITIONS[1].0, POSITIONS[2].0];

#[derive(Clone, Copy)]
enum Unit {
    Degrees,
    Radians,
    Counts,
}

/// A table in which every row has a time and a position.
pub(super) struct Table<'a> {
    /// Its header and its rows, from the first on.
    pub(super) sheet: Sheet<'a>,
    /// Time, s, and the finger's motor angle, rad, of every row. Times grow.
    pub(super) places: Vec<[f64; 2]>,
    /// How a copy of it is written.
    pub(super) style: Style,
}

impl<'a> Table<'a> {
    /// Reads a text, to which columns will be added; `name` is what messages call it.
    ///
    /// # Errors
    /// The line and what is wrong there.
    pub(super) fn read(name: &str, text: &'a str, added: &[&str], calibration: &Calibration) -> Result<Self, String> {
        let sheet = Sheet::new(text, &KNOWN).ok_or_else(|| format!("{name}: it has no text"))?;
        let columns = Columns::find(&sheet, added).map_err(|why| format!("{name}:{}: {why}", sheet.line()))?;
        let mut style = Style::of(sheet.separator());
        let (mut places, mut before) = (Vec::new(), f64::NEG_INFINITY);
        for Row { line, cells } in sheet.clone() {
            let at = |why: String| format!("{name}:{line}: {why}");
            let cells = cells.map_err(at)?;
            let place @ [time, _] = columns.read(&sheet, &cells, calibration).map_err(at)?;
            if time <= before {
                return Err(at(format!("time_s is {time}; allowed is above {before}, that of the line before")));
            }
            before = time;
            places.push(place);
            [columns.time, columns.position].iter().for_each(|column| style.see(&cells[*column]));
        }
        if places.is_empty() {
            return Err(format!("{name}: has no row below its header; needed is at least one"));
        }
        Ok(Self { sheet, places, style })
    }
}

/// Where the columns are.
struct Columns {
    time: usize,
    position: usize,
    name: &'static str,
    unit: Unit,
}

impl Columns {
    fn find(sheet: &Sheet<'_>, added: &[&str]) -> Result<Self, String> {
        if let Some(column) = sheet.repeated(&KNOWN) {
            return Err(format!("there are several columns `{column}`; allowed is one"));
        }
        let found = || sheet.found();
        let time = sheet.column(TIME).ok_or_else(|| format!("no column `{TIME}`; the columns are {}", found()))?;
        let there: Vec<_> =
            POSITIONS.into_iter().filter_map(|(name, unit)| Some((sheet.column(name)?, name, unit))).collect();
        if let Some(there) = added.iter().find(|added| sheet.column(added).is_some()) {
            return Err(format!("there is a column `{there}` already"));
        }
        match there[..] {
            [(position, name, unit)] => Ok(Self { time, position, name, unit }),
            [] => Err(format!("no column {ONE_OF}; the columns are {}", found())),
            _ => Err(format!("several columns of positions; allowed is one of {ONE_OF}")),
        }
    }

    /// Time, s, and the finger's motor angle, rad.
    fn read(&self, sheet: &Sheet<'_>, cells: &[String], calibration: &Calibration) -> Result<[f64; 2], String> {
        let number = |column: usize, name| sheet.number(name, cells.get(column).map_or("", String::as_str));
        let time = number(self.time, TIME)?;
        let position = number(self.position, self.name)?;
        let angle = match self.unit {
            Unit::Degrees => position.to_radians(),
            Unit::Radians => position,
            Unit::Counts if position.fract() != 0.0 || position.abs() > 1_044_479.0 => {
                return Err(format!("position_counts is {position}; allowed are whole numbers to ±1044479"));
            }
            Unit::Counts => calibration.finger_angle(position as i32),
        };
        Ok([time, angle])
    }
}

/// How a table is written: the program that has written it reads its copy, too.
pub(super) struct Style {
    separator: u8,
    commas: bool,
    points: bool,
}

impl Style {
    fn of(separator: char) -> Self {
        let separator = match separator {
            ';' => b';',
            '\t' => b'\t',
            _ => b',',
        };
        Self { separator, commas: false, points: false }
    }

    /// Takes note of how a number is written.
    fn see(&mut self, cell: &str) {
        self.commas |= cell.contains(',');
        self.points |= cell.contains('.');
    }

    /// A number in the table's own way. Whoever separates cells by semicolons needs the comma for decimals.
    pub(super) fn number(&self, cell: String) -> String {
        let comma = match self.separator {
            b',' => false,
            b';' => !self.points,
            _ => self.commas && !self.points,
        };
        if comma { cell.replace('.', ",") } else { cell }
    }

    /// A line with its end.
    pub(super) fn line<Cell: AsRef<[u8]>>(&self, cells: impl IntoIterator<Item = Cell>) -> String {
        delimited::separated(cells, self.separator)
    }
}
