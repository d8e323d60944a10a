//! Runs CalculiX and reads what it wrote.

use std::collections::BTreeMap;
use std::fs::{self, File, TryLockError};
use std::ops::ControlFlow;
use std::path::Path;
use std::process::{Command, ExitStatus};
use std::time::Duration;

use super::error::FeaError;
use super::region::Point;
use crate::lock;

/// The program.
pub const PROGRAM: &str = "ccx";

/// What a `.dat` file holds at whole times.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Printed {
    /// Displacements in the order of the node set, mm.
    pub displacements: BTreeMap<usize, Vec<Point>>,
    /// Reaction forces, summed over the node set, N.
    pub forces: BTreeMap<usize, Point>,
}

/// How often the files of a running program are looked at.
const LOOK: Duration = Duration::from_millis(100);

/// What a `.sta` file says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Steps of the path that have ended.
    pub steps: usize,
    /// Increments that converged.
    pub increments: usize,
    /// Attempts that failed and were repeated with a smaller increment.
    pub failed_attempts: usize,
    /// Iterations of all of them.
    pub iterations: usize,
}

/// Looks for the program, so that without it a run leaves no files.
///
/// # Errors
/// If no folder of the PATH has it.
pub fn find() -> Result<(), FeaError> {
    let program = format!("{PROGRAM}{}", std::env::consts::EXE_SUFFIX);
    let paths = std::env::var_os("PATH").unwrap_or_default();
    let there = std::env::split_paths(&paths).any(|folder| folder.join(&program).is_file());
    if there { Ok(()) } else { Err(FeaError::NoCalculix) }
}

/// Locks a folder, so that no two runs write the same files.
///
/// # Errors
/// If another run has it, or the lock's file cannot be made.
pub fn lock(folder: &Path, job: &str) -> Result<File, FeaError> {
    let path = folder.join(format!("{job}.lock"));
    let io = |source| FeaError::Io { file: path.display().to_string(), source };
    let file = File::options().read(true).write(true).create(true).truncate(true).open(&path).map_err(io)?;
    match lock::patiently(&file) {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(FeaError::Busy { folder: folder.display().to_string() }),
        Err(TryLockError::Error(source)) => Err(io(source)),
    }
}

/// Runs the deck `job.inp` in a folder and returns how the program ended. The program gets the lock's empty file as its standard input:
/// should it outlive us, the folder stays locked until it ends. A run that ends early is not an error: what it reached is
/// in its files. `watch` is called many times a second with the steps of the path that have ended; it ends the program by
/// [`ControlFlow::Break`].
///
/// # Errors
/// If the program is missing or cannot be started, or was stopped.
pub fn run(
    folder: &Path,
    job: &str,
    lock: &File,
    watch: &mut dyn FnMut(usize) -> ControlFlow<()>,
) -> Result<ExitStatus, FeaError> {
    let io = |source| FeaError::Io { file: folder.display().to_string(), source };
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let log = File::create(folder.join(format!("{job}.log"))).map_err(io)?;
    let child = Command::new(PROGRAM)
        .arg(job)
        .current_dir(folder)
        .env("OMP_NUM_THREADS", threads.to_string())
        .stdin(lock.try_clone().map_err(io)?)
        .stdout(log.try_clone().map_err(io)?)
        .stderr(log)
        .spawn();
    let failed = |source| FeaError::Io { file: PROGRAM.to_owned(), source };
    let mut child = match child {
        Ok(child) => child,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Err(FeaError::NoCalculix),
        Err(source) => return Err(failed(source)),
    };
    let sta = folder.join(format!("{job}.sta"));
    loop {
        if let Some(status) = child.try_wait().map_err(failed)? {
            return Ok(status);
        }
        let steps = fs::read_to_string(&sta).map_or(0, |text| parse_sta(&text).steps);
        if watch(steps).is_break() {
            // It may have ended by itself meanwhile.
            let _ = child.kill();
            child.wait().map_err(failed)?;
            return Err(FeaError::Stopped);
        }
        std::thread::sleep(LOOK);
    }
}

/// The first error in the program's log.
pub fn complaint(folder: &Path, job: &str) -> Option<String> {
    let log = fs::read_to_string(folder.join(format!("{job}.log"))).ok()?;
    let mut lines = log.lines().map(str::trim);
    let first = lines.find(|line| line.starts_with("*ERROR"))?;
    let rest = lines.take(2).take_while(|line| !line.is_empty()).collect::<Vec<_>>().join(" ");
    Some(format!("{first} {rest}").trim().to_owned())
}

/// Reads a `.dat` file. Every step ends at a whole time; blocks at other times are left out. What is written as no number (NaN, or
/// a field full of asterisks) is read as such. Where the file ends in the middle
/// of a line, the program was stopped: what is before it holds.
///
/// # Errors
/// Naming the line that is not as expected.
pub fn parse_dat(text: &str) -> Result<Printed, FeaError> {
    enum Block {
        Displacements(usize),
        Force(usize),
    }
    let mut printed = Printed::default();
    let mut block = None;
    let whole = text.rfind('\n').map_or("", |end| &text[..end]);
    for (index, line) in whole.lines().enumerate() {
        let bad = || FeaError::Output { file: "dat", line: index + 1, text: line.trim().to_owned() };
        let fields: Vec<&str> = line.split_whitespace().collect();
        if fields.is_empty() {
            continue;
        }
        if let Some((what, time)) = line.split_once("and time") {
            let time: f64 = time.trim().parse().map_err(|_| bad())?;
            let step = time.round();
            block = ((time - step).abs() < 1e-6 && step >= 1.0).then_some(step as usize).and_then(|step| {
                if what.contains("displacements") {
                    printed.displacements.insert(step, Vec::new());
                    Some(Block::Displacements(step))
                } else {
                    what.contains("total force").then_some(Block::Force(step))
                }
            });
            continue;
        }
        // Fortran prints asterisks for a number that does not fit its columns: none, as NaN is.
        let value = |text: &str| if text.starts_with('*') { Ok(f64::NAN) } else { text.parse::<f64>() };
        let number = |field: usize| fields.get(field).and_then(|text| value(text).ok()).ok_or_else(bad);
        match block {
            Some(Block::Displacements(step)) => {
                let point = [number(1)?, number(2)?];
                printed.displacements.entry(step).or_default().push(point);
            }
            Some(Block::Force(step)) => {
                printed.forces.insert(step, [number(0)?, number(1)?]);
                block = None;
            }
            None => {}
        }
    }
    Ok(printed)
}

/// Reads a `.sta` file: step, increment, attempt (followed by U if it failed), iterations, times.
pub fn parse_sta(text: &str) -> Effort {
    let mut effort = Effort::default();
    for line in text.lines() {
        let fields: Vec<&str> = line.split_whitespace().collect();
        if fields.len() < 4 || fields[0].parse::<usize>().is_err() {
            continue;
        }
        // The mark stands behind the attempt's number, with or without a blank.
        let failed = fields[2].ends_with('U') || fields[3] == "U";
        let iterations = if fields[3] == "U" { fields.get(4) } else { fields.get(3) };
        effort.iterations += iterations.and_then(|text| text.parse::<usize>().ok()).unwrap_or(0);
        if failed {
            effort.failed_attempts += 1;
        } else {
            effort.increments += 1;
            // The time since the beginning is the third number from the end. Every step takes one unit of it.
            let time = fields.iter().rev().nth(2).and_then(|text| text.parse::<f64>().ok());
            effort.steps = time.map_or(effort.steps, |time| (time + 1e-6) as usize);
        }
    }
    effort
}
