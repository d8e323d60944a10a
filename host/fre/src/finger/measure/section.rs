//! Rays from the windows' edges into the material, and what they meet.

use super::Point;
use super::frame::Figure;
use crate::finger::{along, cross, distance, dot, minus};

/// Distance of samples along an edge, mm.
const STEP: f64 = 0.25;
/// Shorter edges have no direction of their own, mm.
const SHORT: f64 = 1e-3;

/// What a ray meets first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Hit {
    /// Distance from the ray's start.
    pub distance: f64,
    /// The window, from 0 at the base; none for the outside.
    pub window: Option<usize>,
    /// Cosine of the ray's angle to the edge's normal.
    pub square: f64,
}

/// A sample of a window's edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sample {
    /// The window.
    pub window: usize,
    /// Where.
    pub point: Point,
    /// Unit normal into the material.
    pub normal: Point,
    /// Length of edge that it stands for.
    pub length: f64,
    /// What lies across from it.
    pub hit: Hit,
}

/// Samples of all windows' edges.
pub(super) fn edges(figure: &Figure) -> Vec<Sample> {
    let mut samples = Vec::new();
    for (window, points) in figure.windows.iter().enumerate() {
        for (&a, &b) in points.iter().zip(points.iter().cycle().skip(1)) {
            let length = distance(a, b);
            if length < SHORT {
                continue;
            }
            let e = minus(b, a).map(|x| x / length);
            let normal = [-e[1], e[0]];
            let count = (length / STEP).ceil().max(1.0);
            for i in 0..count as usize {
                let point = along(a, e, length * (i as f64 + 0.5) / count);
                if let Some(hit) = ray(figure, point, normal) {
                    samples.push(Sample { window, point, normal, length: length / count, hit });
                }
            }
        }
    }
    samples
}

/// What a ray from a point meets first.
pub(super) fn ray(figure: &Figure, from: Point, direction: Point) -> Option<Hit> {
    let mut first: Option<Hit> = None;
    let loops = std::iter::once((None, &figure.outer));
    let loops = loops.chain(figure.windows.iter().enumerate().map(|(i, points)| (Some(i), points)));
    for (window, points) in loops {
        for (&a, &b) in points.iter().zip(points.iter().cycle().skip(1)) {
            let (e, to) = (minus(b, a), minus(a, from));
            let turn = cross(direction, e);
            if turn.abs() < 1e-12 {
                continue;
            }
            let (by, at) = (cross(to, e) / turn, cross(to, direction) / turn);
            if by > 1e-6 && (0.0..=1.0).contains(&at) && first.is_none_or(|hit| by < hit.distance) {
                let normal = [-e[1], e[0]].map(|x| x / e[0].hypot(e[1]));
                first = Some(Hit { distance: by, window, square: -dot(direction, normal) });
            }
        }
    }
    first
}
