//! Reading: the messages of a recording in their order, past what is damaged, and also of one whose end is missing.

use std::collections::{HashMap, VecDeque};
use std::fs::File;
use std::io::{Read, Seek};
use std::path::{Path, PathBuf};

use mcap::records::Record;
use serde::Deserialize;

use super::RecordError;
use super::container::{Container, Damage, Piece};
use super::message::{EstimateMessage, EventMessage, GapMessage, GraspMessage, ShapeMessage};
use super::topic::Topic;
use crate::source::{Gap, Sequence, Setup, Told};
use fre::visible::shortened;

/// Letters of what is wrong with a message.
const LONGEST_SHOWN: usize = 300;

/// A message of a recording.
#[derive(Clone, Debug, PartialEq)]
pub enum Recorded {
    /// What was reported.
    Told(Told),
    /// Reports that had not come, or were lost with a part of the file.
    Gap(Gap),
    /// A part of the file that cannot be read; the messages go on behind it.
    Damage(Damage),
}

/// A recording, message by message: ns since 1970, and what.
pub struct Recording<R = File> {
    container: Container<R>,
    path: PathBuf,
    topics: HashMap<u16, Option<Topic>>,
    /// Read, and not given out yet.
    waiting: VecDeque<(u64, Recorded)>,
    sequence: Sequence,
    /// Time of the last message, ns.
    last_ns: u64,
    /// The file ended before its end.
    is_cut: bool,
    is_over: bool,
}

impl Recording {
    /// Opens a file.
    ///
    /// # Errors
    /// There is none, or it is not MCAP.
    pub fn open(path: &Path) -> Result<Self, RecordError> {
        let file = File::open(path).map_err(|source| RecordError::File { path: path.to_owned(), source })?;
        Self::of(file, path)
    }
}

impl<R: Read + Seek> Recording<R> {
    /// A recording in a file that is open, or in memory; the path is for messages.
    ///
    /// # Errors
    /// It cannot be read, or is not MCAP.
    pub fn of(file: R, path: &Path) -> Result<Self, RecordError> {
        let container = Container::open(file).map_err(|source| RecordError::File { path: path.to_owned(), source })?;
        let none = || RecordError::Format { path: path.to_owned(), why: "it is not an MCAP file".to_owned() };
        Ok(Self {
            container: container.ok_or_else(none)?,
            path: path.to_owned(),
            topics: HashMap::new(),
            waiting: VecDeque::new(),
            sequence: Sequence::default(),
            last_ns: 0,
            is_cut: false,
            is_over: false,
        })
    }

    /// Whether the end of the file is missing: its recorder was killed. Known once the messages are read.
    pub fn is_cut(&self) -> bool {
        self.is_cut
    }

    fn advance(&mut self) -> Result<Option<(u64, Recorded)>, RecordError> {
        loop {
            if let Some(next) = self.waiting.pop_front() {
                return Ok(Some(next));
            }
            if self.is_over {
                return Ok(None);
            }
            let unreadable = |source| RecordError::File { path: self.path.clone(), source };
            match self.container.next().map_err(unreadable)? {
                Piece::Records(records) => records.into_iter().try_for_each(|record| self.take(record))?,
                Piece::Damage(damage) => {
                    // Channels are described where they are first used, which may have been there.
                    let channels = self.container.channels_at_the_end().map_err(unreadable)?;
                    channels.into_iter().try_for_each(|channel| self.take(channel))?;
                    self.waiting.push_back((self.last_ns, Recorded::Damage(damage)));
                }
                Piece::End => self.is_over = true,
                Piece::Cut => (self.is_over, self.is_cut) = (true, true),
            }
        }
    }

    fn take(&mut self, record: Record<'_>) -> Result<(), RecordError> {
        match record {
            Record::Channel(channel) => {
                self.topics.insert(channel.id, Topic::named(&channel.topic));
            }
            Record::Message { header, data } => {
                let Some(Some(topic)) = self.topics.get(&header.channel_id).copied() else { return Ok(()) };
                let recorded = decode(topic, &data).map_err(|error| RecordError::Message {
                    path: self.path.clone(),
                    topic: topic.name(),
                    // It may repeat what is in the file.
                    why: shortened(&error.to_string(), LONGEST_SHOWN),
                })?;
                let Some(recorded) = recorded else { return Ok(()) };
                self.last_ns = header.log_time;
                let lost = match &recorded {
                    Recorded::Told(Told::Report(report)) => self.sequence.take(report.sequence),
                    // Its recorder has counted these, and not those that were lost with a part of the file before them.
                    Recorded::Gap(gap) => self.sequence.skip(gap),
                    _ => None,
                };
                self.waiting.extend(lost.map(|gap| (header.log_time, Recorded::Gap(gap))));
                self.waiting.push_back((header.log_time, recorded));
            }
            _ => {}
        }
        Ok(())
    }
}

impl<R: Read + Seek> Iterator for Recording<R> {
    type Item = Result<(u64, Recorded), RecordError>;

    fn next(&mut self) -> Option<Self::Item> {
        match self.advance() {
            Ok(recorded) => recorded.map(Ok),
            Err(error) => {
                self.is_over = true;
                self.waiting.clear();
                Some(Err(error))
            }
        }
    }
}

/// A message; nothing for topics that are only pictures.
fn decode(topic: Topic, data: &[u8]) -> serde_json::Result<Option<Recorded>> {
    fn read<'a, M: Deserialize<'a>>(data: &'a [u8]) -> serde_json::Result<M> {
        serde_json::from_slice(data)
    }
    Ok(Some(match topic {
        Topic::Estimate(_) => Recorded::Told(Told::Report(read::<EstimateMessage>(data)?.into())),
        Topic::Shape(_) => Recorded::Told(Told::Shape(Box::new(read::<ShapeMessage>(data)?.into()))),
        Topic::Grasp => Recorded::Told(Told::Grasp(read::<GraspMessage>(data)?.into())),
        Topic::Event => Recorded::Told(Told::Event(read::<EventMessage>(data)?.into())),
        Topic::Setup => Recorded::Told(Told::Setup(Box::new(read::<Setup>(data)?))),
        Topic::Gap => Recorded::Gap(read::<GapMessage>(data)?.into()),
        Topic::Log | Topic::Scene(_) | Topic::Object(_) => return Ok(None),
    }))
}
