//! The outline drawn over the photograph.

use tiny_skia::{
    Color, FilterQuality, LineCap, Paint, PathBuilder, Pixmap, PixmapPaint, PremultipliedColorU8, Stroke, Transform,
};

use super::error::OutlineError;
use super::extract::Outline;
use super::mark::Mark;
use super::photo::Photo;
use super::plane::Plane;

/// A line with gaps: points on the page.
type Pieces = Vec<Vec<[f32; 2]>>;

/// The longest side of the picture, pixels; larger photographs are shrunk.
const LONGEST: f64 = 2000.0;

/// A PNG: the photograph, the centreline (red), both edges (blue), and the marks (green crosses in rings).
/// `half_thickness` (mm) is a function of arc length.
///
/// # Errors
/// The photograph is too large to be painted.
pub fn png(
    photo: &Photo,
    plane: &Plane,
    marks: &[Mark],
    outline: &Outline,
    half_thickness: impl Fn(f64) -> f64,
) -> Result<Vec<u8>, OutlineError> {
    let failed = |reason: &str| OutlineError::Unwritable { file: photo.name.clone(), reason: reason.to_owned() };
    let [width, height] = photo.size();
    let mut picture = Pixmap::new(width, height).ok_or_else(|| failed("the photograph is too large to be painted"))?;
    for (to, from) in picture.pixels_mut().iter_mut().zip(photo.picture().pixels()) {
        let [r, g, b] = from.0;
        *to = PremultipliedColorU8::from_rgba(r, g, b, u8::MAX).unwrap_or(*to);
    }
    let scale = (LONGEST / f64::from(width.max(height))).min(1.0);
    let size = [width, height].map(|length| ((f64::from(length) * scale).round() as u32).max(1));
    let mut page = Pixmap::new(size[0], size[1]).ok_or_else(|| failed("the photograph is too large to be painted"))?;
    let quality = PixmapPaint { quality: FilterQuality::Bilinear, ..PixmapPaint::default() };
    page.draw_pixmap(0, 0, picture.as_ref(), &quality, Transform::from_scale(scale as f32, scale as f32), None);

    // Middles of pixels are whole numbers in the photograph, halves on the page.
    let on_page = |[x, y]: [f64; 2]| [((x + 0.5) * scale) as f32, ((y + 0.5) * scale) as f32];
    let mut lines: Vec<(Color, f32, Pieces)> = Vec::new();
    let shifted = |part: f64| -> Pieces {
        let mut pieces = vec![Vec::new()];
        let mut last: Option<f64> = None;
        for on in &outline.points {
            let side = part * outline.look.ratio * half_thickness(on.arc);
            let mm = [on.point[0] + side * on.tangent[1], on.point[1] - side * on.tangent[0]];
            if last.is_some_and(|last| on.arc - last > 2.5) {
                pieces.push(Vec::new());
            }
            last = Some(on.arc);
            if let (Some(pixel), Some(piece)) = (plane.pixel(mm), pieces.last_mut()) {
                piece.push(on_page(pixel));
            }
        }
        pieces
    };
    let blue = Color::from_rgba8(0x1a, 0x8c, 0xff, 255);
    lines.push((blue, 1.2, shifted(-1.0)));
    lines.push((blue, 1.2, shifted(1.0)));
    lines.push((Color::from_rgba8(0xe8, 0x20, 0x2a, 255), 1.8, shifted(0.0)));
    let crosses = marks.iter().flat_map(|mark| {
        let [x, y] = on_page(mark.pixel);
        let ring = (0..=36).map(|i| (i as f32 * 10.0).to_radians()).map(|a| [x + 14.0 * a.cos(), y + 14.0 * a.sin()]);
        [vec![[x - 8.0, y], [x + 8.0, y]], vec![[x, y - 8.0], [x, y + 8.0]], ring.collect()]
    });
    lines.push((Color::from_rgba8(0x12, 0xa1, 0x50, 255), 2.0, crosses.collect()));

    for (colour, wide, pieces) in lines {
        let mut paint = Paint { anti_alias: true, ..Paint::default() };
        paint.set_color(colour);
        let stroke = Stroke { width: wide, line_cap: LineCap::Round, ..Stroke::default() };
        for piece in pieces {
            let mut path = PathBuilder::new();
            for (i, [x, y]) in piece.into_iter().enumerate() {
                if i == 0 { path.move_to(x, y) } else { path.line_to(x, y) }
            }
            if let Some(path) = path.finish() {
                page.stroke_path(&path, &paint, &stroke, Transform::identity(), None);
            }
        }
    }
    page.encode_png().map_err(|error| failed(&error.to_string()))
}
