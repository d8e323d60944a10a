//! Lines of CSV files, as this library writes them.

/// A line with its end; cells that need quotation marks have them.
pub fn line<Cell: AsRef<[u8]>>(cells: impl IntoIterator<Item = Cell>) -> String {
    separated(cells, b',')
}

/// The same with another separator.
pub fn separated<Cell: AsRef<[u8]>>(cells: impl IntoIterator<Item = Cell>, separator: u8) -> String {
    let mut writer = csv::WriterBuilder::new().delimiter(separator).from_writer(Vec::new());
    // Writing to memory cannot fail.
    let _ = writer.write_record(cells);
    writer.into_inner().ok().and_then(|bytes| String::from_utf8(bytes).ok()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::{line, separated};

    #[test]
    fn cells_are_quoted_where_they_must_be() {
        assert_eq!(line(["a", "1.5", ""]), "a,1.5,\n");
        assert_eq!(line(["one, two", "a \"b\""]), "\"one, two\",\"a \"\"b\"\"\"\n");
        assert_eq!(separated(["1,5", "one; two"], b';'), "1,5;\"one; two\"\n");
    }
}
