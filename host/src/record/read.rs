//! Reading: the messages of a recording in their order, also of one whose end is missing.

use std::collections::HashMap;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use mcap::McapError;
use mcap::records::Record;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use serde::Deserialize;

use super::RecordError;
use super::message::{EstimateMessage, EventMessage, GapMessage, GraspMessage, ShapeMessage};
use super::topic::Topic;
use crate::source::{Gap, Setup, Told};

/// The longest record that is believed, bytes: a damaged length must not take all memory.
const LONGEST: usize = 64 << 20;

/// A message of a recording.
#[derive(Clone, Debug, PartialEq)]
pub enum Recorded {
    /// What was told.
    Told(Told),
    /// Reports that had not come.
    Gap(Gap),
}

/// A recording, message by message: ns since 1970, and what.
pub struct Recording {
    file: File,
    path: PathBuf,
    reader: LinearReader,
    topics: HashMap<u16, Option<Topic>>,
    /// The file ended before its end.
    is_cut: bool,
    is_over: bool,
}

impl Recording {
    /// Opens a file.
    ///
    /// # Errors
    /// There is none, or it is no MCAP.
    pub fn open(path: &Path) -> Result<Self, RecordError> {
        let unreadable = |source| RecordError::File { path: path.to_owned(), source };
        let mut file = File::open(path).map_err(unreadable)?;
        let mut magic = [0; 8];
        if file.read_exact(&mut magic).is_err() || magic != *mcap::MAGIC {
            return Err(RecordError::Format { path: path.to_owned(), why: "it is no MCAP file".to_owned() });
        }
        let options = LinearReaderOptions::default()
            .with_skip_start_magic(true)
            .with_skip_end_magic(true)
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(LONGEST);
        Ok(Self {
            file,
            path: path.to_owned(),
            reader: LinearReader::new_with_options(options),
            topics: HashMap::new(),
            is_cut: false,
            is_over: false,
        })
    }

    /// Whether the end of the file is missing: its recorder was killed. Known once the messages are read.
    pub fn is_cut(&self) -> bool {
        self.is_cut
    }

    fn advance(&mut self) -> Result<Option<(u64, Recorded)>, RecordError> {
        while !self.is_over {
            let event = match self.reader.next_event() {
                // It ends between two records, and before its footer.
                None => {
                    self.is_cut = true;
                    break;
                }
                Some(Ok(event)) => event,
                // A chunk that breaks off at the end of the file, or the file itself.
                Some(Err(McapError::UnexpectedEof | McapError::UnexpectedEoc)) => {
                    self.is_cut = true;
                    break;
                }
                Some(Err(error)) => return Err(self.format(&error.to_string())),
            };
            match event {
                LinearReadEvent::ReadRequest(wanted) => {
                    let wanted = wanted.clamp(1, LONGEST);
                    let read = self.file.read(self.reader.insert(wanted));
                    let count = read.map_err(|source| RecordError::File { path: self.path.clone(), source })?;
                    self.reader.notify_read(count);
                }
                LinearReadEvent::Record { data, opcode } => {
                    let record = mcap::parse_record(opcode, data).map_err(|error| error.to_string());
                    match record {
                        Ok(Record::Channel(channel)) => {
                            self.topics.insert(channel.id, Topic::named(&channel.topic));
                        }
                        Ok(Record::Message { header, data }) => {
                            let Some(Some(topic)) = self.topics.get(&header.channel_id).copied() else { continue };
                            let recorded = decode(topic, &data).map_err(|error| RecordError::Message {
                                path: self.path.clone(),
                                topic: topic.name(),
                                why: error.to_string(),
                            })?;
                            return Ok(recorded.map(|recorded| (header.log_time, recorded)));
                        }
                        Ok(Record::Footer(_)) => break,
                        Ok(_) => {}
                        Err(why) => return Err(self.format(&why)),
                    }
                }
            }
        }
        self.is_over = true;
        Ok(None)
    }

    fn format(&self, why: &str) -> RecordError {
        RecordError::Format { path: self.path.clone(), why: why.to_owned() }
    }
}

impl Iterator for Recording {
    type Item = Result<(u64, Recorded), RecordError>;

    fn next(&mut self) -> Option<Self::Item> {
        match self.advance() {
            Ok(recorded) => recorded.map(Ok),
            Err(error) => {
                self.is_over = true;
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
