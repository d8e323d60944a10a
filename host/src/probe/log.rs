//! defmt's log as text, with the place in the source that each line comes from.

use std::collections::BTreeMap;

use defmt_decoder::{DecodeError, Frame, Location, StreamDecoder, Table};

use super::{Image, ProbeError};

/// The words of one image's log. They live as long as the decoders that read by them.
pub struct Log {
    table: Table,
    places: BTreeMap<u64, Location>,
}

/// Turns a stream of bytes into lines.
pub struct Lines<'a> {
    log: &'a Log,
    decoder: Box<dyn StreamDecoder + Send + Sync + 'a>,
}

impl Log {
    /// Reads the words out of an image.
    ///
    /// # Errors
    /// It does not log by defmt, or by another version of it.
    pub fn of(image: &Image) -> Result<Self, ProbeError> {
        let bad = |why: String| ProbeError::BadImage { path: image.path().to_owned(), why };
        let table = Table::parse(image.bytes()).map_err(|error| bad(format!("its log: {error:#}")))?;
        let table = table.ok_or_else(|| bad("it has no log".to_owned()))?;
        // Without debug information there are lines all the same.
        let places = table.get_locations(image.bytes()).unwrap_or_default();
        Ok(Self { table, places })
    }

    /// A decoder for one stream.
    pub fn lines(&self) -> Lines<'_> {
        Lines { log: self, decoder: self.table.new_stream_decoder() }
    }

    fn line(&self, frame: &Frame<'_>) -> String {
        let level = frame.level().map_or_else(|| "-".to_owned(), |level| level.as_str().to_uppercase());
        let time = frame.display_timestamp().map_or_else(String::new, |time| time.to_string());
        let mut line = format!("{time:>12} {level:<5} {}", frame.display_message());
        if let Some(place) = self.places.get(&frame.index()) {
            line += &format!("  ({}:{})", place.file.display(), place.line);
        }
        line
    }
}

impl Lines<'_> {
    /// The lines that these bytes complete.
    pub fn feed(&mut self, bytes: &[u8]) -> Vec<String> {
        self.decoder.received(bytes);
        let mut lines = Vec::new();
        loop {
            match self.decoder.decode() {
                Ok(frame) => lines.push(self.log.line(&frame)),
                Err(DecodeError::UnexpectedEof) => return lines,
                Err(DecodeError::Malformed) => lines.push(format!("{:>12} (a damaged line)", "")),
            }
        }
    }
}
