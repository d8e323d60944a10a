//! Decodes an image's defmt log by the strings in its ELF.

use anyhow::{Context, Result};
use defmt_decoder::{DecodeError, Table};
use std::io::Read;

/// The log strings of one image, if it logs at all.
pub struct Log {
    table: Option<Table>,
}

impl Log {
    /// Reads the strings out of an ELF file's bytes.
    pub fn of(elf: &[u8]) -> Result<Self> {
        let table = Table::parse(elf).context("cannot read the image's defmt strings")?;
        Ok(Self { table })
    }

    /// Prints the lines as they come, until the source ends.
    pub fn print(&self, source: impl Read) -> Result<()> {
        self.each_line(source, |line| println!("{line}"))
    }

    /// All lines of bytes received earlier.
    pub fn lines(&self, bytes: &[u8]) -> Result<Vec<String>> {
        let mut lines = Vec::new();
        self.each_line(bytes, |line| lines.push(line))?;
        Ok(lines)
    }

    fn each_line(&self, mut source: impl Read, mut take: impl FnMut(String)) -> Result<()> {
        let mut decoder = self.table.as_ref().map(Table::new_stream_decoder);
        let mut buffer = [0; 4096];
        loop {
            let count = source.read(&mut buffer).context("cannot read the log")?;
            if count == 0 {
                return Ok(());
            }
            let Some(decoder) = &mut decoder else {
                take(String::from_utf8_lossy(&buffer[..count]).into_owned());
                continue;
            };
            decoder.received(&buffer[..count]);
            loop {
                match decoder.decode() {
                    Ok(frame) => take(frame.display(false).to_string()),
                    Err(DecodeError::UnexpectedEof) => break,
                    Err(DecodeError::Malformed) => take("(a malformed log frame)".to_owned()),
                }
            }
        }
    }
}
