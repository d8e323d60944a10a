//! What a command keeps of what it watches, in a thread of its own: a slow screen loses no report to a file. A file that cannot be written
//! ends the command at once.

use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::thread::JoinHandle;
use std::time::Duration;

use crate::output::ForceArgs;
use fre::files::{FileError, Files, Output};
use fre_gripper::record::Csv;
use fre_gripper::source::{Source, Told};

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
    /// Records every estimate and event to an MCAP file
    ///
    /// Foxglove opens it, and `fre replay` plays it. Needs a build with `--features record`, which is on by default.
    #[arg(long, value_name = "FILE.mcap")]
    record: Option<PathBuf>,
    #[command(flatten)]
    force: ForceArgs,
}

/// Files that a command keeps, which are there to be written.
pub struct Kept {
    log: Option<(PathBuf, Output)>,
    record: Option<(PathBuf, Output)>,
}

impl KeepArgs {
    /// The files of the command that keeps these.
    pub fn files(&self) -> Files {
        self.force.files()
    }

    /// Takes note of the files, after those that are read.
    ///
    /// # Errors
    /// One of them must not be written.
    pub fn claim(&self, files: &mut Files) -> Result<Kept, FileError> {
        let mut claim = |path: &Option<PathBuf>, what| -> Result<_, FileError> {
            path.as_ref().map(|path| Ok((path.clone(), files.output(path, what)?))).transpose()
        };
        Ok(Kept { log: claim(&self.log, "--log")?, record: claim(&self.record, "--record")? })
    }
}

impl Kept {
    /// Begins to keep what this source reports. Sets `stop`, which ends the view, as soon as a file cannot be written.
    ///
    /// # Errors
    /// A file that cannot be written, or a gripper that does not answer.
    pub fn start(
        self,
        source: &Arc<dyn Source>,
        stop: &Arc<AtomicBool>,
    ) -> Result<Keeping, Box<dyn std::error::Error>> {
        let mut keeping = Keeping { over: Arc::default(), stop: stop.clone(), threads: Vec::new() };
        if let Some((path, output)) = self.log {
            let mut csv = Csv::new(BufWriter::new(output.stream()?))?;
            let (told, name) = (source.hear(WAITING), path.display().to_string());
            keeping.add(move |over| {
                hear(&told, over, |told| match told {
                    Some(Told::Report(report)) => csv.write(report),
                    _ => Ok(()),
                })
                .and_then(|()| csv.finish())
                .map(|_| None)
                .map_err(|error| format!("{name}: {error}"))
            });
        }
        if let Some((path, output)) = self.record {
            record(&path, output, source, &mut keeping)?;
        }
        Ok(keeping)
    }
}

/// Hears until the end, or until it is not wanted any more; what waits then is kept too. `None`: nothing has come for a while.
fn hear<E>(
    told: &Receiver<Told>,
    over: &AtomicBool,
    mut keep: impl FnMut(Option<&Told>) -> Result<(), E>,
) -> Result<(), E> {
    while !over.load(Ordering::Acquire) {
        match told.recv_timeout(GLANCE) {
            Ok(told) => keep(Some(&told))?,
            Err(RecvTimeoutError::Timeout) => keep(None)?,
            Err(RecvTimeoutError::Disconnected) => return Ok(()),
        }
    }
    told.try_iter().take(WAITING).try_for_each(|told| keep(Some(&told)))
}

/// A line for people about a file that is whole, or why it is not.
type Outcome = Result<Option<String>, String>;

#[cfg(feature = "record")]
fn record(
    path: &Path,
    output: Output,
    source: &Arc<dyn Source>,
    keeping: &mut Keeping,
) -> Result<(), Box<dyn std::error::Error>> {
    use fre_gripper::record::Recorder;

    let told = source.hear(WAITING);
    let mut recorder = Recorder::to(output.stream()?, path, Some(source.setup()?))?;
    let name = path.display().to_string();
    keeping.add(move |over| {
        let heard = hear(&told, over, |told| match told {
            Some(told) => recorder.take(told),
            None => recorder.idle(),
        });
        let counts = heard.and_then(|()| recorder.finish()).map_err(|error| error.to_string())?;
        Ok(Some(format!("{name}: {counts}\n")))
    });
    Ok(())
}

#[cfg(not(feature = "record"))]
fn record(_: &Path, _: Output, _: &Arc<dyn Source>, _: &mut Keeping) -> Result<(), Box<dyn std::error::Error>> {
    Err(super::replay::NOT_BUILT.into())
}

/// Files on their way.
#[must_use]
pub struct Keeping {
    /// What comes from now on is not wanted any more.
    over: Arc<AtomicBool>,
    /// Ends the view.
    stop: Arc<AtomicBool>,
    threads: Vec<JoinHandle<Outcome>>,
}

impl Keeping {
    /// Keeps a file in a thread of its own, which ends the view if that fails.
    fn add(&mut self, keep: impl FnOnce(&AtomicBool) -> Outcome + Send + 'static) {
        let (over, stop) = (self.over.clone(), self.stop.clone());
        self.threads.push(std::thread::spawn(move || keep(&over).inspect_err(|_| stop.store(true, Ordering::Release))));
    }

    /// Ends the files; gives a line for people about each that has something to say.
    ///
    /// # Errors
    /// A file that could not be written to its end; the others are whole.
    pub fn finish(self) -> Result<Vec<String>, String> {
        self.over.store(true, Ordering::Release);
        let (mut lines, mut failed) = (Vec::new(), Vec::new());
        // To the last one: a file that has failed takes no other with it.
        for thread in self.threads {
            match thread.join().unwrap_or_else(|_| Err("a file's thread has failed".to_owned())) {
                Ok(line) => lines.extend(line),
                Err(why) => failed.push(why),
            }
        }
        if failed.is_empty() { Ok(lines) } else { Err(failed.join("; ")) }
    }
}
