//! Reports as a table of comma-separated values: every report, a row each.

use std::io::{self, Write};

use messages::Report;

use super::columns::COLUMNS;

/// A table of reports.
#[derive(Debug)]
pub struct Csv<W: Write>(W);

impl<W: Write> Csv<W> {
    /// Begins it with its header.
    ///
    /// # Errors
    /// The file's.
    pub fn new(mut out: W) -> io::Result<Self> {
        writeln!(out, "{}", COLUMNS.map(|(name, _)| name).join(","))?;
        Ok(Self(out))
    }

    /// One row. Numbers have the digits that single precision needs.
    ///
    /// # Errors
    /// The file's.
    pub fn write(&mut self, report: &Report) -> io::Result<()> {
        for (index, (_, cell)) in COLUMNS.iter().enumerate() {
            let comma = if index == 0 { "" } else { "," };
            write!(self.0, "{comma}{}", cell(report))?;
        }
        writeln!(self.0)
    }

    /// Writes what is left.
    ///
    /// # Errors
    /// The file's.
    pub fn finish(mut self) -> io::Result<W> {
        self.0.flush()?;
        Ok(self.0)
    }
}
