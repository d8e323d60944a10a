//! Lines of CSV files as this library writes them.

/// A line with its end; cells that need quotation marks have them.
pub fn line<Cell: AsRef<[u8]>>(cells: impl IntoIterator<Item = Cell>) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    // Writing to memory cannot fail.
    let _ = writer.write_record(cells);
    writer.into_inner().ok().and_then(|bytes| String::from_utf8(bytes).ok()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::line;

    #[test]
    fn cells_are_quoted_where_they_must_be() {
        assert_eq!(line(["a", "1.5", ""]), "a,1.5,\n");
        assert_eq!(line(["one, two", "a \"b\""]), "\"one, two\",\"a \"\"b\"\"\"\n");
    }
}
