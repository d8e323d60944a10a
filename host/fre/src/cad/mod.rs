//! Closed outlines in files of drawings (DXF, SVG) and of solids (STL), mm.

mod dxf;
mod stl;
mod svg;

use std::path::Path;

use crate::finger::Loop;

/// Formats of drawings and solids.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// AutoCAD's drawing exchange: closed polylines in mm.
    Dxf,
    /// Scalable vector graphics: one path in mm.
    Svg,
    /// Triangles of the extruded outline, mm.
    Stl,
}

/// Why a file is not read or written.
#[derive(Debug, thiserror::Error)]
pub enum CadError {
    /// The name ends with nothing known.
    #[error("{file}: the ending names no format; allowed is .dxf, .svg and .stl")]
    Ending {
        /// The file.
        file: String,
    },
    /// The file cannot be read.
    #[error("{file}: {reason}")]
    Unreadable {
        /// The file.
        file: String,
        /// Why.
        reason: String,
    },
    /// What the file holds is not an outline.
    #[error("{0}")]
    Content(String),
    /// The outline cannot be written.
    #[error("the outline cannot be written: {0}")]
    Unwritable(String),
}

/// What a file holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drawing {
    /// Closed lines, in no order, mm, y upwards.
    pub loops: Vec<Loop>,
    /// Depth of a solid perpendicular to its outline, mm; a drawing has none.
    pub width: Option<f64>,
    /// True if the file's origin is where who made it put it; an SVG's is the corner of its page.
    pub has_origin: bool,
    /// What was left aside, for the reader.
    pub notes: Vec<String>,
}

impl Format {
    /// The format that a file's name ends with.
    ///
    /// # Errors
    /// It ends with none of them.
    pub fn of(path: &Path) -> Result<Self, CadError> {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        match ending.as_deref() {
            Some("dxf") => Ok(Self::Dxf),
            Some("svg") => Ok(Self::Svg),
            Some("stl") => Ok(Self::Stl),
            _ => Err(CadError::Ending { file: path.display().to_string() }),
        }
    }
}

/// A finger's outline as a file's bytes; `width` is the depth of the solid.
///
/// # Errors
/// The outline has no inside (STL), or a number is not finite.
pub fn encode(loops: &[Loop], width: f64, format: Format) -> Result<Vec<u8>, CadError> {
    if !loops.iter().flatten().flatten().chain([&width]).all(|x| x.is_finite()) {
        return Err(CadError::Unwritable("a coordinate is not a finite number".to_owned()));
    }
    match format {
        Format::Dxf => dxf::encode(loops),
        Format::Svg => Ok(svg::encode(loops).into_bytes()),
        Format::Stl => stl::encode(loops, width),
    }
}

/// The closed lines of a file's bytes.
///
/// # Errors
/// The bytes are not of that format, or hold no closed outline.
pub fn decode(bytes: &[u8], format: Format) -> Result<Drawing, CadError> {
    let mut drawing = match format {
        Format::Dxf => dxf::decode(bytes),
        Format::Svg => svg::decode(bytes),
        Format::Stl => stl::decode(bytes),
    }?;
    for points in &mut drawing.loops {
        points.dedup_by(|b, a| crate::finger::distance(*a, *b) < 1e-6);
        if points.len() > 1 && crate::finger::distance(points[0], points[points.len() - 1]) < 1e-6 {
            points.pop();
        }
    }
    drawing.loops.retain(|points| points.len() > 2);
    if drawing.loops.is_empty() {
        return Err(CadError::Content("there is no closed line in it; needed is the outline of a finger".to_owned()));
    }
    Ok(drawing)
}

/// Joins pieces end to end into closed lines; what stays open is given back by its number of pieces.
fn joined(mut pieces: Vec<Vec<crate::finger::Point>>, apart: f64) -> (Vec<Loop>, usize) {
    use crate::finger::distance;
    let (mut loops, mut open) = (Vec::new(), 0);
    while let Some(mut line) = pieces.pop() {
        loop {
            let (first, last) = (line[0], line[line.len() - 1]);
            if line.len() > 2 && distance(first, last) < apart {
                line.pop();
                loops.push(line);
                break;
            }
            let nearest = pieces
                .iter()
                .position(|piece| distance(piece[0], last) < apart || distance(piece[piece.len() - 1], last) < apart);
            let Some(index) = nearest else {
                open += 1;
                break;
            };
            let mut piece = pieces.swap_remove(index);
            if distance(piece[0], last) >= apart {
                piece.reverse();
            }
            line.extend(piece.into_iter().skip(1));
        }
    }
    (loops, open)
}
