//! Marks printed as round dots: the dot's middle between the pixels from a place near it.

use super::error::OutlineError;
use super::homography::Homography;
use super::mark::Mark;
use super::median::median;
use super::photo::Photo;

/// Most moves towards the middle.
const MOVES: usize = 40;
/// The faintest dot, linear light.
const FAINTEST: f64 = 0.05;

/// Moves every mark to the middle of the dot on which (or near whose edge) it lies; `diameter` in mm.
///
/// # Errors
/// There is no such dot, or the marks determine no plane.
pub fn centred(marks: &[Mark], diameter: f64, photo: &Photo) -> Result<Vec<Mark>, OutlineError> {
    let pairs: Vec<_> = marks.iter().map(|mark| (mark.mm, mark.pixel)).collect();
    let map = Homography::fit(&pairs).ok_or(OutlineError::MarksOnLine)?;
    marks
        .iter()
        .map(|mark| {
            let none = || OutlineError::NoDot { mark: *mark, diameter };
            let [x, y] = mark.mm;
            let half = 0.5 * diameter;
            let ends = [[x - half, y], [x + half, y], [x, y - half], [x, y + half]].map(|end| map.apply(end));
            let [Some(a), Some(b), Some(c), Some(d)] = ends else { return Err(none()) };
            let radius = 0.25 * ((a[0] - b[0]).hypot(a[1] - b[1]) + (c[0] - d[0]).hypot(c[1] - d[1]));
            middle(photo, mark.pixel, radius).map(|pixel| Mark { pixel, ..*mark }).ok_or_else(none)
        })
        .collect()
}

/// Middle of a dot of a radius (pixels) near a place.
fn middle(photo: &Photo, start: [f64; 2], radius: f64) -> Option<[f64; 2]> {
    if !(1.5..=500.0).contains(&radius) {
        return None;
    }
    let mut at = start;
    for _ in 0..MOVES {
        let around = disc(photo, at, 2.2 * radius)?;
        let ring: Vec<f64> = around.iter().filter(|(_, _, r, _)| *r > 1.6 * radius).map(|p| p.3).collect();
        let ground = median(ring)?;
        // The light that differs most: what a dot under the middle of the window has at least.
        let mut inner: Vec<f64> =
            around.iter().filter(|(_, _, r, _)| *r < 1.2 * radius).map(|(.., light)| light - ground).collect();
        inner.sort_by(|a, b| b.abs().total_cmp(&a.abs()));
        let depth = *inner.get(inner.len() / 5)?;
        if depth.abs() < FAINTEST {
            return None;
        }
        let (mut sum, mut x, mut y) = (0.0, 0.0, 0.0);
        for &(dx, dy, r, light) in &around {
            if r < 1.6 * radius {
                let share = ((light - ground) / depth).clamp(0.0, 1.0);
                // What noise leaves of the ground must not pull.
                let share = if share < 0.15 { 0.0 } else { share };
                (sum, x, y) = (sum + share, x + share * dx, y + share * dy);
            }
        }
        if sum <= 0.0 {
            return None;
        }
        at = [at[0] + x / sum, at[1] + y / sum];
        if (x / sum).hypot(y / sum) < 1e-3 {
            let filled = sum / (std::f64::consts::PI * radius * radius);
            let moved = (at[0] - start[0]).hypot(at[1] - start[1]);
            return ((0.6..=1.5).contains(&filled) && moved < 3.0 * radius).then_some(at);
        }
    }
    None
}

/// Pixels within a radius: (dx, dy, distance, light); none if the disc leaves the picture.
fn disc(photo: &Photo, [x, y]: [f64; 2], radius: f64) -> Option<Vec<(f64, f64, f64, f64)>> {
    let mut pixels = Vec::new();
    for row in (y - radius).floor() as i64..=(y + radius).ceil() as i64 {
        for column in (x - radius).floor() as i64..=(x + radius).ceil() as i64 {
            let (dx, dy) = (column as f64 - x, row as f64 - y);
            let r = dx.hypot(dy);
            if r <= radius {
                pixels.push((dx, dy, r, photo.pixel(column, row)?));
            }
        }
    }
    Some(pixels)
}
