//! Junctions: how far hinges reach into what they join, and beams into the solid tip.

use super::{Beam, Design};

/// A hinge's flexible length reaches this many hinge thicknesses into the beam. Fitted, with shear, to finite elements
/// (`tests/reference/tests/all/fea_80.rs`); without shear the neck needs 0.38 and 0.35 to give way as much.
pub(crate) const BEAM_ROOT: f64 = 0.33;
/// A hinge's flexible length reaches this many hinge thicknesses into the lamella (fitted to finite elements).
pub(crate) const BAR_ROOT: f64 = 0.32;

/// A beam's flexible length reaches this many of its thicknesses into the solid wedge at the tip: the notch between the beams
/// gives way a little (fitted to finite elements).
const TIP_ROOT: f64 = 0.1;
/// The same into a solid tip that begins below the notch, whose edge gives way more (fitted to finite elements).
const EDGE_ROOT: f64 = 0.7;
/// Length of that edge, in thicknesses of the beam, from which on it counts in full.
const FULL_EDGE: f64 = 0.25;

/// Arc lengths (front, back), mm, at which the flexible part of the beams ends, roots included.
pub(crate) fn flexible_ends(design: &Design) -> [f64; 2] {
    let ends = design.flexible_ends();
    let edge = lower_edge(design, ends);
    let root = |beam: &Beam, end: f64| {
        let (wedge, thickness) = (beam.length() - end, beam.thickness.at(end));
        let part = (edge / (FULL_EDGE * thickness)).clamp(0.0, 1.0);
        end + ((TIP_ROOT + part * (EDGE_ROOT - TIP_ROOT)) * thickness).min(0.5 * wedge)
    };
    [root(&design.front, ends[0]), root(&design.back, ends[1])]
}

/// Length of the solid tip's lower edge from face to face, mm; nothing or less where the faces have met below it.
fn lower_edge(design: &Design, ends: [f64; 2]) -> f64 {
    if design.rigid_above.is_none() {
        return 0.0;
    }
    let (p, q) = (design.front.point(ends[0]), design.back.point(ends[1]));
    let [front, back] = faces_along(design, ends);
    libm::hypot(q[0] - p[0], q[1] - p[1]) - front - back
}

/// Distances (front, back), mm, from the centrelines to the beams' faces along lamella k:
/// half the thickness over the sine of the angle between beam and lamella.
pub(crate) fn face_distances(design: &Design, lamella: usize) -> [f64; 2] {
    faces_along(design, design.attachment_arcs(lamella))
}

/// The same along the line between two arcs (front, back).
#[inline(never)]
fn faces_along(design: &Design, arcs: [f64; 2]) -> [f64; 2] {
    let (p, q) = (design.front.point(arcs[0]), design.back.point(arcs[1]));
    let width = libm::hypot(q[0] - p[0], q[1] - p[1]);
    if width == 0.0 {
        return [0.0; 2];
    }
    let along = [(q[0] - p[0]) / width, (q[1] - p[1]) / width];
    let distance = |beam: &Beam, arc: f64| {
        let e = beam.direction(arc);
        let sine = (e[0] * along[1] - e[1] * along[0]).abs();
        0.5 * beam.thickness.at(arc) / sine.max(0.1)
    };
    [distance(&design.front, arcs[0]), distance(&design.back, arcs[1])]
}
