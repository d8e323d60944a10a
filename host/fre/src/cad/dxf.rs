//! DXF: closed polylines in mm; lines, arcs and circles are read as well.

use std::io::Cursor;

use dxf::entities::{Entity, EntityType, LwPolyline};
use dxf::enums::{AcadVersion, Units};
use dxf::{Drawing as File, LwPolylineVertex};

use super::{CadError, Drawing};
use crate::finger::{Loop, Point};

/// Largest distance of an arc from the chords that it is read as, mm.
const CHORD: f64 = 2e-3;
/// Ends of lines that are nearer than this are joined, mm.
const APART: f64 = 1e-2;
/// The layer of the outline.
const LAYER: &str = "OUTLINE";

/// The drawing.
pub(super) fn encode(loops: &[Loop]) -> Result<Vec<u8>, CadError> {
    let mut file = File::new();
    file.header.version = AcadVersion::R2000;
    file.header.default_drawing_units = Units::Millimeters;
    for points in loops {
        let mut line = LwPolyline::default();
        line.set_is_closed(true);
        line.vertices = points.iter().map(|&[x, y]| LwPolylineVertex { x, y, ..Default::default() }).collect();
        let mut entity = Entity::new(EntityType::LwPolyline(line));
        entity.common.layer = LAYER.to_owned();
        file.add_entity(entity);
    }
    let mut bytes = Cursor::new(Vec::new());
    file.save(&mut bytes).map_err(|error| CadError::Unwritable(error.to_string()))?;
    Ok(bytes.into_inner())
}

/// Closed lines of a drawing's model space.
pub(super) fn decode(bytes: &[u8]) -> Result<Drawing, CadError> {
    let file = File::load(&mut Cursor::new(bytes))
        .map_err(|error| CadError::Content(format!("not a DXF that can be read: {error}")))?;
    let mut drawing = Drawing { has_origin: true, ..Drawing::default() };
    let scale = match file.header.default_drawing_units {
        Units::Millimeters => 1.0,
        Units::Centimeters => 10.0,
        Units::Meters => 1000.0,
        Units::Inches => 25.4,
        Units::Unitless => {
            drawing.notes.push("the drawing names no unit; mm are assumed".to_owned());
            1.0
        }
        other => {
            return Err(CadError::Content(format!("the drawing's unit is {other:?}; allowed is mm, cm, m or inch")));
        }
    };
    let mut open: Vec<Loop> = Vec::new();
    let mut aside = 0;
    for entity in file.entities() {
        let (mut line, closed) = match &entity.specific {
            EntityType::LwPolyline(poly) => {
                let corners: Vec<([f64; 2], f64)> =
                    poly.vertices.iter().map(|vertex| ([vertex.x, vertex.y], vertex.bulge)).collect();
                (bulged(&corners, poly.is_closed()), poly.is_closed())
            }
            EntityType::Polyline(poly) => {
                let corners: Vec<([f64; 2], f64)> =
                    poly.vertices().map(|vertex| ([vertex.location.x, vertex.location.y], vertex.bulge)).collect();
                (bulged(&corners, poly.is_closed()), poly.is_closed())
            }
            EntityType::Line(line) => (vec![[line.p1.x, line.p1.y], [line.p2.x, line.p2.y]], false),
            EntityType::Arc(arc) => {
                let (from, to) = (arc.start_angle.to_radians(), arc.end_angle.to_radians());
                let turn = (to - from).rem_euclid(std::f64::consts::TAU);
                (circular([arc.center.x, arc.center.y], arc.radius, from, turn), false)
            }
            EntityType::Circle(circle) => {
                let mut line = circular([circle.center.x, circle.center.y], circle.radius, 0.0, std::f64::consts::TAU);
                line.pop();
                (line, true)
            }
            EntityType::Spline(_) | EntityType::Ellipse(_) => {
                return Err(CadError::Content(
                    "the drawing has splines or ellipses; allowed are polylines, lines, arcs and circles".to_owned(),
                ));
            }
            _ => {
                aside += 1;
                continue;
            }
        };
        line.iter_mut().flatten().for_each(|x| *x *= scale);
        if line.len() > 1 {
            if closed { drawing.loops.push(line) } else { open.push(line) }
        }
    }
    let (joined, left) = super::joined(open, APART);
    drawing.loops.extend(joined);
    if aside + left > 0 {
        drawing
            .notes
            .push(format!("{aside} entities other than lines and {left} lines that are not closed were left aside"));
    }
    Ok(drawing)
}

/// A polyline whose sides may be arcs: a bulge is the tangent of a quarter of the arc's angle, positive to the right of the chord.
fn bulged(corners: &[(Point, f64)], closed: bool) -> Loop {
    let mut line = Loop::new();
    for (i, &(from, bulge)) in corners.iter().enumerate() {
        line.push(from);
        let next = if i + 1 < corners.len() { corners.get(i + 1) } else { corners.first().filter(|_| closed) };
        let Some(&(to, _)) = next else { continue };
        if bulge != 0.0 {
            let turn = 4.0 * bulge.atan();
            let chord = crate::finger::distance(from, to);
            let radius = 0.5 * chord / (0.5 * turn).sin();
            let d = crate::finger::minus(to, from).map(|x| x / chord.max(1e-12));
            // The centre lies to the left of the chord for a positive bulge of less than a half turn.
            let middle = [0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1])];
            let centre = crate::finger::along(middle, [-d[1], d[0]], radius * (0.5 * turn).cos());
            let spoke = crate::finger::minus(from, centre);
            let arc = circular(centre, radius.abs(), spoke[1].atan2(spoke[0]), turn);
            line.extend(&arc[1..arc.len() - 1]);
        }
    }
    line
}

/// Points of an arc, its ends included.
fn circular(centre: Point, radius: f64, from: f64, turn: f64) -> Loop {
    let pieces = (turn.abs() / (8.0 * CHORD / radius.max(CHORD)).sqrt()).ceil().max(1.0) as usize;
    let point = |i: usize| {
        let (sin, cos) = (from + turn * i as f64 / pieces as f64).sin_cos();
        [centre[0] + radius * cos, centre[1] + radius * sin]
    };
    (0..=pieces).map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bulge_is_an_arc_on_its_side_of_the_chord() {
        // A half circle below the chord from (−1, 0) to (1, 0), and a straight way back.
        let half = bulged(&[([-1.0, 0.0], 1.0), ([1.0, 0.0], 0.0)], true);
        assert!(half.iter().all(|p| (p[0].hypot(p[1]) - 1.0).abs() < 1e-12 && p[1] < 1e-12), "{half:?}");
        let lowest = half.iter().map(|p| p[1]).fold(0.0, f64::min);
        assert!((lowest + 1.0).abs() < 4e-3, "{lowest}");
    }
}
