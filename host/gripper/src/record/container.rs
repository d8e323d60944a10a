//! A recording's container: its records one after the other, and past those that are damaged.
//!
//! An MCAP file is a row of records (a byte for the kind, eight for the length, the content). Messages come in chunks, compressed
//! together and with a checksum. A damaged chunk is skipped by its length; if the length itself is damaged, the next chunk is found
//! by its header, whose lengths must agree.

use std::io::{self, BufReader, ErrorKind, Read, Seek, SeekFrom};

use mcap::records::{Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};

/// Bytes of a record before its content.
const HEAD: u64 = 9;
/// Bytes of a footer's content, and of the magic bytes behind it.
const FOOTER: [u64; 2] = [20, 8];
/// The longest record that is believed, bytes: a damaged length must not take all memory.
const LONGEST: u64 = 64 << 20;
/// Bytes of a chunk's header that do not depend on the name of its compression.
const CHUNK_HEAD: u64 = 8 + 8 + 8 + 4 + 4 + 8;
/// Longest name of a compression.
const NAME: u64 = 16;
/// Bytes that are searched at a time.
const WINDOW: usize = 1 << 20;

/// Bytes of a file that could not be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Damage {
    /// Place of the first.
    pub from: u64,
    /// Place behind the last.
    pub to: u64,
}

impl std::fmt::Display for Damage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "bytes {} to {} are damaged", self.from, self.to.saturating_sub(1))
    }
}

/// What comes next in a file.
pub enum Piece {
    /// The records of a chunk, or one outside chunks.
    Records(Vec<Record<'static>>),
    /// Something unreadable.
    Damage(Damage),
    /// The file is over, as it should be.
    End,
    /// The file breaks off.
    Cut,
}

/// A file of records.
pub struct Container<R> {
    file: BufReader<R>,
    length: u64,
    /// Where the next record begins.
    at: u64,
    /// The records of the data are over; what follows are indices.
    is_summary: bool,
}

impl<R: Read + Seek> Container<R> {
    /// Begins behind the magic bytes, if they are there.
    pub fn open(file: R) -> io::Result<Option<Self>> {
        let mut file = BufReader::new(file);
        let length = file.seek(SeekFrom::End(0))?;
        file.rewind()?;
        let mut magic = [0; mcap::MAGIC.len()];
        match file.read_exact(&mut magic) {
            Err(error) if error.kind() != ErrorKind::UnexpectedEof => Err(error),
            Ok(()) if magic == *mcap::MAGIC => {
                Ok(Some(Self { file, length, at: magic.len() as u64, is_summary: false }))
            }
            _ => Ok(None),
        }
    }

    /// The next piece.
    pub fn next(&mut self) -> io::Result<Piece> {
        let begin = self.at;
        let left = self.length.saturating_sub(begin);
        if left < HEAD {
            return Ok(Piece::Cut);
        }
        let (kind, length) = self.head(begin)?;
        if !self.is_plausible(kind, length, left - HEAD) {
            return self.search(begin);
        }
        let content = self.content(begin + HEAD, length)?;
        let end = begin + HEAD + length;
        self.at = end;
        let records = match kind {
            op::FOOTER => return Ok(Piece::End),
            op::CHUNK => match chunk(&content) {
                Ok(records) => records,
                Err(is_whole) if is_whole => return Ok(Piece::Damage(Damage { from: begin, to: end })),
                Err(_) => return self.search(begin),
            },
            _ => match mcap::parse_record(kind, &content) {
                Ok(Record::MessageIndex(index)) if length != 6 + 16 * index.records.len() as u64 => {
                    return self.search(begin);
                }
                Ok(record) => {
                    self.is_summary |= kind == op::DATA_END;
                    vec![record.into_owned()]
                }
                Err(_) => return self.search(begin),
            },
        };
        Ok(Piece::Records(records))
    }

    /// Channels that the file's end repeats, for one whose definitions are damaged. None if the end is missing or damaged itself.
    pub fn channels_at_the_end(&mut self) -> io::Result<Vec<Record<'static>>> {
        let mut channels = Vec::new();
        let [content, magic] = FOOTER;
        let Some(at) = self.length.checked_sub(HEAD + content + magic) else { return Ok(channels) };
        if self.head(at)? != (op::FOOTER, content) {
            return Ok(channels);
        }
        let footer = self.content(at + HEAD, content)?;
        let Ok(Record::Footer(footer)) = mcap::parse_record(op::FOOTER, &footer) else { return Ok(channels) };
        let mut next = footer.summary_start;
        while next > 0 && next + HEAD <= at {
            let (kind, length) = self.head(next)?;
            if length > at - next - HEAD {
                break;
            }
            if kind == op::CHANNEL {
                let content = self.content(next + HEAD, length)?;
                channels.extend(mcap::parse_record(kind, &content).ok().map(Record::into_owned));
            }
            next += HEAD + length;
        }
        Ok(channels)
    }

    /// A record's kind and length.
    fn head(&mut self, at: u64) -> io::Result<(u8, u64)> {
        let mut head = [0; HEAD as usize];
        self.file.seek(SeekFrom::Start(at))?;
        self.file.read_exact(&mut head)?;
        let [kind, length @ ..] = head;
        Ok((kind, u64::from_le_bytes(length)))
    }

    fn content(&mut self, at: u64, length: u64) -> io::Result<Vec<u8>> {
        let mut content = vec![0; length as usize];
        self.file.seek(SeekFrom::Start(at))?;
        self.file.read_exact(&mut content)?;
        Ok(content)
    }

    /// Whether a record of this kind and length may be here.
    fn is_plausible(&self, kind: u8, length: u64, left: u64) -> bool {
        let is_expected = match kind {
            op::FOOTER => length == FOOTER[0] && left == length + FOOTER[1],
            op::HEADER => self.at == mcap::MAGIC.len() as u64,
            op::DATA_END => length == 4,
            op::SCHEMA..=op::MESSAGE_INDEX | op::ATTACHMENT | op::METADATA => true,
            op::CHUNK_INDEX | op::ATTACHMENT_INDEX | op::STATISTICS | op::METADATA_INDEX | op::SUMMARY_OFFSET => {
                self.is_summary
            }
            _ => false,
        };
        is_expected && length <= LONGEST.min(left)
    }

    /// Goes on at the next chunk behind the first byte of a record that cannot be read.
    fn search(&mut self, begin: u64) -> io::Result<Piece> {
        if self.is_summary {
            // All messages have been read: only indices are damaged.
            return Ok(Piece::End);
        }
        let mut from = begin + 1;
        let mut window = vec![0; WINDOW];
        loop {
            self.file.seek(SeekFrom::Start(from))?;
            let count = fill(&mut self.file, &mut window)?;
            let seen = window.get(..count).unwrap_or_default();
            // A chunk's header that begins in the last bytes is seen by the next window.
            let heads = seen.windows((HEAD + CHUNK_HEAD + NAME) as usize).enumerate();
            let found =
                heads.map(|(place, head)| (from + place as u64, head)).find(|(at, head)| self.begins_chunk(*at, head));
            if let Some((at, _)) = found {
                self.at = at;
                return Ok(Piece::Damage(Damage { from: begin, to: at }));
            }
            if count < window.len() {
                return self.rest(begin);
            }
            from += (count - (HEAD + CHUNK_HEAD + NAME) as usize + 1) as u64;
        }
    }

    /// What is left of a file without another chunk: damaged up to its footer, or cut off.
    fn rest(&mut self, begin: u64) -> io::Result<Piece> {
        let [content, magic] = FOOTER;
        match self.length.checked_sub(HEAD + content + magic) {
            Some(footer) if footer > begin && self.head(footer)? == (op::FOOTER, content) => {
                self.at = footer;
                Ok(Piece::Damage(Damage { from: begin, to: footer }))
            }
            _ => Ok(Piece::Cut),
        }
    }

    /// Whether a chunk begins here: its lengths agree with each other and with the file.
    fn begins_chunk(&self, at: u64, head: &[u8]) -> bool {
        let (Some((&op::CHUNK, rest)), left) = (head.split_first(), self.length.saturating_sub(at + HEAD)) else {
            return false;
        };
        let Some((length, content)) = rest.split_first_chunk() else { return false };
        let length = u64::from_le_bytes(*length);
        length <= LONGEST.min(left) && is_whole(content, length)
    }
}

/// Reads until the buffer is full or the file is over.
fn fill(file: &mut impl Read, buffer: &mut [u8]) -> io::Result<usize> {
    let mut filled = 0;
    while let Some(rest) = buffer.get_mut(filled..).filter(|rest| !rest.is_empty()) {
        match file.read(rest) {
            Ok(0) => break,
            Ok(count) => filled += count,
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(filled)
}

/// Whether a chunk's content, or its beginning, agrees with the length of its record.
fn is_whole(content: &[u8], length: u64) -> bool {
    let number = |at: usize| -> Option<u64> { Some(u64::from_le_bytes(*content.get(at..)?.first_chunk()?)) };
    let name = || -> Option<u64> { Some(u32::from_le_bytes(*content.get(28..)?.first_chunk()?).into()) };
    let lengths = || -> Option<bool> {
        let (start, end, uncompressed, name) = (number(0)?, number(8)?, number(16)?, name()?);
        let compressed = number(32 + usize::try_from(name).ok().filter(|name| *name as u64 <= NAME)?)?;
        Some(start <= end && uncompressed <= LONGEST && CHUNK_HEAD + name + compressed == length)
    };
    lengths().unwrap_or(false)
}

/// The records of a chunk; else whether its length, at least, is right.
fn chunk(content: &[u8]) -> Result<Vec<Record<'static>>, bool> {
    let whole = is_whole(content, content.len() as u64);
    let Ok(Record::Chunk { header, .. }) = mcap::parse_record(op::CHUNK, content) else { return Err(whole) };
    // A right checksum is better evidence than lengths and times that agree.
    if header.uncompressed_size > LONGEST || (!whole && header.uncompressed_crc == 0) {
        return Err(whole);
    }
    records(content).map_err(|_| whole)
}

/// The records of a chunk, once its checksum is right: what is not may name any length.
fn records(content: &[u8]) -> mcap::McapResult<Vec<Record<'static>>> {
    let options = LinearReaderOptions::default()
        .with_skip_start_magic(true)
        .with_skip_end_magic(true)
        .with_prevalidate_chunk_crcs(true)
        .with_record_length_limit(LONGEST as usize);
    let mut reader = LinearReader::new_with_options(options);
    let head = [&[op::CHUNK], (content.len() as u64).to_le_bytes().as_slice()].concat();
    let mut source = head.as_slice().chain(content);
    let mut records = Vec::new();
    while let Some(event) = reader.next_event() {
        match event? {
            LinearReadEvent::ReadRequest(wanted) => {
                let count = source.read(reader.insert(wanted.clamp(1, WINDOW)))?;
                if count == 0 {
                    break;
                }
                reader.notify_read(count);
            }
            LinearReadEvent::Record { data, opcode } => {
                records.push(mcap::parse_record(opcode, data)?.into_owned());
            }
        }
    }
    Ok(records)
}
