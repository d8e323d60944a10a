//! Marks: points of the finger's plane whose place in millimetres is known.

use std::path::Path;
use std::str::FromStr;

use serde::Deserialize;

use super::error::OutlineError;

/// A point in the picture and in the finger's plane.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mark {
    /// Pixel (x to the right, y down, middle of the upper left one (0, 0)).
    pub pixel: [f64; 2],
    /// Place, mm.
    pub mm: [f64; 2],
}

impl FromStr for Mark {
    type Err = String;

    fn from_str(words: &str) -> Result<Self, String> {
        let read = || {
            let (pixel, mm) = words.split_once('=')?;
            Some(Self { pixel: pair(pixel)?, mm: pair(mm)? })
        };
        read().ok_or_else(|| "needed is PX,PY=X,Y: the pixel, and its place in mm, such as 412,1530=-14,-5".to_owned())
    }
}

/// Two numbers with a comma between them.
pub fn pair(words: &str) -> Option<[f64; 2]> {
    let (x, y) = words.split_once(',')?;
    let number = |word: &str| word.trim().parse::<f64>().ok().filter(|x| x.is_finite());
    Some([number(x)?, number(y)?])
}

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
