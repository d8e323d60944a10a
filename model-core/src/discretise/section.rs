//! Stiffness and compliance of cross-sections, and how far hinges reach into what they join.

use super::Physics;
use crate::design::{Beam, Design, PlaneStrain};

/// A hinge's flexible length reaches this many hinge thicknesses into the beam. Fitted, with shear, to finite elements
/// (`tests/reference/tests/fea_80.rs`); without shear the neck needs 0.38 and 0.35 to give way as much.
pub(crate) const BEAM_ROOT: f64 = 0.33;
/// A hinge's flexible length reaches this many hinge thicknesses into the lamella (fitted to finite elements).
pub(crate) const BAR_ROOT: f64 = 0.32;

/// A beam's flexible length reaches this many of its thicknesses into the solid wedge at the tip: the notch between the beams
/// gives way a little (fitted to finite elements).
const TIP_ROOT: f64 = 0.1;

/// Arc lengths (front, back), mm, at which the flexible part of the beams ends, roots included.
pub(super) fn flexible_ends(design: &Design) -> [f64; 2] {
    let ends = design.flexible_ends();
    let root = |beam: &Beam, end: f64| {
        let wedge = beam.length() - end;
        end + (TIP_ROOT * beam.thickness.at(end)).min(0.5 * wedge)
    };
    [root(&design.front, ends[0]), root(&design.back, ends[1])]
}

/// Distances (front, back), mm, from the centrelines to the beams' faces along lamella k:
/// half the thickness over the sine of the angle between beam and lamella.
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

/// How far a bent strip's free edges curl, in thicknesses. Fitted to one three-dimensional finite-element result (20 mm wide,
/// 2 mm thick, ν = 0.48: 94.5 % of plane strain); other proportions are an extrapolation.
const EDGE: f64 = 1.2;

/// Factor on EI of a section (width, thickness, mm) that cannot curl across its width: 1 to 1/(1 − ν²), as the design's
/// [`PlaneStrain`] has it.
pub fn plate_factor(design: &Design, width: f64, thickness: f64) -> f64 {
    let nu = design.material.poissons_ratio;
    let strain = 1.0 / (1.0 - nu * nu);
    match design.plane_strain {
        PlaneStrain::Stress => 1.0,
        PlaneStrain::Strain => strain,
        PlaneStrain::Auto => {
            // Share of the width that is held flat; the free edges curl over EDGE thicknesses each.
            let held = (1.0 - 2.0 * EDGE * thickness / width).clamp(0.0, 1.0);
            1.0 + (strain - 1.0) * held
        }
    }
}

/// Stretch and shear compliance 1/EA and 1/κGA, 1/N, of a rectangular section of this area, mm² (times a stiffness factor).
///
/// κ = 10(1+ν)/(12+11ν): Cowper, J. Appl. Mech. 33 (1966).
pub(super) fn compliance(design: &Design, physics: Physics, area: f64) -> [f64; 2] {
    if physics == Physics::Paper {
        return [0.0; 2];
    }
    let nu = design.material.poissons_ratio;
    let stretch = 1.0 / (design.material.youngs_modulus * area);
    let kappa = 10.0 * (1.0 + nu) / (12.0 + 11.0 * nu);
    [stretch, stretch * 2.0 * (1.0 + nu) / kappa]
}
