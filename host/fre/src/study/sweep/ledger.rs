//! The CSV file of a sweep. Lines are only ever appended, whole; what a killed sweep has left behind is read again.
//!
//! The first line names the columns; a file beside it says which sweep it is ([`super::identity`]). Rows are in the order in which
//! they were found until the sweep is complete; then the file is sorted.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{ErrorKind, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

use model_core::status::Status;
use serde::Deserialize as _;
use serde::de::IntoDeserializer as _;

use super::error::SweepError;
use super::grid::Sweep;
use super::identity::{Identity, MAGIC, beside};
use crate::delimited::line;
use crate::lock;
use crate::study::csv;
use crate::study::place::Place;
use crate::study::run::Run;

/// What a sweep keeps in mind of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Known {
    /// Its status.
    pub status: Status,
    /// True if a part is strained beyond the material's limit; false as well where the limit is not given.
    pub strained: bool,
    /// True if the object reaches into a part of the finger that knows no contact.
    pub overlaps: bool,
}

impl Known {
    /// Of a place.
    pub fn of(place: &Place) -> Self {
        Self { status: place.status, strained: place.is_overstrained(), overlaps: place.overlap_mm.is_some() }
    }

    /// Of a row's cells; none if it has no status.
    pub(super) fn read(columns: &[&str], cells: &[&str]) -> Option<Self> {
        let cell = |column: &str| {
            let at = columns.iter().position(|name| *name == column)?;
            cells.get(at).copied()
        };
        Some(Self {
            status: status_of(cell("status")?)?,
            strained: cell("beyond_max_strain") == Some("true"),
            overlaps: cell("overlap_mm").is_some_and(|cell| !cell.is_empty()),
        })
    }
}

/// The rows of a sweep that are known, and the file that holds them.
#[derive(Debug)]
pub struct Ledger {
    path: PathBuf,
    file: File,
    /// What is known of every row by its number.
    known: Vec<Option<Known>>,
    /// Rows that the file held when it was opened.
    found: usize,
    /// The line of the columns, until it is in the file.
    header: Option<String>,
    /// Which sweep it is.
    identity: Identity,
    /// Lines before the first row: one, or two in a file of an earlier version.
    before: usize,
    /// True for a file that was not there before.
    made: bool,
}

impl Ledger {
    /// The file beside a sweep's file that says which sweep it is.
    pub fn beside(path: &Path) -> PathBuf {
        beside(path)
    }

    /// Opens a sweep's file, or makes it. Nothing is written before [`Self::begin`].
    ///
    /// # Errors
    /// The file belongs to another sweep or to something else, is being written, or cannot be read or written.
    pub fn open(path: &Path, sweep: &Sweep) -> Result<Self, SweepError> {
        let name = path.display().to_string();
        let failed = |source| SweepError::File { file: name.clone(), source };
        let foreign = |reason: String| SweepError::Foreign { file: name.clone(), reason };
        let mut options = OpenOptions::new();
        options.read(true).write(true);
        let (mut file, made) = match options.create_new(true).open(path) {
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {
                (options.create_new(false).open(path).map_err(failed)?, false)
            }
            made => (made.map_err(failed)?, true),
        };
        if !file.metadata().map_err(failed)?.is_file() {
            return Err(SweepError::NoFile { file: name });
        }
        lock::patiently(&file).map_err(|error| match error {
            TryLockError::WouldBlock => SweepError::Busy { file: name.clone() },
            TryLockError::Error(source) => failed(source),
        })?;
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(failed)?;
        let identity = Identity::of(sweep);
        let columns = header(sweep);
        // What an earlier version has begun is continued as it is.
        let earlier = bytes.starts_with(MAGIC.as_bytes());
        let header = if earlier { identity.first_line() + &columns } else { columns.clone() };
        let before = if earlier { 2 } else { 1 };
        let known = vec![None; sweep.rows()];
        let mut ledger = Self { path: path.to_owned(), file, known, found: 0, header: None, identity, before, made };
        let written =
            if earlier { Identity::of_first_lines(&String::from_utf8_lossy(&bytes)) } else { Identity::read(path)? };
        // Nothing is in it yet, or its very beginning is torn.
        if bytes.is_empty() || (written.is_none() && columns.as_bytes().starts_with(&bytes)) {
            ledger.header = Some(header);
            let side = beside(path);
            if written.is_none() && !earlier && side.exists() {
                ledger.abandon();
                return Err(foreign(format!("{} beside it does not belong to a sweep", side.display())));
            }
            return Ok(ledger);
        }
        let Some(written) = written else {
            let first = bytes.split(|&byte| byte == b'\n').next() == columns.trim_end().as_bytes().into();
            let side = beside(path);
            return Err(foreign(if first {
                format!("has the rows of a sweep, and {} does not say of which", side.display())
            } else {
                "is not the output of a sweep".to_owned()
            }));
        };
        if let Some(difference) = written.difference(&ledger.identity) {
            return Err(foreign(difference));
        }
        let Some(rows) = bytes.strip_prefix(header.as_bytes()) else {
            if !header.as_bytes().starts_with(&bytes) {
                return Err(foreign("holds another sweep: it has other columns".to_owned()));
            }
            ledger.header = Some(header);
            return Ok(ledger);
        };
        let whole = rows.iter().rposition(|&byte| byte == b'\n').map_or(0, |last| last + 1);
        let columns: Vec<&str> = columns.trim_end().split(',').collect();
        let lines = rows[..whole].split_inclusive(|&byte| byte == b'\n');
        for (index, line) in lines.enumerate() {
            let bad = || foreign(format!("line {} is not a row of this sweep", index + before + 1));
            let line = std::str::from_utf8(line).map_err(|_| bad())?.trim_end_matches('\n');
            let (row, known) = read_row(line, &columns, sweep).ok_or_else(bad)?;
            let place = ledger.known.get_mut(row).filter(|place| place.is_none()).ok_or_else(bad)?;
            *place = Some(known);
            ledger.found += 1;
        }
        // A torn last line is cut off; so far nothing else than what was there is in the file.
        let length = (header.len() + whole) as u64;
        ledger.file.set_len(length).map_err(failed)?;
        ledger.file.seek(SeekFrom::Start(length)).map_err(failed)?;
        Ok(ledger)
    }

    /// Says which sweep the file is, and writes the first line of one that has none yet.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn begin(&mut self) -> Result<(), SweepError> {
        let Some(header) = self.header.take() else { return Ok(()) };
        let mut write = || {
            self.file.set_len(0)?;
            self.file.seek(SeekFrom::Start(0))?;
            self.file.write_all(header.as_bytes())
        };
        if self.before == 1 {
            self.identity.write(&self.path)?;
        }
        write().map_err(|source| SweepError::File { file: self.path.display().to_string(), source })
    }

    /// Removes the file again if it was not there before and nothing is in it: a refused sweep leaves nothing behind.
    pub fn abandon(&mut self) {
        if self.made && self.header.is_some() {
            // What cannot be removed is empty, and as good as not there.
            let _ = std::fs::remove_file(&self.path);
        }
    }

    /// Rows that the file held when it was opened.
    pub fn found(&self) -> usize {
        self.found
    }

    /// What is known of every row by its number.
    pub fn known(&self) -> &[Option<Known>] {
        &self.known
    }

    /// True if every row of a point is known.
    pub fn has(&self, sweep: &Sweep, point: usize) -> bool {
        let count = sweep.places().len();
        self.known.iter().skip(point * count).take(count).all(Option::is_some)
    }

    /// Appends those rows of a point that are not yet known; gives their number.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn add(&mut self, sweep: &Sweep, point: usize, run: &Run) -> Result<usize, SweepError> {
        let first = point * sweep.places().len();
        let (mut text, mut count) = (String::new(), 0);
        for ((row, line), place) in rows(sweep, point, run).zip(&run.places) {
            let known = self.known.get_mut(first + row).filter(|known| known.is_none());
            if let Some(known) = known {
                *known = Some(Known::of(place));
                text.push_str(&line);
                count += 1;
            }
        }
        self.file
            .write_all(text.as_bytes())
            .map_err(|source| SweepError::File { file: self.path.display().to_string(), source })?;
        Ok(count)
    }

    /// Sorts the rows of a complete sweep. The file is replaced at once: at any time it holds all rows.
    ///
    /// # Errors
    /// A file cannot be read or written.
    pub fn finish(&mut self) -> Result<(), SweepError> {
        let failed = |source| SweepError::File { file: self.path.display().to_string(), source };
        let mut text = String::new();
        self.file.seek(SeekFrom::Start(0)).map_err(failed)?;
        self.file.read_to_string(&mut text).map_err(failed)?;
        let mut lines: Vec<&str> = text.split_inclusive('\n').collect();
        let number = |line: &&str| line.split(',').next().and_then(|word| word.parse::<usize>().ok());
        let rows = lines.get_mut(self.before..).unwrap_or_default();
        if rows.is_sorted_by_key(number) {
            return Ok(());
        }
        rows.sort_by_key(number);
        // Of a link, what it leads to is replaced.
        let path = std::fs::canonicalize(&self.path).map_err(failed)?;
        let unsorted = |source| SweepError::Unsorted { file: self.path.display().to_string(), source };
        let replace = || {
            let mut beside = tempfile::NamedTempFile::new_in(path.parent().unwrap_or(Path::new(".")))?;
            lines.iter().try_for_each(|line| beside.write_all(line.as_bytes()))?;
            // Whoever might read the rows still may.
            beside.as_file().set_permissions(self.file.metadata()?.permissions())?;
            beside.persist(&path).map_err(|error| error.error)
        };
        replace().map(drop).map_err(unsorted)
    }
}

/// The first line of a sweep's file: the names of its columns.
pub(super) fn header(sweep: &Sweep) -> String {
    let axes = sweep.axes.iter().map(|axis| axis.name().to_owned());
    let shapes = if sweep.shapes { csv::SHAPES.map(str::to_owned).to_vec() } else { Vec::new() };
    line(std::iter::once("row".to_owned()).chain(axes).chain(csv::head(sweep.path.along())).chain(shapes))
}

/// The rows of a point: their number within the point, and their line.
pub(super) fn rows(sweep: &Sweep, point: usize, run: &Run) -> impl Iterator<Item = (usize, String)> {
    let first = point * sweep.places().len();
    let words = sweep.words(point);
    let shapes = sweep.shapes;
    csv::records(run).zip(&run.places).enumerate().map(move |(row, (values, place))| {
        let shape = if shapes { csv::shape(place).to_vec() } else { Vec::new() };
        let number = (first + row).to_string();
        (row, line(std::iter::once(number).chain(words.iter().cloned()).chain(values).chain(shape)))
    })
}

/// The status that a word names.
pub(super) fn status_of(word: &str) -> Option<Status> {
    let word: serde::de::value::StrDeserializer<'_, serde::de::value::Error> = word.into_deserializer();
    Status::deserialize(word).ok()
}

/// Number of a row, and what is kept in mind of it; none if it is not one of this sweep's.
fn read_row(line: &str, columns: &[&str], sweep: &Sweep) -> Option<(usize, Known)> {
    let cells: Vec<&str> = line.split(',').collect();
    if cells.len() != columns.len() {
        return None;
    }
    let row: usize = cells[0].parse().ok()?;
    let axes = sweep.axes.len();
    let fits = row < sweep.rows()
        && sweep.has(row / sweep.places().len())
        && sweep.words(row / sweep.places().len()) == cells[1..=axes];
    let known = Known::read(columns, &cells)?;
    fits.then_some((row, known))
}
