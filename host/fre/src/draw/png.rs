//! A picture as PNG: the same paths painted, letters as paths.

use kurbo::PathEl;
use tiny_skia::{
    Color, FillRule, LineCap, LineJoin, Mask, Paint, PathBuilder, Pixmap, Stroke as Pen, StrokeDash, Transform,
};

use super::font::Fonts;
use super::palette::{Ink, Rgb};
use super::path::Path;
use super::scene::{Fill, Item, Scene, Stroke};

/// Why a picture could not be painted.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PngError {
    /// The picture has no area or too many pixels.
    #[error("a picture of {width} by {height} pixels cannot be painted; allowed is 1 by 1 to 16384 by 16384")]
    Size {
        /// Width, pixels.
        width: u32,
        /// Height, pixels.
        height: u32,
    },
    /// The pixels could not be packed.
    #[error("the picture could not be packed as PNG: {0}")]
    Packing(String),
}

/// Which of an ink's two colours are used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Theme {
    /// On white, for paper.
    Light,
    /// On black, for screens.
    Dark,
}

impl Theme {
    fn of(self, ink: Ink) -> Rgb {
        let (light, dark) = ink.colours();
        match self {
            Self::Light => light,
            Self::Dark => dark,
        }
    }
}

/// The picture as a PNG file, `scale` pixels per CSS pixel.
///
/// # Errors
/// If the picture's size in pixels is not between 1 and 16384.
pub fn png(scene: &Scene, scale: f64, theme: Theme) -> Result<Vec<u8>, PngError> {
    let (width, height) = ((scene.width * scale).round() as u32, (scene.height * scale).round() as u32);
    let size = PngError::Size { width, height };
    if !(1..=16_384).contains(&width) || !(1..=16_384).contains(&height) {
        return Err(size);
    }
    let mut map = Pixmap::new(width, height).ok_or(size)?;
    let [r, g, b] = theme.of(Ink::Paper);
    map.fill(Color::from_rgba8(r, g, b, 255));
    let fonts = Fonts::new();
    let mut canvas = Canvas { map, mask: None, theme, transform: Transform::from_scale(scale as f32, scale as f32) };
    for item in &scene.items {
        match item {
            Item::Path(path, fill, stroke) => canvas.paint(path, *fill, *stroke),
            Item::Text(text) => {
                let letters = fonts.path(text);
                if text.halo > 0.0 {
                    canvas.paint(&letters, None, Some(Stroke::new(Ink::Paper, text.halo).round()));
                }
                canvas.paint(&letters, Some(Fill { ink: text.ink, opacity: 1.0 }), None);
            }
            Item::Clip(rect) => {
                canvas.mask = Mask::new(width, height);
                if let (Some(mask), Some(area)) = (&mut canvas.mask, path_of(&Path::rectangle(*rect))) {
                    mask.fill_path(&area, FillRule::Winding, true, canvas.transform);
                }
            }
            Item::Unclip => canvas.mask = None,
        }
    }
    canvas.map.encode_png().map_err(|error| PngError::Packing(error.to_string()))
}

struct Canvas {
    map: Pixmap,
    mask: Option<Mask>,
    theme: Theme,
    transform: Transform,
}

impl Canvas {
    fn paint(&mut self, path: &Path, fill: Option<Fill>, stroke: Option<Stroke>) {
        let Some(path) = path_of(path) else { return };
        let theme = self.theme;
        let paint = |ink: Ink, opacity: f64| {
            let [r, g, b] = theme.of(ink);
            let mut paint = Paint { anti_alias: true, ..Paint::default() };
            paint.set_color_rgba8(r, g, b, (255.0 * opacity.clamp(0.0, 1.0)).round() as u8);
            paint
        };
        if let Some(fill) = fill {
            let paint = paint(fill.ink, fill.opacity);
            self.map.fill_path(&path, &paint, FillRule::Winding, self.transform, self.mask.as_ref());
        }
        if let Some(stroke) = stroke {
            let pen = Pen {
                width: stroke.width as f32,
                line_cap: if stroke.round { LineCap::Round } else { LineCap::Butt },
                line_join: if stroke.round { LineJoin::Round } else { LineJoin::Miter },
                dash: stroke.dash.and_then(|[dash, gap]| StrokeDash::new(vec![dash as f32, gap as f32], 0.0)),
                ..Pen::default()
            };
            let paint = paint(stroke.ink, 1.0);
            self.map.stroke_path(&path, &paint, &pen, self.transform, self.mask.as_ref());
        }
    }
}

fn path_of(path: &Path) -> Option<tiny_skia::Path> {
    let mut builder = PathBuilder::new();
    for element in &path.0 {
        let at = |p: kurbo::Point| (p.x as f32, p.y as f32);
        match element {
            PathEl::MoveTo(p) => {
                let (x, y) = at(p);
                builder.move_to(x, y);
            }
            PathEl::LineTo(p) => {
                let (x, y) = at(p);
                builder.line_to(x, y);
            }
            PathEl::QuadTo(a, p) => {
                let ((ax, ay), (x, y)) = (at(a), at(p));
                builder.quad_to(ax, ay, x, y);
            }
            PathEl::CurveTo(a, b, p) => {
                let ((ax, ay), (bx, by), (x, y)) = (at(a), at(b), at(p));
                builder.cubic_to(ax, ay, bx, by, x, y);
            }
            PathEl::ClosePath => builder.close(),
        }
    }
    builder.finish()
}
