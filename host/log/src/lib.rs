//! A firmware image's defmt log: frames in, lines out.
//!
//! ```no_run
//! let log = fre_log::Log::of(&std::fs::read("gripper-mps2")?)?;
//! for line in log.lines(&std::fs::read("firmware.defmt")?) {
//!     println!("{line}");
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::collections::BTreeMap;
use std::fmt;

use defmt_decoder::{DecodeError, Frame, Location, StreamDecoder, Table};

/// Why an image's log cannot be decoded.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// The image's table of words is damaged, or of another version of defmt.
    #[error("its log: {0}")]
    Table(String),
    /// The image does not log by defmt.
    #[error("it has no log")]
    None,
}

/// The words of one image's log. They live as long as the decoders that read by them.
pub struct Log {
    table: Table,
    places: BTreeMap<u64, Location>,
}

/// A line of the log.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Line {
    /// The image's time stamp; empty if it has none.
    pub time: String,
    /// `ERROR`, `WARN`, `INFO`, `DEBUG` or `TRACE`; `-` if the line was printed without one.
    pub level: String,
    /// What was logged.
    pub message: String,
    /// File and line of the source, if the image has debug information.
    pub place: Option<String>,
}

impl fmt::Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:>12} {:<5} {}", self.time, self.level, self.message)?;
        self.place.as_ref().map_or(Ok(()), |place| write!(f, "  ({place})"))
    }
}

/// Turns a stream of bytes into lines.
pub struct Decoder<'a> {
    log: &'a Log,
    stream: Box<dyn StreamDecoder + Send + Sync + 'a>,
}

impl Log {
    /// Reads the words out of an ELF image's bytes.
    ///
    /// # Errors
    /// It does not log by defmt, or by another version of it.
    pub fn of(elf: &[u8]) -> Result<Self, LogError> {
        let table = Table::parse(elf).map_err(|error| LogError::Table(format!("{error:#}")))?.ok_or(LogError::None)?;
        // Without debug information there are lines all the same.
        let places = table.get_locations(elf).unwrap_or_default();
        Ok(Self { table, places })
    }

    /// A decoder for one stream.
    pub fn decoder(&self) -> Decoder<'_> {
        Decoder { log: self, stream: self.table.new_stream_decoder() }
    }

    /// All lines of a log that was recorded earlier.
    pub fn lines(&self, bytes: &[u8]) -> Vec<Line> {
        self.decoder().feed(bytes)
    }

    fn line(&self, frame: &Frame<'_>) -> Line {
        let place = self.places.get(&frame.index());
        Line {
            time: frame.display_timestamp().map_or_else(String::new, |time| time.to_string()),
            level: frame.level().map_or_else(|| "-".to_owned(), |level| level.as_str().to_uppercase()),
            message: frame.display_message().to_string(),
            place: place.map(|place| format!("{}:{}", place.file.display(), place.line)),
        }
    }
}

impl Decoder<'_> {
    /// The lines that these bytes complete. A damaged frame is a line that says so.
    pub fn feed(&mut self, bytes: &[u8]) -> Vec<Line> {
        self.stream.received(bytes);
        let mut lines = Vec::new();
        loop {
            match self.stream.decode() {
                Ok(frame) => lines.push(self.log.line(&frame)),
                Err(DecodeError::UnexpectedEof) => return lines,
                Err(DecodeError::Malformed) => {
                    lines.push(Line { message: "(a damaged line)".to_owned(), ..Line::default() });
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_reads_as_fre_log_prints_it() {
        let line = Line {
            time: "0.004".into(),
            level: "INFO".into(),
            message: "ready".into(),
            place: Some("gripper.rs:7".into()),
        };
        assert_eq!(line.to_string(), "       0.004 INFO  ready  (gripper.rs:7)");
        assert_eq!(Line { place: None, ..line }.to_string(), "       0.004 INFO  ready");
    }

    #[test]
    fn what_is_no_image_is_refused() {
        assert!(Log::of(b"no image").is_err());
    }
}
