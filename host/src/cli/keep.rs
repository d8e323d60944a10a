//! What a command keeps of what it watches, in a thread of its own: a slow screen loses no report to a file.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::thread::JoinHandle;
use std::time::Duration;

use crate::record::Csv;
use crate::source::{Source, Told};

/// Messages that wait for a disk: half a minute of four fingers at 500 Hz.
const WAITING: usize = 1 << 16;
/// How often a thread looks whether it is still wanted.
const GLANCE: Duration = Duration::from_millis(50);

/// What is kept.
#[derive(Debug, clap::Args)]
pub struct KeepArgs {
    /// Writes every report to a CSV file
    #[arg(long, value_name = "FILE")]
    log: Option<PathBuf>,
    /// Records every estimate and event to an MCAP file, which Foxglove opens and `fre replay` plays (needs a build with
    /// `--features record`)
    #[arg(long, value_name = "FILE.mcap")]
    record: Option<PathBuf>,
}

impl KeepArgs {
    /// Begins to keep what this source tells.
    ///
    /// # Errors
    /// A file that cannot be written, or a gripper that does not answer.
    pub fn start(&self, source: &Arc<dyn Source>) -> Result<Keeping, Box<dyn std::error::Error>> {
        let stop = Arc::new(AtomicBool::new(false));
        let mut threads = Vec::new();
        if let Some(path) = &self.log {
            let mut csv = Csv::new(BufWriter::new(create(path)?))?;
            let (told, stop, name) = (source.hear(WAITING), stop.clone(), path.display().to_string());
            threads.push(std::thread::spawn(move || {
                hear(&told, &stop, |told| match told {
                    Some(Told::Report(report)) => csv.write(report),
                    _ => Ok(()),
                })
                .and_then(|()| csv.finish())
                .map(|_| None)
                .map_err(|error| format!("{name}: {error}"))
            }));
        }
        if let Some(path) = &self.record {
            threads.push(record(path, source, stop.clone())?);
        }
        Ok(Keeping { stop, threads })
    }
}

fn create(path: &Path) -> Result<File, String> {
    File::create(path).map_err(|error| format!("{}: {error}", path.display()))
}

/// Hears until the end, or until it is not wanted any more; what waits then is kept too. `None`: nothing has come for a while.
fn hear<E>(
    told: &Receiver<Told>,
    stop: &AtomicBool,
    mut keep: impl FnMut(Option<&Told>) -> Result<(), E>,
) -> Result<(), E> {
    while !stop.load(Ordering::Acquire) {
        match told.recv_timeout(GLANCE) {
            Ok(told) => keep(Some(&told))?,
            Err(RecvTimeoutError::Timeout) => keep(None)?,
            Err(RecvTimeoutError::Disconnected) => return Ok(()),
        }
    }
    told.try_iter().take(WAITING).try_for_each(|told| keep(Some(&told)))
}

type Kept = JoinHandle<Result<Option<String>, String>>;

#[cfg(feature = "record")]
fn record(path: &Path, source: &Arc<dyn Source>, stop: Arc<AtomicBool>) -> Result<Kept, Box<dyn std::error::Error>> {
    use crate::record::Recorder;

    let told = source.hear(WAITING);
    let mut recorder = Recorder::create(path, Some(source.setup()?))?;
    let name = path.display().to_string();
    Ok(std::thread::spawn(move || {
        let heard = hear(&told, &stop, |told| match told {
            Some(told) => recorder.take(told),
            None => recorder.idle(),
        });
        let counts = heard.and_then(|()| recorder.finish()).map_err(|error| error.to_string())?;
        Ok(Some(format!("{name}: {counts}")))
    }))
}

#[cfg(not(feature = "record"))]
fn record(_: &Path, _: &Arc<dyn Source>, _: Arc<AtomicBool>) -> Result<Kept, Box<dyn std::error::Error>> {
    Err(super::replay::NOT_BUILT.into())
}

/// Files on their way.
#[must_use]
pub struct Keeping {
    stop: Arc<AtomicBool>,
    threads: Vec<Kept>,
}

impl Keeping {
    /// Ends the files; gives a line for people about each that has something to say.
    ///
    /// # Errors
    /// A file that could not be written to its end.
    pub fn finish(self) -> Result<Vec<String>, Box<dyn std::error::Error>> {
        self.stop.store(true, Ordering::Release);
        let mut lines = Vec::new();
        for thread in self.threads {
            let kept = thread.join().map_err(|_| "a file's thread has failed")?;
            lines.extend(kept?);
        }
        Ok(lines)
    }
}
