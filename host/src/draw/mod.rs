//! Pictures: the deformed finger, and charts of results, as SVG (light and dark) and PNG.

mod axis;
mod chart;
mod finger;
pub(crate) mod font;
pub(crate) mod heading;
mod object;
mod palette;
mod png;
pub(crate) mod scene;
mod svg;

use std::path::Path;

pub use chart::{Chart, Mark, Panel, Series, Style};
pub use finger::FingerPicture;
pub(crate) use finger::{short, significant};
#[cfg_attr(not(feature = "record"), allow(unused_imports))]
pub(crate) use object::object_outline;
pub use palette::Ink;
pub use png::{PngError, Theme, png};
pub use scene::{Item, Scene, Step, literal};
pub use svg::{svg, svg_in_page};

/// Pixels per CSS pixel of a PNG.
const PNG_SCALE: f64 = 2.0;

/// Why a picture could not be written.
#[derive(Debug, thiserror::Error)]
pub enum DrawError {
    /// The file's ending names no format.
    #[error("{file}: a picture's file ends in .svg or .png")]
    Ending {
        /// The file.
        file: String,
    },
    /// The file cannot be written.
    #[error("{file}: cannot be written: {source}")]
    Unwritable {
        /// The file.
        file: String,
        /// The system's words.
        source: std::io::Error,
    },
    /// The picture cannot be painted.
    #[error(transparent)]
    Png(#[from] PngError),
}

/// A file's picture format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Scalable.
    Svg,
    /// Pixels.
    Png,
}

impl Format {
    /// The format that a file's ending names.
    ///
    /// # Errors
    /// For any ending but `.svg` and `.png`.
    pub fn of(file: &Path) -> Result<Self, DrawError> {
        match file.extension().map(|ending| ending.to_ascii_lowercase()) {
            Some(ending) if ending == "svg" => Ok(Self::Svg),
            Some(ending) if ending == "png" => Ok(Self::Png),
            _ => Err(DrawError::Ending { file: file.display().to_string() }),
        }
    }
}

/// Writes a picture in the format that the file's ending names; pixels on white.
///
/// # Errors
/// If the ending is not `.svg` or `.png`, or the file cannot be written.
pub fn write(scene: &Scene, file: &Path) -> Result<(), DrawError> {
    write_in(scene, file, Theme::Light)
}

/// As [`write()`]; the theme is that of pixels, an SVG has both.
///
/// # Errors
/// As there.
pub fn write_in(scene: &Scene, file: &Path, theme: Theme) -> Result<(), DrawError> {
    let bytes = match Format::of(file)? {
        Format::Svg => svg(scene).into_bytes(),
        Format::Png => png(scene, PNG_SCALE, theme)?,
    };
    std::fs::write(file, bytes).map_err(|source| DrawError::Unwritable { file: file.display().to_string(), source })
}
