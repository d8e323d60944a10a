//! A sweep's CSV as typed columns.

use crate::study::csv::SHAPES;
use crate::table::{Kind, Table};

/// Columns of whole numbers.
const INTEGERS: [&str; 9] = [
    "row",
    "contacts",
    "iterations",
    "steps",
    "elements_per_beam",
    "elements_per_hinge",
    "unknowns",
    "branch",
    "self_contact",
];
/// Columns of words.
const WORDS: [&str; 5] = ["elements", "status", "scheme", "physics", "precision"];

/// What a column of a sweep holds.
pub fn kind(column: &str) -> Kind {
    let is_in = |names: &[&str]| names.contains(&column);
    match column {
        "beyond_max_strain" => Kind::Flag,
        _ if is_in(&INTEGERS) => Kind::Integer,
        _ if is_in(&WORDS) => Kind::Word,
        _ if is_in(&SHAPES) => Kind::List,
        _ => Kind::Number,
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
