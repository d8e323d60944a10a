//! Lines of CSV files: as this library writes them, and which one a record is.

/// A line with its end; cells that need quotation marks have them.
pub fn line<Cell: AsRef<[u8]>>(cells: impl IntoIterator<Item = Cell>) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    // Writing to memory cannot fail.
    let _ = writer.write_record(cells);
    writer.into_inner().ok().and_then(|bytes| String::from_utf8(bytes).ok()).unwrap_or_default()
}

/// The line of a record, from 1. The csv library counts a record from the end of the one before on: line ends and empty lines between them are
/// passed over here.
pub fn line_number(text: &[u8], position: Option<&csv::Position>) -> usize {
    let start = position.map_or(0, |position| usize::try_from(position.byte()).unwrap_or(usize::MAX).min(text.len()));
    let ends = text[start..].iter().take_while(|byte| b"\r\n".contains(byte)).count();
    1 + text[..start + ends].iter().filter(|byte| **byte == b'\n').count()
}

#[cfg(test)]
mod tests {
    use super::{line, line_number};

    #[test]
    fn a_record_behind_empty_lines_has_its_own_line() {
        for text in ["a\n1\n\n\n2\n", "a\r\n1\r\n\r\n\r\n2\r\n"] {
            let mut reader = csv::Reader::from_reader(text.as_bytes());
            let lines = reader.records().map(|row| line_number(text.as_bytes(), row.unwrap().position()));
            assert_eq!(lines.collect::<Vec<_>>(), [2, 5]);
        }
    }

    #[test]
    fn cells_are_quoted_where_they_must_be() {
        assert_eq!(line(["a", "1.5", ""]), "a,1.5,\n");
        assert_eq!(line(["one, two", "a \"b\""]), "\"one, two\",\"a \"\"b\"\"\"\n");
    }
}
