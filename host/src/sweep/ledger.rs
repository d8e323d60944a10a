//! The CSV file of a sweep. Lines are only ever appended, whole; what a killed sweep has left behind is read again.
//!
//! The first line names the sweep by a hash of its case, arguments and program version; the second names the columns.
//! Rows stand in the order in which they were found until the sweep is complete; then the file is sorted.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use model_core::object::Motion;
use model_core::status::Status;

use super::{Sweep, SweepError};
use crate::report;
use crate::run::{Model, Precision, Solution};

/// The rows of a sweep that are known, and the file that holds them.
#[derive(Debug)]
pub struct Ledger {
    path: PathBuf,
    file: File,
    /// Status of every row by its number; none if it is not yet known.
    statuses: Vec<Option<Status>>,
    /// Rows that the file held when it was opened.
    found: usize,
}

impl Ledger {
    /// Opens a sweep's file, or makes it. A torn last line is cut off.
    ///
    /// # Errors
    /// The file belongs to another sweep or to something else, is being written, or cannot be read or written.
    pub fn open(path: &Path, sweep: &Sweep) -> Result<Self, SweepError> {
        let name = path.display().to_string();
        let failed = |source| SweepError::File { file: name.clone(), source };
        let foreign = |reason: String| SweepError::Foreign { file: name.clone(), reason };
        let mut file =
            OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path).map_err(failed)?;
        let begin = Instant::now();
        loop {
            match file.try_lock() {
                Ok(()) => break,
                // A child between its fork and its exec holds its parent's lock for a moment.
                Err(TryLockError::WouldBlock) if begin.elapsed() < PATIENCE => std::thread::sleep(PATIENCE / 50),
                Err(TryLockError::WouldBlock) => return Err(SweepError::Busy { file: name }),
                Err(TryLockError::Error(source)) => return Err(failed(source)),
            }
        }
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(failed)?;
        let header = header(sweep);
        let mut ledger = Self { path: path.to_owned(), file, statuses: vec![None; sweep.rows()], found: 0 };
        let Some(rows) = bytes.strip_prefix(header.as_bytes()) else {
            // The very beginning may be torn as well.
            if !header.as_bytes().starts_with(&bytes) {
                return Err(foreign(if bytes.starts_with(MAGIC.as_bytes()) {
                    "holds a sweep of another case or with other arguments".to_owned()
                } else {
                    "is not the output of a sweep".to_owned()
                }));
            }
            ledger.restart(&header).map_err(failed)?;
            return Ok(ledger);
        };
        let whole = rows.iter().rposition(|&byte| byte == b'\n').map_or(0, |last| last + 1);
        let columns = header.lines().last().map_or(0, |line| line.split(',').count());
        let lines = rows[..whole].split_inclusive(|&byte| byte == b'\n');
        for (index, line) in lines.enumerate() {
            let bad = || foreign(format!("line {} is no row of this sweep", index + 3));
            let line = std::str::from_utf8(line).map_err(|_| bad())?.trim_end_matches('\n');
            let (row, status) = read_row(line, columns, sweep).ok_or_else(bad)?;
            let place = ledger.statuses.get_mut(row).filter(|place| place.is_none()).ok_or_else(bad)?;
            *place = Some(status);
            ledger.found += 1;
        }
        let length = (header.len() + whole) as u64;
        ledger.file.set_len(length).map_err(failed)?;
        ledger.file.seek(SeekFrom::Start(length)).map_err(failed)?;
        Ok(ledger)
    }

    fn restart(&mut self, header: &str) -> std::io::Result<()> {
        self.file.set_len(0)?;
        self.file.seek(SeekFrom::Start(0))?;
        self.file.write_all(header.as_bytes())
    }

    /// Rows that the file held when it was opened.
    pub fn found(&self) -> usize {
        self.found
    }

    /// Status of every row, none where it is not yet known.
    pub fn statuses(&self) -> &[Option<Status>] {
        &self.statuses
    }

    /// True if every row of a point is known.
    pub fn has(&self, sweep: &Sweep, point: usize) -> bool {
        let count = sweep.places().len();
        self.statuses.iter().skip(point * count).take(count).all(Option::is_some)
    }

    /// Appends those rows of a point that are not yet known; gives their number.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn add(&mut self, sweep: &Sweep, point: usize, solutions: &[Solution]) -> Result<usize, SweepError> {
        let first = point * sweep.places().len();
        let (mut text, mut count) = (String::new(), 0);
        for ((row, line), solution) in rows(sweep, point, solutions).zip(solutions) {
            let place = self.statuses.get_mut(first + row).filter(|place| place.is_none());
            if let Some(place) = place {
                *place = Some(solution.status);
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
        let rows = lines.get_mut(2..).unwrap_or_default();
        if rows.is_sorted_by_key(number) {
            return Ok(());
        }
        rows.sort_by_key(number);
        let mut beside = self.path.clone().into_os_string();
        beside.push(".sorted");
        std::fs::write(&beside, lines.concat()).map_err(failed)?;
        std::fs::rename(&beside, &self.path).map_err(failed)
    }
}

/// How long a lock is waited for.
const PATIENCE: Duration = Duration::from_millis(500);

const MAGIC: &str = "# fre sweep ";

/// The first two lines of a sweep's file.
pub(super) fn header(sweep: &Sweep) -> String {
    let nothing = Solution {
        status: Status::NoContact,
        motor_angle_deg: matches!(sweep.motion, Motion::Rotating { .. }).then_some(0.0),
        distance_mm: matches!(sweep.motion, Motion::Translating { .. }).then_some(0.0),
        force_n: None,
        force_magnitude_n: None,
        force_finger_frame_n: None,
        motor_torque_nmm: None,
        energy_nmm: None,
        gap_mm: None,
        tip_mm: None,
        front_mm: Vec::new(),
        back_mm: Vec::new(),
        lamellae_mm: Vec::new(),
        contacts: Vec::new(),
        max_strain: None,
        sensitivity: None,
        iterations: 0,
        steps: 0,
        elapsed_us: 0.0,
        model: Model {
            scheme: String::new(),
            elements_per_beam: 0,
            elements_per_hinge: 0,
            unknowns: 0,
            physics: String::new(),
            precision: Precision::F64,
        },
        branch: None,
        first_branch: None,
        contact_pressure: Vec::new(),
        strains: None,
        beyond_max_strain: None,
    };
    let csv = report::csv(&[nothing]);
    let axes: String = sweep.axes.iter().map(|axis| format!("{},", axis.name())).collect();
    let columns = csv.lines().next().unwrap_or_default();
    format!(
        "{MAGIC}{} {:016x}: {} points, {} rows; to be read from the next line on\nrow,{axes}{columns}\n",
        env!("CARGO_PKG_VERSION"),
        fnv(sweep.identity().as_bytes()),
        sweep.points(),
        sweep.rows()
    )
}

/// The rows of a point: their number within the point, and their line.
pub(super) fn rows(sweep: &Sweep, point: usize, solutions: &[Solution]) -> impl Iterator<Item = (usize, String)> {
    let first = point * sweep.places().len();
    let words: String = sweep.words(point).iter().map(|word| format!("{word},")).collect();
    let csv = report::csv(solutions);
    let lines: Vec<String> = csv.lines().skip(1).map(str::to_owned).collect();
    lines.into_iter().enumerate().map(move |(row, line)| (row, format!("{},{words}{line}\n", first + row)))
}

/// Number and status of a row; none if it is not one of this sweep's.
fn read_row(line: &str, columns: usize, sweep: &Sweep) -> Option<(usize, Status)> {
    let cells: Vec<&str> = line.split(',').collect();
    if cells.len() != columns {
        return None;
    }
    let row: usize = cells[0].parse().ok()?;
    let axes = sweep.axes.len();
    let fits = row < sweep.rows() && sweep.words(row / sweep.places().len()) == cells[1..=axes];
    let word = cells.get(1 + axes)?;
    let status = STATUSES.into_iter().find(|status| status.word() == *word)?;
    fits.then_some((row, status))
}

const STATUSES: [Status; 10] = [
    Status::Converged,
    Status::Tracking,
    Status::NoContact,
    Status::Snapped,
    Status::MaxIterations,
    Status::Stagnated,
    Status::Folded,
    Status::ContactCapacity,
    Status::OutOfRange,
    Status::Stale,
];

/// The FNV-1a hash of 64 bits (Fowler, Noll, Vo): short, and the same on every machine.
fn fnv(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_hash_is_fnv_1a() {
        assert_eq!(super::fnv(b""), 0xcbf2_9ce4_8422_2325);
        assert_eq!(super::fnv(b"a"), 0xaf63_dc4c_8601_ec8c);
    }
}
