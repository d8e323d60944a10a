//! Writing: what is reported becomes MCAP, in chunks that reach the file at least once a second.

use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{Compression, McapError, WriteOptions, Writer};
use messages::{FreeObject, Grasp, Report};
use serde::Serialize;

use super::RecordError;
use super::foxglove::{self, Level, level};
use super::message::{EstimateMessage, EventMessage, GapMessage, GraspMessage, ShapeMessage};
use super::topic::Topic;
use fre::files::Files;

use crate::source::{Clock, Sequence, Setup, Told, now_ns};

/// How often what has come reaches the file: a killed recorder loses less than a second.
const FLUSH: Duration = Duration::from_millis(500);

/// A recording on its way to a file. Everything but [`Recorder::finish`]'s index is in the file within a second.
pub struct Recorder {
    writer: Writer<NoSeek<BufWriter<File>>>,
    path: PathBuf,
    channels: HashMap<Topic, u16>,
    setup: Option<Setup>,
    /// Where the free object that is drawn was.
    drawn: Option<FreeObject>,
    sequence: Sequence,
    clock: Clock,
    flushed: Instant,
    counts: Counts,
}

/// What was recorded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Reports.
    pub reports: u64,
    /// Events.
    pub events: u64,
    /// Runs of reports that did not come, and how many reports that were.
    pub gaps: u64,
    /// See `gaps`.
    pub missing: u64,
}

impl std::fmt::Display for Counts {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { reports, events, gaps, missing } = self;
        write!(f, "{reports} reports and {events} events, ")?;
        match gaps {
            0 => f.write_str("none missing"),
            1 => write!(f, "{missing} reports missing in one gap"),
            _ => write!(f, "{missing} reports missing in {gaps} gaps"),
        }
    }
}

impl Recorder {
    /// Creates the file in place of one that is there, with the set-up as its first message if it is known.
    ///
    /// # Errors
    /// The file's; another recorder is writing it.
    pub fn create(path: &Path, setup: Option<Setup>) -> Result<Self, RecordError> {
        let file = Files::new(true).output(path, "the recording")?.stream()?;
        Self::to(file, path, setup)
    }

    /// As [`Self::create`], to a file that is open; the path is for messages.
    ///
    /// # Errors
    /// The file's.
    pub fn to(file: File, path: &Path, setup: Option<Setup>) -> Result<Self, RecordError> {
        let writer = WriteOptions::new()
            .library(concat!("fre ", env!("CARGO_PKG_VERSION")))
            .compression(Some(Compression::Zstd))
            .compression_threads(0)
            .disable_seeking(true)
            .create(NoSeek::new(BufWriter::new(file)))
            .map_err(|error| failed(path, error))?;
        let mut recorder = Self {
            writer,
            path: path.to_owned(),
            channels: HashMap::new(),
            setup: None,
            drawn: None,
            sequence: Sequence::default(),
            clock: Clock::default(),
            flushed: Instant::now(),
            counts: Counts::default(),
        };
        if let Some(setup) = setup {
            recorder.set_up(setup, now_ns())?;
        }
        Ok(recorder)
    }

    /// Takes what was reported.
    ///
    /// # Errors
    /// The file's.
    pub fn take(&mut self, told: &Told) -> Result<(), RecordError> {
        match told {
            Told::Report(report) => self.report(report)?,
            Told::Grasp(grasp) => self.grasp(grasp)?,
            Told::Shape(shape) => {
                let ns = self.clock.last_ns();
                self.write(Topic::Shape(shape.finger), shape.sequence, ns, &ShapeMessage::from(&**shape))?;
                let scene = self.setup.as_ref().and_then(|setup| foxglove::finger(ns, shape, setup));
                if let Some(scene) = scene {
                    self.write(Topic::Scene(shape.finger), shape.sequence, ns, &scene)?;
                }
            }
            Told::Event(notice) => {
                self.counts.events += 1;
                let ns = self.clock.ns(notice.time_us);
                self.write(Topic::Event, 0, ns, &EventMessage::from(notice))?;
                let words = notice.event.to_string();
                self.write(Topic::Log, 0, ns, &foxglove::log(ns, level(&notice.event), &words))?;
            }
            Told::Setup(setup) => self.set_up((**setup).clone(), self.clock.last_ns())?,
        }
        self.idle()
    }

    /// Brings to the file what has waited for long enough: to be called now and then while nothing comes.
    ///
    /// # Errors
    /// The file's.
    pub fn idle(&mut self) -> Result<(), RecordError> {
        if self.flushed.elapsed() >= FLUSH { self.flush() } else { Ok(()) }
    }

    /// Brings everything that has come to the file.
    ///
    /// # Errors
    /// The file's.
    pub fn flush(&mut self) -> Result<(), RecordError> {
        self.flushed = Instant::now();
        self.writer.flush().map_err(|error| failed(&self.path, error))
    }

    /// Ends the file with its index.
    ///
    /// # Errors
    /// The file's.
    pub fn finish(mut self) -> Result<Counts, RecordError> {
        self.writer.finish().map_err(|error| failed(&self.path, error))?;
        // The buffer's last bytes, whose error dropping would hide.
        let buffer = self.writer.into_inner().into_inner();
        let file = |source| RecordError::File { path: self.path.clone(), source };
        buffer.into_inner().map_err(|error| file(error.into_error()))?;
        Ok(self.counts)
    }

    fn report(&mut self, report: &Report) -> Result<(), RecordError> {
        self.counts.reports += 1;
        let ns = self.clock.ns(report.time_us);
        if let Some(gap) = self.sequence.take(report.sequence) {
            self.counts.gaps += 1;
            self.counts.missing += u64::from(gap.missing);
            self.write(Topic::Gap, gap.first, ns, &GapMessage::from(&gap))?;
            self.write(Topic::Log, 0, ns, &foxglove::log(ns, Level::Warning, &gap.to_string()))?;
        }
        self.write(Topic::Estimate(report.finger), report.sequence, ns, &EstimateMessage::from(report))
    }

    fn grasp(&mut self, grasp: &Grasp) -> Result<(), RecordError> {
        let ns = self.clock.last_ns();
        self.write(Topic::Grasp, grasp.sequence, ns, &GraspMessage::from(grasp))?;
        // Without a balance it is where it was.
        let rests = |free: &FreeObject| free.status.is_trustworthy();
        if grasp.free.is_none_or(|free| rests(&free)) && has_moved(self.drawn.as_ref(), grasp.free.as_ref()) {
            self.drawn = grasp.free;
            self.objects(ns)?;
        }
        Ok(())
    }

    fn set_up(&mut self, setup: Setup, ns: u64) -> Result<(), RecordError> {
        self.write(Topic::Setup, 0, ns, &setup)?;
        self.setup = Some(setup);
        self.objects(ns)
    }

    /// Draws the fingers' objects.
    fn objects(&mut self, ns: u64) -> Result<(), RecordError> {
        let Some(setup) = &self.setup else { return Ok(()) };
        let objects = (0..).zip(&setup.models).filter_map(|(finger, _)| {
            let object = setup.object(finger, self.drawn.as_ref())?;
            Some((finger, foxglove::object(ns, finger, &object, setup)))
        });
        for (finger, scene) in objects.collect::<Vec<_>>() {
            self.write(Topic::Object(finger), 0, ns, &scene)?;
        }
        Ok(())
    }

    fn write(&mut self, topic: Topic, sequence: u32, ns: u64, message: &impl Serialize) -> Result<(), RecordError> {
        let channel_id = match self.channels.get(&topic) {
            Some(&channel) => channel,
            None => {
                let (name, schema) = topic.schema();
                let added = self.writer.add_schema(name, "jsonschema", schema.to_string().as_bytes());
                let added =
                    added.and_then(|schema| self.writer.add_channel(schema, &topic.name(), "json", &BTreeMap::new()));
                let channel = added.map_err(|error| failed(&self.path, error))?;
                self.channels.insert(topic, channel);
                channel
            }
        };
        let header = MessageHeader { channel_id, sequence, log_time: ns, publish_time: ns };
        let text = serde_json::to_vec(message)
            .map_err(|error| RecordError::Format { path: self.path.clone(), why: error.to_string() })?;
        self.writer.write_to_known_channel(&header, &text).map_err(|error| failed(&self.path, error))
    }
}

/// Whether a free object has gone farther than a picture hides, mm and rad.
fn has_moved(before: Option<&FreeObject>, now: Option<&FreeObject>) -> bool {
    let place = |free: Option<&FreeObject>| free.map_or([0.0; 3], |it| [it.shift[0], it.shift[1], 100.0 * it.turn]);
    place(before).iter().zip(place(now)).any(|(before, now)| (now - before).abs() > 0.05)
}

fn failed(path: &Path, error: McapError) -> RecordError {
    match error {
        McapError::Io(source) => RecordError::File { path: path.to_owned(), source },
        error => RecordError::Format { path: path.to_owned(), why: error.to_string() },
    }
}
