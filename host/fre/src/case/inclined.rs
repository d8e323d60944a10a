//! Inclined lamellae: from heights and angles to arcs along the beams.

use model_core::design::{Attachments, Beam};

use super::error::CaseError;
use super::explain::rounded;
use super::source::Table;

/// Parts into which a beam is cut to find where an axis crosses it, and halvings of such a part.
const PARTS: i32 = 64;
const HALVINGS: i32 = 50;

/// Attachments of lamellae whose axes go through the points midway between the beams' centrelines at the given heights, inclined by
/// the given angles, degrees, positive when the front end is lower.
pub(super) fn attachments(
    table: &Table<'_>,
    beams: [&Beam; 2],
    heights: &[f64],
    angles: &[f64],
) -> Result<Attachments, CaseError> {
    let mut arcs = [heapless::Vec::new(), heapless::Vec::new()];
    for (lamella, (&height, angle)) in heights.iter().zip(angles).enumerate() {
        let points = beams.map(|beam| beam.point(beam.arc_at_height(height)));
        let middle = [0, 1].map(|axis| 0.5 * (points[0][axis] + points[1][axis]));
        let (sin, cos) = angle.to_radians().sin_cos();
        for (side, beam) in beams.into_iter().enumerate() {
            let Some(arc) = crossing(beam, middle, [-cos, sin]) else {
                let name = ["front", "back"][side];
                let reason = format!(
                    "lamella {} (counted from 1 at the base) at {} mm, inclined by {} degrees, does not meet the {name} beam",
                    lamella + 1,
                    rounded(height),
                    rounded(*angle)
                );
                return Err(table.refuse_entry("angle_deg", lamella, reason));
            };
            // The lists are no longer than the schema allows.
            let _ = arcs[side].push(arc);
        }
    }
    let [front, back] = arcs;
    Ok(Attachments::Arcs { front, back })
}

/// Arc at which a line through a point crosses a beam's centreline next to the point.
fn crossing(beam: &Beam, point: [f64; 2], direction: [f64; 2]) -> Option<f64> {
    let beside = |arc: f64| {
        let [x, y] = beam.point(arc);
        direction[0] * (y - point[1]) - direction[1] * (x - point[0])
    };
    let length = beam.length();
    let at = |part: i32| length * f64::from(part) / f64::from(PARTS);
    let distance = |arc: f64| {
        let [x, y] = beam.point(arc);
        (x - point[0]).hypot(y - point[1])
    };
    let found = (0..PARTS).filter(|&part| beside(at(part)) * beside(at(part + 1)) <= 0.0);
    let found = found.map(|part| {
        let (mut low, mut high) = (at(part), at(part + 1));
        let sign = beside(low);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if beside(middle) * sign > 0.0 { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    });
    found.min_by(|&a, &b| distance(a).total_cmp(&distance(b)))
}
