//! Tables of numbers as spreadsheets write them.
//!
//! Cells are separated by commas; or by semicolons or tabs, if that gives the header its columns or a first line `sep=;` says so,
//! and there decimals may have a comma instead of a point, as spreadsheets of many countries write them. A cell in quotation
//! marks may hold anything, line breaks too. UTF-8, or UTF-16 with its byte order mark. Lines that begin with `#` and empty
//! lines are left out. Names of columns may have capitals.

use crate::visible::shortened;

/// The most lines of one cell: a note has fewer, and two stray quotation marks are not to hide what lies between them.
const MOST_BREAKS: usize = 20;
/// The most letters of a cell, and the most columns, that a message repeats.
const LONGEST_SHOWN: usize = 40;
/// The same of columns.
const MOST_LISTED: usize = 12;

/// A row of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Row {
    /// Line of its beginning, from 1: a cell in quotation marks may have line breaks.
    pub line: usize,
    /// As many cells as the header has, without blanks and quotation marks around them; or why they are not as many.
    pub cells: Result<Vec<String>, String>,
}

/// A table, of which the header is read.
#[derive(Clone, Debug)]
pub struct Sheet<'a> {
    records: Records<'a>,
    separator: char,
    line: usize,
    heads: Vec<String>,
    names: Vec<String>,
}

impl<'a> Sheet<'a> {
    /// Reads the header of a text. The separator is the one that gives most of the columns that mean something to the caller,
    /// whose names are in lower case. None for an empty text.
    pub fn new(text: &'a str, known: &[&str]) -> Option<Self> {
        let mut records = Records::new(text.strip_prefix('\u{feff}').unwrap_or(text));
        let separator = records.separator(known)?;
        let (line, heads) = records.next(separator)?;
        let names = heads.iter().map(|head| head.to_ascii_lowercase()).collect();
        Some(Self { records, separator, line, heads, names })
    }

    /// Lines of the text.
    pub fn lines(&self) -> usize {
        self.records.lines.len()
    }

    /// Line of the header, from 1.
    pub fn line(&self) -> usize {
        self.line
    }

    /// What separates the cells.
    pub fn separator(&self) -> char {
        self.separator
    }

    /// The columns in the file's words.
    pub fn heads(&self) -> &[String] {
        &self.heads
    }

    /// The columns in lower case.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Where a column is, by its name in lower case.
    pub fn column(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|found| found == name)
    }

    /// The first of these columns that is there more than once.
    pub fn repeated(&self, known: &[&'static str]) -> Option<&'static str> {
        known.iter().copied().find(|column| self.names.iter().filter(|name| name == column).count() > 1)
    }

    /// The columns for a message, as many as a person reads.
    pub fn found(&self) -> String {
        listed(&self.heads).join(", ")
    }

    /// Reads a cell of a column: a finite number, in which one comma may stand for the decimal point unless commas separate cells.
    ///
    /// # Errors
    /// The cell and what is allowed.
    pub fn number(&self, column: &str, cell: &str) -> Result<f64, String> {
        if cell.is_empty() {
            return Err(format!("{column} is empty; needed is a number"));
        }
        let comma = self.separator != ',' && !cell.contains('.');
        let read = if comma { cell.replacen(',', ".", 1).parse::<f64>() } else { cell.parse() };
        match read {
            Ok(value) if value.is_finite() => Ok(value),
            _ if cell.contains(',') => {
                let cell = shown(cell);
                Err(format!("{column} = \"{cell}\" is not a number: decimals have a point, thousands nothing"))
            }
            _ => {
                let cell = shown(cell);
                Err(format!("{column} = \"{cell}\" is not a finite number (the unit belongs in the header)"))
            }
        }
    }
}

impl Iterator for Sheet<'_> {
    type Item = Row;

    fn next(&mut self) -> Option<Row> {
        let (line, mut cells) = self.records.next(self.separator)?;
        let needed = self.heads.len();
        // What is beyond the header's last column is nothing if it is empty.
        while cells.len() > needed && cells.last().is_some_and(String::is_empty) {
            cells.pop();
        }
        if cells.len() == needed {
            return Some(Row { line, cells: Ok(cells) });
        }
        let decimals = if self.separator == ',' { " (decimals have a point)" } else { "" };
        Some(Row { line, cells: Err(format!("has {} cells, the header {needed}{decimals}", cells.len())) })
    }
}

/// The records of a text: a line each, or several where a cell in quotation marks has line breaks.
#[derive(Clone, Debug)]
struct Records<'a> {
    lines: Vec<&'a str>,
    next: usize,
}

impl<'a> Records<'a> {
    fn new(text: &'a str) -> Self {
        // Some spreadsheets end lines with a carriage return only.
        let lines = if text.contains('\n') {
            text.split('\n').map(|line| line.strip_suffix('\r').unwrap_or(line)).collect()
        } else {
            text.split('\r').collect()
        };
        Self { lines, next: 0 }
    }

    /// Goes past comments and empty lines to what is next.
    fn skip(&mut self) -> Option<&'a str> {
        while let Some(line) = self.lines.get(self.next) {
            if !line.trim().is_empty() && !line.trim_start().starts_with('#') {
                return Some(line);
            }
            self.next += 1;
        }
        None
    }

    /// What separates the cells, the header being next: what a line `sep=;` before it says, which some spreadsheets write and
    /// is passed; else what leaves most columns that mean something, for a name may have another separator in it.
    fn separator(&mut self, columns: &[&str]) -> Option<char> {
        let first = self.skip()?.trim().trim_matches('"');
        let told = first.get(..4).filter(|word| word.eq_ignore_ascii_case("sep=")).and_then(|_| first.get(4..));
        if let Some(told) = told {
            let mut letters = told.chars();
            let told = letters.next().filter(|letter| letters.next().is_none() && !letter.is_alphanumeric());
            if let Some(separator) = told {
                self.next += 1;
                return Some(separator);
            }
        }
        let known = |separator: char| {
            let cells = self.record(self.next, separator).0;
            let known = cells.iter().filter(|cell| columns.contains(&cell.to_ascii_lowercase().as_str())).count();
            (known, cells.len() > 1)
        };
        // Of equal ones the last is taken: the comma before the others.
        ['\t', ';', ','].into_iter().max_by_key(|&separator| known(separator))
    }

    /// The next record that is not a comment: its line, from 1, and its cells.
    fn next(&mut self, separator: char) -> Option<(usize, Vec<String>)> {
        self.skip()?;
        let (cells, end) = self.record(self.next, separator);
        let line = self.next + 1;
        self.next = end;
        Some((line, cells))
    }

    /// Cells of the record that begins at an index of the lines, and the index after it. Inside quotation marks a separator is
    /// text, and two marks are one.
    fn record(&self, start: usize, separator: char) -> (Vec<String>, usize) {
        let mut cells = vec![String::new()];
        let mut index = start;
        let mut rest = self.lines.get(index).copied().unwrap_or_default();
        let mut quoted = false;
        loop {
            let Some(letter) = rest.chars().next() else {
                // A mark that nothing closes spoils its own line, not the rest of the file.
                if !quoted || !self.closes(index + 1, separator) {
                    break;
                }
                index += 1;
                rest = self.lines.get(index).copied().unwrap_or_default();
                if let Some(cell) = cells.last_mut() {
                    cell.push('\n');
                }
                continue;
            };
            let (whole, after) = (rest, &rest[letter.len_utf8()..]);
            rest = after;
            let Some(cell) = cells.last_mut() else { break };
            match letter {
                '"' if quoted && whole.starts_with("\"\"") => {
                    rest = &whole[2..];
                    cell.push('"');
                }
                '"' if quoted => quoted = false,
                '"' if cell.trim().is_empty() => quoted = true,
                _ if letter == separator && !quoted => cells.push(String::new()),
                _ => cell.push(letter),
            }
        }
        (cells.iter().map(|cell| cell.trim().to_owned()).collect(), index + 1)
    }

    /// True if the first single quotation mark from a line on ends a cell: a separator or the line's end follows.
    fn closes(&self, from: usize, separator: char) -> bool {
        let lines = self.lines.get(from..).unwrap_or_default().iter().take(MOST_BREAKS);
        let first = lines.map(|line| line.replace("\"\"", "")).find(|line| line.contains('"'));
        first
            .and_then(|line| line.split_once('"').map(|(_, after)| after.trim_start_matches(' ').to_owned()))
            .is_some_and(|after| after.is_empty() || after.starts_with(separator))
    }
}

/// A piece of the file for a message.
fn shown(text: &str) -> String {
    shortened(text, LONGEST_SHOWN)
}

/// Names of columns for a message.
pub fn listed<'a>(heads: impl IntoIterator<Item = &'a String>) -> Vec<String> {
    let mut heads = heads.into_iter().filter(|head| !head.is_empty());
    let mut names: Vec<String> = heads.by_ref().take(MOST_LISTED).map(|head| shown(head)).collect();
    match heads.count() {
        0 => (),
        more => names.push(format!("and {more} more")),
    }
    names
}

/// The text of a file that is copied, in which no byte may change: UTF-16 if it begins with that byte order mark, else UTF-8.
///
/// # Errors
/// The line, from 1, of the first byte that is not text.
pub fn exactly(bytes: &[u8]) -> Result<String, usize> {
    let line = |before: &str| 1 + before.matches(if before.contains('\n') { '\n' } else { '\r' }).count();
    let read = match bytes {
        [0xff, 0xfe, ..] => u16::from_le_bytes,
        [0xfe, 0xff, ..] => u16::from_be_bytes,
        _ => {
            let text = std::str::from_utf8(bytes).map(str::to_owned);
            return text.map_err(|error| line(&String::from_utf8_lossy(&bytes[..error.valid_up_to()])));
        }
    };
    let units = bytes.chunks_exact(2).skip(1).map(|pair| read([pair[0], pair[1]]));
    let mut text = String::new();
    for letter in char::decode_utf16(units) {
        text.push(letter.map_err(|_| line(&text))?);
    }
    if bytes.len().is_multiple_of(2) { Ok(text) } else { Err(line(&text)) }
}

/// A file's text: UTF-16 if it begins with that byte order mark, else UTF-8, in which a wrong byte spoils its cell, not the file.
pub fn decoded(bytes: &[u8]) -> String {
    let words = |read: fn([u8; 2]) -> u16| -> String {
        let units: Vec<u16> = bytes.chunks_exact(2).skip(1).map(|pair| read([pair[0], pair[1]])).collect();
        String::from_utf16_lossy(&units)
    };
    match bytes {
        [0xff, 0xfe, ..] => words(u16::from_le_bytes),
        [0xfe, 0xff, ..] => words(u16::from_be_bytes),
        _ => String::from_utf8_lossy(bytes).into_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::exactly;

    #[test]
    fn a_byte_that_is_not_text_has_its_line() {
        assert_eq!(exactly("a\nä".as_bytes()).as_deref(), Ok("a\nä"));
        assert_eq!(exactly(b"a\nb\n\xe4\n"), Err(3));
        assert_eq!(exactly(b"a\rb\xe4"), Err(2));
        let wide = |units: &[u16]| -> Vec<u8> {
            [0xfeff].iter().chain(units).flat_map(|unit: &u16| unit.to_le_bytes()).collect()
        };
        assert_eq!(exactly(&wide(&[97, 10, 228])).as_deref(), Ok("a\nä"));
        assert_eq!(exactly(&wide(&[97, 10, 0xd800, 97])), Err(2));
        assert_eq!(exactly(&wide(&[97])[..3]), Err(1));
    }
}
