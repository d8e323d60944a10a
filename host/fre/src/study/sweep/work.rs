//! The work of a sweep: its points in parallel, its rows into a file or a stream.

use std::collections::BTreeMap;
use std::io::Write;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, Instant};

use model_core::status::Status;
use rayon::prelude::*;

use super::error::SweepError;
use super::grid::Sweep;
use super::ledger::{self, Known, Ledger};

/// How often progress is reported without news.
const BEAT: Duration = Duration::from_millis(250);
/// Points that are checked between two reports.
const CHECKED_AT_ONCE: usize = 1024;

/// Failures that are listed one by one.
pub const LISTED: usize = 20;

/// How far a sweep is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Points checked and points to check, while none is solved yet.
    pub checked: Option<[usize; 2]>,
    /// Rows known, those of an earlier run included.
    pub done: usize,
    /// All rows.
    pub total: usize,
    /// Rows per second in this run.
    pub rate: f64,
    /// Seconds left at this rate; none before the first row.
    pub left_s: Option<f64>,
}

/// What came of a sweep.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// Number of rows of each status, by its word.
    pub statuses: BTreeMap<&'static str, usize>,
    /// Rows without a trustworthy status.
    pub failures: Vec<(usize, Status)>,
    /// Rows with a part strained beyond the material's limit.
    pub strained: Vec<usize>,
    /// Rows in which the object reaches into a part of the finger that knows no contact.
    pub overlapping: Vec<usize>,
    /// Rows computed in this run.
    pub computed: usize,
    /// Rows taken over from an earlier run.
    pub resumed: usize,
}

impl Tally {
    fn of(rows: &[Option<Known>], computed: usize, resumed: usize) -> Self {
        let mut tally = Self { computed, resumed, ..Self::default() };
        for (row, known) in rows.iter().enumerate() {
            if let Some(known) = known {
                tally.add(row, known);
            }
        }
        tally
    }

    /// Counts a row.
    pub(super) fn add(&mut self, row: usize, known: &Known) {
        let &Known { status, strained, overlaps } = known;
        self.strained.extend(strained.then_some(row));
        self.overlapping.extend(overlaps.then_some(row));
        *self.statuses.entry(status.word()).or_default() += 1;
        if !status.is_trustworthy() {
            self.failures.push((row, status));
        }
    }

    /// True if a row is among those that are listed one by one: the first failures, and the first of each warning.
    pub fn lists(&self, row: usize) -> bool {
        let failures = self.failures.iter().take(LISTED).map(|(row, _)| row);
        failures.chain(self.strained.first()).chain(self.overlapping.first()).any(|listed| *listed == row)
    }
}

/// Where the rows go.
#[derive(Debug)]
enum Rows<'a, W> {
    File(&'a mut Ledger),
    /// In the order of the grid: what comes early waits.
    Stream {
        out: &'a mut W,
        /// The points whose rows are still to come, the next one last.
        next: Vec<usize>,
        waiting: BTreeMap<usize, String>,
        known: Vec<Option<Known>>,
    },
}

/// Runs a sweep with a number of threads (0: one per core), into its file or, without one, into a stream in the order
/// of the grid. All points are checked before the first is solved. `watch` is called a few times per second, and whenever a point
/// is done; it stops the sweep by [`ControlFlow::Break`].
///
/// # Errors
/// A point is not a case, the output cannot be written, or the sweep was stopped.
pub fn run<W: Write>(
    sweep: &Sweep,
    ledger: Option<&mut Ledger>,
    out: &mut W,
    jobs: usize,
    mut watch: impl FnMut(Progress) -> ControlFlow<()>,
) -> Result<Tally, SweepError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(jobs).build()?;
    let resumed = ledger.as_ref().map_or(0, |ledger| ledger.found());
    let todo: Vec<usize> =
        sweep.own_points().filter(|&point| ledger.as_ref().is_none_or(|ledger| !ledger.has(sweep, point))).collect();
    let mut progress = Progress { checked: None, done: resumed, total: sweep.own_rows(), rate: 0.0, left_s: None };
    for (index, points) in todo.chunks(CHECKED_AT_ONCE).enumerate() {
        if let Some(error) = pool.install(|| points.par_iter().find_map_first(|&point| sweep.check(point).err())) {
            if let Some(ledger) = ledger {
                ledger.abandon();
            }
            return Err(error);
        }
        let checked = Some([index * CHECKED_AT_ONCE + points.len(), todo.len()]);
        if watch(Progress { checked, ..progress }).is_break() {
            if let Some(ledger) = ledger {
                ledger.abandon();
            }
            return Err(SweepError::Stopped);
        }
    }
    let mut rows = match ledger {
        Some(ledger) => {
            ledger.begin()?;
            Rows::File(ledger)
        }
        None => {
            out.write_all(ledger::header(sweep).as_bytes()).map_err(stream_failed)?;
            Rows::Stream {
                out,
                next: sweep.own_points().collect::<Vec<_>>().into_iter().rev().collect(),
                waiting: BTreeMap::new(),
                known: vec![None; sweep.rows()],
            }
        }
    };
    let begin = Instant::now();
    let stop = AtomicBool::new(false);
    let (sender, receiver) = mpsc::channel();
    let mut outcome = Ok(());
    std::thread::scope(|scope| {
        let (todo, stop) = (&todo, &stop);
        scope.spawn(move || {
            pool.install(|| {
                todo.par_iter().with_max_len(1).for_each_with(sender, |sender, &point| {
                    if !stop.load(Ordering::Relaxed) {
                        // Nobody listens any more after a failure.
                        let _ = sender.send((point, sweep.solve(point)));
                    }
                });
            });
        });
        loop {
            match receiver.recv_timeout(BEAT) {
                Ok((point, solved)) => {
                    outcome = solved.and_then(|run| match &mut rows {
                        Rows::File(ledger) => {
                            progress.done += ledger.add(sweep, point, &run)?;
                            Ok(())
                        }
                        Rows::Stream { out, next, waiting, known } => {
                            let first = point * sweep.places().len();
                            for (index, place) in run.places.iter().enumerate() {
                                known[first + index] = Some(Known::of(place));
                            }
                            progress.done += run.places.len();
                            waiting.insert(point, ledger::rows(sweep, point, &run).map(|(_, line)| line).collect());
                            while let Some(text) = next.last().and_then(|point| waiting.remove(point)) {
                                out.write_all(text.as_bytes()).map_err(stream_failed)?;
                                next.pop();
                            }
                            Ok(())
                        }
                    });
                    if outcome.is_err() {
                        stop.store(true, Ordering::Relaxed);
                        break;
                    }
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            let seconds = begin.elapsed().as_secs_f64();
            progress.rate = (progress.done - resumed) as f64 / seconds.max(1e-9);
            progress.left_s = (progress.rate > 0.0).then(|| (progress.total - progress.done) as f64 / progress.rate);
            if watch(progress).is_break() {
                stop.store(true, Ordering::Relaxed);
                outcome = Err(SweepError::Stopped);
                break;
            }
        }
    });
    outcome?;
    let computed = progress.done - resumed;
    match rows {
        Rows::File(ledger) => {
            ledger.finish()?;
            Ok(Tally::of(ledger.known(), computed, resumed))
        }
        Rows::Stream { out, known, .. } => {
            out.flush().map_err(stream_failed)?;
            Ok(Tally::of(&known, computed, resumed))
        }
    }
}

fn stream_failed(source: std::io::Error) -> SweepError {
    SweepError::File { file: "standard output".to_owned(), source }
}
