//! Why there is no outline.

use super::checkerboard::NoBoard;
use super::mark::Mark;
use super::zhang::NoCamera;

/// Why there is no outline.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum OutlineError {
    /// A file cannot be read.
    #[error("{file}: cannot be read: {reason}")]
    Unreadable {
        /// The file.
        file: String,
        /// Why.
        reason: String,
    },
    /// A picture with more pixels than there is memory for.
    #[error("{file}: has {width}×{height} pixels; allowed are up to {} million", super::limits::MOST_PIXELS / 1_000_000)]
    TooManyPixels {
        /// The file.
        file: String,
        /// Its width, pixels.
        width: u32,
        /// Its height, pixels.
        height: u32,
    },
    /// A file cannot be written.
    #[error("{file}: cannot be written: {reason}")]
    Unwritable {
        /// The file.
        file: String,
        /// Why.
        reason: String,
    },
    /// A TOML file that cannot be used.
    #[error("{file}:{line}: {reason}")]
    Toml {
        /// The file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// What is wrong.
        reason: String,
    },
    /// An option that cannot be used.
    #[error("{0}")]
    Option(String),
    /// Fewer than four marks.
    #[error("{0} marks given; needed are at least 4 (--marks PX,PY=X,Y)")]
    TooFewMarks(usize),
    /// A mark lies outside the picture.
    #[error("the mark {},{}={},{} lies outside the picture; allowed are pixels 0,0 to {},{}", .mark.pixel[0], .mark.pixel[1], .mark.mm[0], .mark.mm[1], .width - 1, .height - 1)]
    MarkOutside {
        /// The mark.
        mark: Mark,
        /// The picture's width, pixels.
        width: u32,
        /// The picture's height, pixels.
        height: u32,
    },
    /// No dot where a mark is.
    #[error("the mark {},{}={},{} is not on a round dot of {diameter} mm that differs from what surrounds it", .mark.pixel[0], .mark.pixel[1], .mark.mm[0], .mark.mm[1])]
    NoDot {
        /// The mark.
        mark: Mark,
        /// The dots' diameter, mm.
        diameter: f64,
    },
    /// Marks on a line.
    #[error(
        "the marks lie on a line, or three of four do: choose four that span the finger like the corners of a frame"
    )]
    MarksOnLine,
    /// Marks in the wrong order.
    #[error("no camera sees the marks so: probably two of them have each other's millimetres")]
    MarksCrossed,
    /// The camera was calibrated for pictures of another size.
    #[error("the camera was calibrated with pictures of {}×{} pixels, this one has {}×{}: take all with the same camera, zoom and focus", .camera[0], .camera[1], .photo[0], .photo[1])]
    OtherSize {
        /// Of the calibration.
        camera: [u32; 2],
        /// Of the photograph.
        photo: [u32; 2],
    },
    /// The lens model cannot have produced a pixel.
    #[error("the lens distortion has no inverse at pixel {:.0},{:.0}: the checkerboard was not seen so far outside", .0[0], .0[1])]
    NoInverse([f64; 2]),
    /// A checkerboard was not found.
    #[error("{file}: {reason}")]
    Board {
        /// The picture.
        file: String,
        /// Why.
        reason: NoBoard,
    },
    /// The checkerboards determine no camera.
    #[error(transparent)]
    Camera(#[from] NoCamera),
    /// The watcher stopped it.
    #[error("stopped")]
    Stopped,
    /// The finger's base lies outside the picture.
    #[error("the marks put the finger's base at pixel {:.0},{:.0}, outside the picture: check their millimetres and --frame", .at[0], .at[1])]
    FingerOutside {
        /// Where, pixels.
        at: [f64; 2],
    },
    /// Nothing that looks like the beam.
    #[error(
        "no beam {thickness} mm thick near pixel {:.0},{:.0} (arc length {from:.0} to {to:.0} mm); {}", .at[0], .at[1],
        if *.contrast < super::limits::FAINTEST {
            format!("the contrast is too low: {:.1} % of white, needed is {:.0} %", 100.0 * .contrast, 100.0 * super::limits::FAINTEST)
        } else if *.thickness_px < super::limits::THINNEST_PX {
            format!("the picture is too coarse: the beam is {:.1} pixels thick, needed are about {:.0}", .thickness_px, super::limits::THINNEST_PX)
        } else {
            "no two edges so far apart along it: check the light, the marks, the motor angle, --frame and the finger's thickness".to_owned()
        }
    )]
    NoBeam {
        /// Thickness of the design, mm.
        thickness: f64,
        /// The same in the picture, pixels.
        thickness_px: f64,
        /// First arc length looked at, mm.
        from: f64,
        /// Last, mm.
        to: f64,
        /// Where it was looked for, pixels.
        at: [f64; 2],
        /// Change of light there, linear light of 0 to 1.
        contrast: f64,
    },
    /// The edges end.
    #[error(
        "no edge of the beam from arc length {from:.1} to {to:.1} mm, near pixel {:.0},{:.0}{}; --from-mm and --to-mm leave parts out",
        .at[0], .at[1], if *.inside { "" } else { " outside the picture" }
    )]
    NoEdge {
        /// From, mm.
        from: f64,
        /// To, mm.
        to: f64,
        /// Where it was looked for, pixels.
        at: [f64; 2],
        /// Within the picture.
        inside: bool,
    },
}

impl OutlineError {
    /// A TOML parser's words about a file's text, with the line they are about.
    pub fn toml(file: &str, text: &str, error: &toml::de::Error) -> Self {
        let at = error.span().map_or(0, |span| span.start).min(text.len());
        let line = text.as_bytes()[..at].iter().filter(|&&byte| byte == b'\n').count() + 1;
        let reason = error.message().split_whitespace().collect::<Vec<_>>().join(" ");
        Self::Toml { file: file.to_owned(), line, reason }
    }
}
