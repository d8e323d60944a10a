//! Pictures: the deformed finger, and charts of results, as SVG (light and dark) and PNG.

mod axis;
mod chart;
mod finger;
pub(crate) mod font;
pub(crate) mod heading;
mod keys;
mod number;
mod object;
mod palette;
pub(crate) mod path;
mod png;
mod room;
pub(crate) mod scene;
mod svg;

use std::path::Path;

use crate::files::{FileError, Files};

pub use chart::{Chart, Mark, Panel, Series, Style};
pub use finger::{FingerPicture, frames};
pub use keys::{KEY_PICTURES, key_picture};
pub use number::{short, significant};
pub use object::object_contour;
pub use palette::Ink;
pub use png::{PngError, Theme, png};
pub use scene::{Item, Scene, literal};
pub use svg::{moving_svg, svg, svg_in_page};

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
    #[error(transparent)]
    File(#[from] FileError),
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

/// Writes a picture in the format that the file's ending names, pixels on white, in place of what the file held.
///
/// # Errors
/// If the ending is not `.svg` or `.png`, or the file cannot be written.
pub fn write(scene: &Scene, file: &Path) -> Result<(), DrawError> {
    let bytes = encode(scene, Format::of(file)?, Theme::Light)?;
    Ok(Files::new(true).output(file, "the picture")?.write(&bytes)?)
}

/// A picture's file; the theme is that of pixels, an SVG has both.
///
/// # Errors
/// The picture cannot be painted.
pub fn encode(scene: &Scene, format: Format, theme: Theme) -> Result<Vec<u8>, DrawError> {
    Ok(match format {
        Format::Svg => svg(scene).into_bytes(),
        Format::Png => png(scene, PNG_SCALE, theme)?,
    })
}
