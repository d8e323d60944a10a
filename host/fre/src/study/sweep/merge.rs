//! The shards of a sweep as one file, which is that of the whole sweep.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufRead as _, BufReader, Write};
use std::path::{Path, PathBuf};

use super::error::SweepError;
use super::identity::Identity;
use super::ledger::Known;
use super::shard::Shard;
use super::work::Tally;
use crate::case::Coordinate;

/// A shard's file, read line by line.
struct Part {
    path: PathBuf,
    reader: BufReader<File>,
    /// The next row: its number and its line.
    next: Option<(usize, String)>,
}

impl Part {
    fn advance(&mut self) -> Result<(), SweepError> {
        let mut line = String::new();
        let failed = |source| SweepError::File { file: self.path.display().to_string(), source };
        self.reader.read_line(&mut line).map_err(failed)?;
        self.next = if line.is_empty() {
            None
        } else {
            let number = line.split(',').next().and_then(|word| word.parse().ok()).filter(|_| line.ends_with('\n'));
            let number = number.ok_or_else(|| foreign(&self.path, "has a line that is not a whole row"))?;
            Some((number, line))
        };
        Ok(())
    }
}

fn foreign(path: &Path, reason: impl Into<String>) -> SweepError {
    SweepError::Part { file: path.display().to_string(), reason: reason.into() }
}

/// What came of all shards together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Merged {
    /// Rows of the whole sweep.
    pub rows: usize,
    /// What came of them.
    pub tally: Tally,
    /// Point and place of those that are listed one by one.
    places: BTreeMap<usize, String>,
}

impl Merged {
    /// Point and place of a row that is listed: "object.radius_mm=20 at 8°".
    pub fn place(&self, row: usize) -> &str {
        self.places.get(&row).map_or("", String::as_str)
    }

    /// Counts a row; `None` if it is not a sweep's.
    fn add(&mut self, row: usize, line: &str, columns: &[&str], axes: usize) -> Option<()> {
        let cells: Vec<&str> = line.trim_end().split(',').collect();
        self.tally.add(row, &Known::read(columns, &cells)?);
        if self.tally.lists(row) {
            let mut named = columns.iter().zip(&cells);
            let point: Vec<String> =
                named.by_ref().skip(1).take(axes).map(|(key, cell)| format!("{key}={cell}")).collect();
            let along = |name: &str| Coordinate::ALL.into_iter().find(|along| along.column() == name);
            let (along, cell) = named.find_map(|(name, cell)| Some((along(name)?, cell)))?;
            let point = point.join(" ");
            let before = if point.is_empty() { "" } else { " at " };
            self.places.insert(row, format!("{point}{before}{cell}{}", along.unit()));
        }
        Some(())
    }
}

/// Which sweep a set of files of rows is the whole of.
#[derive(Debug)]
pub struct Merge {
    paths: Vec<PathBuf>,
    identity: Identity,
}

impl Merge {
    /// Takes the files of all shards of one sweep, in any order.
    ///
    /// # Errors
    /// A file that is none of a sweep's, shards of several sweeps, or a shard that is missing or there twice.
    pub fn of(paths: &[PathBuf]) -> Result<Self, SweepError> {
        let mut whole: Option<(Identity, usize)> = None;
        let mut found: Vec<(Shard, PathBuf)> = Vec::new();
        for path in paths {
            let identity = Identity::read(path)?.ok_or_else(|| foreign(path, "has no .sweep file beside it"))?;
            let shard = identity.shard.ok_or_else(|| foreign(path, "is a whole sweep, not a shard"))?;
            let identity = Identity { shard: None, ..identity };
            let (first, count) = whole.get_or_insert_with(|| (identity.clone(), shard.of()));
            if let Some(difference) = identity.difference(first) {
                return Err(foreign(path, format!("{difference} (beside {})", paths[0].display())));
            }
            if shard.of() != *count {
                return Err(foreign(path, format!("is shard {shard}; {} is one of {count}", paths[0].display())));
            }
            if let Some((_, other)) = found.iter().find(|(other, _)| *other == shard) {
                return Err(foreign(path, format!("is shard {shard}, as {} is", other.display())));
            }
            found.push((shard, path.clone()));
        }
        let (identity, count) = whole.ok_or_else(|| foreign(Path::new("merge"), "needs the files of shards"))?;
        let missing: Vec<String> = (1..=count)
            .filter(|number| found.iter().all(|(shard, _)| shard.number() != *number))
            .map(|number| format!("{number}/{count}"))
            .collect();
        if !missing.is_empty() {
            return Err(foreign(&paths[0], format!("needs all shards beside it; missing is {}", missing.join(", "))));
        }
        Ok(Self { paths: found.into_iter().map(|(_, path)| path).collect(), identity })
    }

    /// Writes the rows of all files in their order, to be followed by [`Self::name`]; gives what came of them.
    ///
    /// # Errors
    /// A file cannot be read or written, or a shard is not complete.
    pub fn write(&self, out: &mut impl Write) -> Result<Merged, SweepError> {
        let written = |source| SweepError::File { file: "the merged rows".to_owned(), source };
        let (mut parts, mut head) = (Vec::new(), None);
        for path in &self.paths {
            let failed = |source| SweepError::File { file: path.display().to_string(), source };
            let mut reader = BufReader::new(File::open(path).map_err(failed)?);
            let mut line = String::new();
            reader.read_line(&mut line).map_err(failed)?;
            if head.get_or_insert_with(|| line.clone()) != &line {
                return Err(foreign(path, "has other columns than the other shards"));
            }
            let mut part = Part { path: path.clone(), reader, next: None };
            part.advance()?;
            parts.push(part);
        }
        let head = head.unwrap_or_default();
        let columns: Vec<&str> = head.trim_end().split(',').collect();
        let mut merged = Merged { rows: self.identity.rows, ..Merged::default() };
        out.write_all(head.as_bytes()).map_err(written)?;
        for row in 0..self.identity.rows {
            let Some(part) = parts.iter_mut().find(|part| part.next.as_ref().is_some_and(|(next, _)| *next == row))
            else {
                return Err(SweepError::Incomplete { row });
            };
            if let Some((_, line)) = part.next.take() {
                let known = merged.add(row, &line, &columns, self.identity.axes.len());
                known.ok_or_else(|| foreign(&part.path, format!("has no status in row {row}")))?;
                out.write_all(line.as_bytes()).map_err(written)?;
            }
            part.advance()?;
        }
        if let Some(part) = parts.iter().find(|part| part.next.is_some()) {
            return Err(foreign(&part.path, "has rows that are not of this sweep, or twice"));
        }
        Ok(merged)
    }

    /// Names the sweep beside the file that the rows were written to, as [`super::Ledger`] does: it goes on there, finding all rows.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn name(&self, rows: &Path) -> Result<(), SweepError> {
        self.identity.write(rows)
    }
}
