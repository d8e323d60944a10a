//! A run as CSV: one line per place.

use crate::case::Along;
use crate::study::columns::{CSV, Cell};
use crate::study::run::Run;

/// The names of the columns.
pub fn head(along: Along) -> Vec<String> {
    CSV.iter().map(|column| column.name(along)).collect()
}

/// The values of the columns, place by place. What is not known is empty.
pub fn records(run: &Run) -> impl Iterator<Item = Vec<String>> {
    run.places.iter().map(|place| CSV.iter().map(|column| Cell::csv(column.value(run, place))).collect())
}

/// Head and lines.
pub fn csv(run: &Run) -> String {
    let Some(first) = run.places.first() else { return String::new() };
    std::iter::once(head(first.at.along())).chain(records(run)).map(|record| line(&record)).collect()
}

/// One line with its end; cells that need quotes have them.
pub fn line(record: &[String]) -> String {
    let mut writer = ::csv::WriterBuilder::new().flexible(true).from_writer(Vec::new());
    // Writing to memory cannot fail.
    let _ = writer.write_record(record);
    writer.into_inner().ok().and_then(|bytes| String::from_utf8(bytes).ok()).unwrap_or_default()
}
