//! The rungs between neighbouring windows: axis, thickness, necks; and the fillets.

use super::frame::{Figure, centroid};
use super::section::{Sample, ray};
use super::walls::{Walls, arc_beside, crossing, fitted};
use super::{MeasureError, Point};
use crate::finger::{along, distance, dot, minus};

/// Directions of edges that are one edge's, rad.
const SAME: f64 = 0.06;
/// Sections across a rung.
const SECTIONS: usize = 160;
/// A rung whose ends are thinner than this part of its middle has necks.
const NECK: f64 = 0.75;
/// Turns of a fillet's chords are smaller than this, rad.
const CHORD: f64 = 0.7;

/// A rung as it was measured, finger frame, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredRung {
    /// Arcs (front, back) at which its axis meets the centrelines.
    pub arcs: [f64; 2],
    /// Height at which the axis passes midway between the centrelines.
    pub height: f64,
    /// Angle of the axis, degrees, positive when the front end is lower.
    pub angle_deg: f64,
    /// Length between the walls' faces along the axis.
    pub clear: f64,
    /// Thickness at the front and at the back face; of a rung with necks its bar's.
    pub thickness: [f64; 2],
    /// Its necks, if it has any.
    pub necks: Option<Necks>,
}

/// Necks at both ends of a rung, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Necks {
    /// Clear lengths (front, back).
    pub lengths: [f64; 2],
    /// Thickness.
    pub thickness: f64,
}

impl MeasuredRung {
    /// The same in a frame whose origin lies lower.
    pub(super) fn moved(self, up: f64) -> Self {
        Self { height: self.height + up, ..self }
    }
}

/// Measures all rungs.
pub(super) fn rungs(figure: &Figure, samples: &[Sample], walls: &Walls) -> Result<Vec<MeasuredRung>, MeasureError> {
    (1..figure.windows.len()).map(|k| rung(figure, samples, walls, k)).collect()
}

/// The rung below window k.
fn rung(figure: &Figure, samples: &[Sample], walls: &Walls, k: usize) -> Result<MeasuredRung, MeasureError> {
    let between = 0.5 * (centroid(&figure.windows[k - 1])[1] + centroid(&figure.windows[k])[1]);
    let missing = || MeasureError::NoRung { rung: k - 1, height: between };
    let edge = |from: usize, to: usize| -> Option<Vec<Sample>> {
        let all: Vec<Sample> =
            samples.iter().filter(|s| s.window == from && s.hit.window == Some(to)).copied().collect();
        // The direction that most of the edge has.
        let like = |a: &Sample| {
            let same = all.iter().filter(|b| dot(a.normal, b.normal) > SAME.cos());
            same.map(|b| b.length).sum::<f64>()
        };
        let main = *all.iter().max_by(|a, b| like(a).total_cmp(&like(b)))?;
        Some(all.into_iter().filter(|s| dot(main.normal, s.normal) > SAME.cos()).collect())
    };
    let (below, above) = (edge(k - 1, k).ok_or_else(missing)?, edge(k, k - 1).ok_or_else(missing)?);
    let mean = |edge: &[Sample], pick: fn(&Sample) -> Point| -> Point {
        let total: f64 = edge.iter().map(|s| s.length).sum();
        [0, 1].map(|axis| edge.iter().map(|s| s.length * pick(s)[axis]).sum::<f64>() / total)
    };
    // Front to back: from larger to smaller x.
    let [n_below, n_above] = [&below, &above].map(|edge| mean(edge, |s| s.normal));
    let up = minus(n_below, n_above);
    let size = up[0].hypot(up[1]);
    let up = up.map(|x| x / size);
    let mut d = [-up[1], up[0]];
    let [p, q] = [&below, &above].map(|edge| mean(edge, |s| s.point));
    let mut middle = [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])];
    let mut profile = Vec::new();
    for _ in 0..3 {
        let ends = faces(walls, middle, d);
        profile = sections(figure, k, ends, d);
        let inner: Vec<Point> = profile.iter().filter(|s| (0.15..0.85).contains(&s.part)).map(|s| s.middle).collect();
        if inner.len() < 3 {
            return Err(missing());
        }
        let mean = [0, 1].map(|axis| inner.iter().map(|p| p[axis]).sum::<f64>() / inner.len() as f64);
        // The fit's direction is the points' order, front to back.
        (middle, d) = (mean, fitted(&inner).direction());
    }
    let ends = faces(walls, middle, d);
    let clear = distance(ends[0], ends[1]);
    let section = |by: f64| {
        let from = along(ends[0], d, by);
        thickness(figure, k, from, d).map(|s| s.thickness)
    };
    let mut sorted: Vec<f64> = profile.iter().map(|s| s.thickness).collect();
    sorted.sort_by(f64::total_cmp);
    let share = |part: f64| sorted[((sorted.len() - 1) as f64 * part) as usize];
    let (thin, thick) = (share(0.04), share(0.97));
    let is_thin = |t: f64| t < 0.5 * (thin + thick);
    let ends_are_thin =
        profile.first().is_some_and(|s| is_thin(s.thickness)) && profile.last().is_some_and(|s| is_thin(s.thickness));
    let necks = (thin < NECK * thick && ends_are_thin).then(|| {
        let shoulder = |from_front: bool| {
            let order: Vec<_> = if from_front { profile.iter().collect() } else { profile.iter().rev().collect() };
            let first = order.iter().position(|s| !is_thin(s.thickness)).unwrap_or(0);
            let mut inside = order[first].part * clear;
            let mut outside = order[first.saturating_sub(1)].part * clear;
            for _ in 0..40 {
                let half = 0.5 * (inside + outside);
                if section(half).is_some_and(is_thin) { outside = half } else { inside = half }
            }
            let by = 0.5 * (inside + outside);
            if from_front { by } else { clear - by }
        };
        let mut necks: Vec<f64> = profile.iter().map(|s| s.thickness).filter(|&t| is_thin(t)).collect();
        necks.sort_by(f64::total_cmp);
        Necks { lengths: [shoulder(true), shoulder(false)], thickness: necks[necks.len() / 2] }
    });
    let thickness = match necks {
        Some(_) => [median(profile.iter().map(|s| s.thickness).filter(|&t| !is_thin(t)).collect()); 2],
        None => {
            // A taper, from what lies clear of the fillets.
            let inner: Vec<Point> =
                profile.iter().filter(|s| (0.2..0.8).contains(&s.part)).map(|s| [s.part, s.thickness]).collect();
            let fit = fitted(&inner);
            let [x, y] = fit.direction();
            let slope = if x.abs() > 1e-9 { y / x } else { 0.0 };
            let at = median(inner.iter().map(|p| p[1]).collect());
            [at - 0.5 * slope, at + 0.5 * slope]
        }
    };
    let centres = [&walls.front.centre, &walls.back.centre];
    let meets = [0, 1].map(|side| crossing(centres[side], middle, d, ends[side]));
    let arcs = [0, 1].map(|side| arc_beside(centres[side], meets[side]));
    // The point of the axis that is midway between the centrelines at its own height.
    let mut height = 0.5 * (meets[0][1] + meets[1][1]);
    for _ in 0..60 {
        let x = [0, 1].map(|side| crossing(centres[side], [0.0, height], [1.0, 0.0], meets[side])[0]);
        height = middle[1] + (0.5 * (x[0] + x[1]) - middle[0]) * d[1] / d[0];
    }
    Ok(MeasuredRung { arcs, height, angle_deg: d[1].atan2(-d[0]).to_degrees(), clear, thickness, necks })
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

/// Where an axis meets the walls' inner faces.
fn faces(walls: &Walls, middle: Point, d: Point) -> [Point; 2] {
    [&walls.front, &walls.back].map(|wall| crossing(&wall.inner, middle, d, middle))
}

/// A section across a rung.
#[derive(Clone, Copy, Debug)]
struct Section {
    /// Part of the clear length from the front face.
    part: f64,
    middle: Point,
    thickness: f64,
}

fn sections(figure: &Figure, k: usize, ends: [Point; 2], d: Point) -> Vec<Section> {
    let length = distance(ends[0], ends[1]);
    (0..SECTIONS)
        .filter_map(|i| {
            let part = (i as f64 + 0.5) / SECTIONS as f64;
            let found = thickness(figure, k, along(ends[0], d, part * length), d)?;
            Some(Section { part, ..found })
        })
        .collect()
}

/// The section through a point inside the rung below window k; none where it does not reach from window to window.
fn thickness(figure: &Figure, k: usize, from: Point, d: Point) -> Option<Section> {
    let up = [d[1], -d[0]];
    let above = ray(figure, from, up).filter(|hit| hit.window == Some(k))?.distance;
    let below = ray(figure, from, [-up[0], -up[1]]).filter(|hit| hit.window == Some(k - 1))?.distance;
    let middle = along(from, up, 0.5 * (above - below));
    Some(Section { part: 0.0, middle, thickness: above + below })
}

/// Radius of the windows' rounded corners, mm: their median; 0 if fewer than half of the corners are rounded.
pub(super) fn fillet(figure: &Figure) -> f64 {
    let mut radii = Vec::new();
    for points in &figure.windows {
        let count = points.len();
        let turn = |i: usize| {
            let (a, b, c) = (points[(i + count - 1) % count], points[i % count], points[(i + 1) % count]);
            let (e, f) = (minus(b, a), minus(c, b));
            (crate::finger::cross(e, f).atan2(dot(e, f)), f[0].hypot(f[1]))
        };
        // From a vertex behind a long side on: runs of small turns one way with short sides between them.
        let Some(start) = (0..count).max_by(|&a, &b| turn(a).1.total_cmp(&turn(b).1)) else { continue };
        let (mut turned, mut length, mut turns) = (0.0, 0.0, 0);
        for i in start + 1..=start + count {
            let (by, side) = turn(i);
            if by < -0.02 && by > -CHORD {
                (turned, turns) = (turned - by, turns + 1);
                if side < 2.0 {
                    length += side;
                    continue;
                }
            }
            // A fillet of n chords has n − 1 whole turns and half of one at either end: n together.
            if turns >= 3 && turned > 0.5 && length > 0.0 {
                radii.push(length / turned);
            }
            (turned, length, turns) = (0.0, 0.0, 0);
        }
    }
    if 2 * radii.len() < 4 * figure.windows.len().saturating_sub(1) { 0.0 } else { median(radii) }
}
