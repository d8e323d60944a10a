//! Lines and cells of what spreadsheets write.

use crate::visible::shortened;

/// Columns that mean something.
pub(super) const COLUMNS: [&str; 9] = [
    "motor_angle_deg",
    "distance_mm",
    "force_n",
    "fx_n",
    "fy_n",
    "front_x_mm",
    "front_y_mm",
    "time_s",
    "motor_torque_nmm",
];

/// The most lines of one cell: a note has fewer, and two stray quotation marks are not to hide what lies between them.
const MOST_BREAKS: usize = 20;
/// The most letters of a cell, and the most columns, that a message repeats.
const LONGEST_SHOWN: usize = 40;
/// The same of columns.
const MOST_LISTED: usize = 12;
/// A record of the file: a line, or several where a cell in quotation marks has line breaks.
pub(super) struct Record {
    /// Line of its beginning, from 1.
    pub(super) line: usize,
    /// Without blanks and quotation marks around them.
    pub(super) cells: Vec<String>,
}

/// The records of a text.
pub(super) struct Records<'a> {
    lines: Vec<&'a str>,
    next: usize,
}

impl<'a> Records<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        // Some spreadsheets end lines with a carriage return only.
        let lines = if text.contains('\n') {
            text.split('\n').map(|line| line.strip_suffix('\r').unwrap_or(line)).collect()
        } else {
            text.split('\r').collect()
        };
        Self { lines, next: 0 }
    }

    /// Lines of the text.
    pub(super) fn lines(&self) -> usize {
        self.lines.len()
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
    pub(super) fn separator(&mut self) -> Option<char> {
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
            let known = cells.iter().filter(|cell| COLUMNS.contains(&cell.to_ascii_lowercase().as_str())).count();
            (known, cells.len() > 1)
        };
        // Of equal ones the last is taken: the comma before the others.
        ['\t', ';', ','].into_iter().max_by_key(|&separator| known(separator))
    }

    /// The next record that is not a comment.
    pub(super) fn next(&mut self, separator: char) -> Option<Record> {
        self.skip()?;
        let (cells, end) = self.record(self.next, separator);
        let line = self.next + 1;
        self.next = end;
        Some(Record { line, cells })
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
pub(super) fn shown(text: &str) -> String {
    shortened(text, LONGEST_SHOWN)
}

/// Names of columns for a message.
pub(super) fn listed<'a>(heads: impl IntoIterator<Item = &'a String>) -> Vec<String> {
    let mut heads = heads.into_iter().filter(|head| !head.is_empty());
    let mut names: Vec<String> = heads.by_ref().take(MOST_LISTED).map(|head| shown(head)).collect();
    match heads.count() {
        0 => (),
        more => names.push(format!("and {more} more")),
    }
    names
}
