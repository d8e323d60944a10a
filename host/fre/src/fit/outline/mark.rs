//! A mark: a point of the finger's plane whose place in millimetres is known.

use std::str::FromStr;

use serde::Deserialize;

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
