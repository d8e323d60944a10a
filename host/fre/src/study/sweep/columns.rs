//! A sweep's CSV as typed columns.

use crate::case::Coordinate;
use crate::study::columns::{CSV, Column};
use crate::study::csv::SHAPES;
use crate::table::{Kind, Table};

/// What a column of a sweep holds: its own few, axes, which are numbers, and those of every run.
pub fn kind(column: &str) -> Kind {
    let named = |own: &Column| Coordinate::ALL.iter().any(|&along| own.name(along) == column);
    match column {
        "row" => Kind::Integer,
        "elements" => Kind::Word,
        _ if SHAPES.contains(&column) => Kind::List,
        _ => CSV.iter().find(|own| named(own)).map_or(Kind::Number, Column::kind),
    }
}

/// The rows of a sweep's CSV: the line of column names, then the rows. None if it is something else.
pub fn table(csv: &str) -> Option<Table> {
    let mut lines = csv.lines().filter(|line| !line.starts_with('#'));
    let mut table = Table::new(lines.next()?.split(','), kind);
    lines.all(|line| table.take(line)).then_some(table)
}

/// Rows that are converted at once.
#[cfg(feature = "parquet")]
const AT_ONCE: usize = 1 << 16;

/// Writes the file of a complete sweep as Parquet, with what says which sweep it is. Takes the memory of some ten thousand rows.
///
/// # Errors
/// A file cannot be read or written, or has other rows than a sweep's.
#[cfg(feature = "parquet")]
pub fn write_parquet<W: std::io::Write + Send>(rows: &std::path::Path, out: W) -> Result<W, super::error::SweepError> {
    use std::io::BufRead as _;

    use super::error::SweepError;
    use super::identity::Identity;

    let name = || rows.display().to_string();
    let failed = |source| SweepError::File { file: name(), source };
    let foreign = || SweepError::Part { file: name(), reason: "has a line that is not a row of a sweep".to_owned() };
    let identity = Identity::read(rows)?.and_then(|identity| serde_json::to_string(&identity).ok());
    let mut lines = std::io::BufReader::new(std::fs::File::open(rows).map_err(failed)?)
        .lines()
        .filter(|line| !line.as_ref().is_ok_and(|line| line.starts_with('#')));
    let head = lines.next().ok_or_else(foreign)?.map_err(failed)?;
    let mut table = Table::new(head.split(','), kind);
    let notes: Vec<_> = identity.map(|identity| ("fre.sweep", identity)).into_iter().collect();
    let mut writer = crate::parquet::Writer::new(out, &table, &notes)?;
    for line in lines {
        if !table.take(&line.map_err(failed)?) {
            return Err(foreign());
        }
        if table.rows() == AT_ONCE {
            writer.write(&table)?;
            table.clear();
        }
    }
    writer.write(&table)?;
    Ok(writer.finish()?)
}
