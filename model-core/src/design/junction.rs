//! Junctions: how far hinges reach into what they join, and beams into the solid tip.

use super::{Beam, Design};

/// A hinge's flexible length reaches this many hinge thicknesses into the beam. Fitted, with shear, to finite elements
/// (`tests/reference/tests/fea_80.rs`); without shear the neck needs 0.38 and 0.35 to give way as much.
pub(crate) const BEAM_ROOT: f64 = 0.33;
/// A hinge's flexible length reaches this many hinge thicknesses into the lamella (fitted to finite elements).
pub(crate) const BAR_ROOT: f64 = 0.32;

/// A beam's flexible length reaches this many of its thicknesses into the solid wedge at the tip: the notch between the beams
/// gives way a little (fitted to finite elements).
const TIP_ROOT: f64 = 0.1;

/// Arc lengths (front, back), mm, at which the flexible part of the beams ends, roots included.
pub(crate) fn flexible_ends(design: &Design) -> [f64; 2] {
    let ends = design.flexible_ends();
    let root = |beam: &Beam, end: f64| {
        let wedge = beam.length() - end;
        end + (TIP_ROOT * beam.thickness.at(end)).min(0.5 * wedge)
    };
    [root(&design.front, ends[0]), root(&design.back, ends[1])]
}

/// Distances (front, back), mm, from the centrelines to the beams' faces along lamella k:
/// half the thickness over the sine of the angle between beam and lamella.
#[inline(never)]
pub(crate) fn face_distances(design: &Design, lamella: usize) -> [f64; 2] {
    let arcs = design.attachment_arcs(lamella);
    let (p, q) = (design.front.point(arcs[0]), design.back.point(arcs[1]));
    let width = libm::hypot(q[0] - p[0], q[1] - p[1]);
    let along = [(q[0] - p[0]) / width, (q[1] - p[1]) / width];
    let distance = |beam: &Beam, arc: f64| {
        let e = beam.direction(arc);
        let sine = (e[0] * along[1] - e[1] * along[0]).abs();
        0.5 * beam.thickness.at(arc) / sine.max(0.1)
    };
    [distance(&design.front, arcs[0]), distance(&design.back, arcs[1])]
}
