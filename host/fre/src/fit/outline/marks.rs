//! Marks from a file.

use std::path::Path;

use serde::Deserialize;

use super::error::OutlineError;
pub use super::mark::{Mark, pair};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MarksFile {
    mark: Vec<Mark>,
}

/// Reads a file of `[[mark]]` tables with `pixel` and `mm`.
///
/// # Errors
/// It cannot be read, is not TOML, or a table lacks something or has too much.
pub fn read(path: &Path) -> Result<Vec<Mark>, OutlineError> {
    let file = path.display().to_string();
    let text = std::fs::read_to_string(path)
        .map_err(|error| OutlineError::Unreadable { file: file.clone(), reason: error.to_string() })?;
    let marks: MarksFile = toml::from_str(&text).map_err(|error| OutlineError::toml(&file, &text, &error))?;
    match marks.mark.iter().flat_map(|mark| mark.pixel.iter().chain(&mark.mm)).find(|x| !x.is_finite()) {
        Some(x) => Err(OutlineError::Option(format!("{file}: a mark has {x}; allowed are finite numbers"))),
        None => Ok(marks.mark),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mark_is_read_as_it_is_written() {
        let mark: Mark = "412.5, 1530=-14,-5".parse().unwrap();
        assert_eq!((mark.pixel, mark.mm), ([412.5, 1530.0], [-14.0, -5.0]));
        for words in ["", "1,2", "1,2=3", "1=2,3", "1,2=3,4,5", "1,2=x,4", "1,2=inf,4"] {
            assert!(words.parse::<Mark>().unwrap_err().contains("PX,PY=X,Y"), "{words}");
        }
    }
}
