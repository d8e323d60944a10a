//! Plates: how much stiffer a wide wall bends that cannot curl across its width.

use crate::access::Access as _;
use crate::design::junction::{face_distances, flexible_ends};
use crate::design::{Design, HingeKind, PlaneStrain};

/// Length of the plate with straight ends that curls as the wall does, of the clear length, and of the wall's thickness on top: the ends
/// are more than straight, and give way a little; thin rungs more so. Chosen with 42 of 151 spans
/// (`cargo xtask bench plates`).
const CLEAR: f64 = 0.7;
const ENDS: f64 = 2.0;
const RUNGS: f64 = 0.5;

/// A stretch of a wall, neck or rib between what holds it straight across its width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plate {
    /// Width across the plane, mm.
    pub width: f64,
    /// Thickness in the plane, mm.
    pub thickness: f64,
    /// Clear length between what holds its ends, mm.
    pub clear: f64,
    /// Thicknesses of what holds its ends, mm; infinite for the base and the solid tip.
    pub holders: [f64; 2],
}

impl Plate {
    /// That of a beam, front (0) or back (1), at an arc length, mm.
    #[inline(never)]
    pub fn of_beam(design: &Design, side: usize, arc: f64) -> Self {
        let beam = if side == 0 { &design.front } else { &design.back };
        let attached = |lamella: usize| design.attachment_arcs(lamella).at(side);
        let count = design.lamella_count();
        let above = (0..count).find(|&lamella| attached(lamella) > arc);
        let below = above.unwrap_or(count).checked_sub(1).filter(|&lamella| attached(lamella) > beam.clamp);
        // Where the clear length ends, and what holds it there.
        let end = |lamella: usize, sign: f64| {
            let half_sine = 0.5 * beam.thickness.at(attached(lamella)) / face_distances(design, lamella).at(side);
            let (root, holder) = match (design.joint(), design.lamella_thickness(lamella).at(side)) {
                (HingeKind::Flexible, _) => (design.hinge.thickness, design.hinge.thickness),
                (HingeKind::Pinned, thick) => (0.0, thick),
                (HingeKind::Welded, thick) => (thick, thick),
            };
            (attached(lamella) + sign * 0.5 * root / half_sine, holder)
        };
        let (from, low) = below.map_or((beam.clamp, f64::INFINITY), |lamella| end(lamella, 1.0));
        let (to, high) = above.map_or((flexible_ends(design).at(side), f64::INFINITY), |lamella| end(lamella, -1.0));
        Self {
            width: design.width.at(beam.point(arc).at(1)),
            thickness: beam.thickness.at(arc),
            clear: (to - from).max(0.0),
            holders: [low, high],
        }
    }

    /// That of what bends of lamella k: its necks, or the rib.
    #[inline(never)]
    pub fn of_rung(design: &Design, lamella: usize) -> Self {
        let arcs = design.attachment_arcs(lamella);
        let (p, q) = (design.front.point(arcs.at(0)), design.back.point(arcs.at(1)));
        let [front, back] = design.lamella_thickness(lamella);
        let is_neck = design.joint() == HingeKind::Flexible;
        // Beams and bar keep a neck straight across its width; a rib in line with it does not.
        let (clear, holders) = if is_neck && design.lamellae.ribs().is_none() {
            (design.hinge.length_of(lamella), [f64::INFINITY; 2])
        } else {
            let [on_front, on_back] = face_distances(design, lamella);
            let beams = [design.front.thickness.at(arcs.at(0)), design.back.thickness.at(arcs.at(1))];
            ((libm::hypot(q[0] - p[0], q[1] - p[1]) - on_front - on_back).max(0.0), beams)
        };
        Self {
            width: design.width.at(0.5 * (p[1] + q[1])),
            thickness: if is_neck { design.hinge.thickness } else { 0.5 * (front + back) },
            clear,
            holders,
        }
    }

    /// Share of plane strain's stiffening that it has, 0 to 1, at a curvature that is small against its thickness over its width squared.
    ///
    /// A bent plate whose two ends are kept straight across its width and whose sides are free curls by Lévy's series
    /// (Timoshenko and Woinowsky-Krieger, *Theory of Plates and Shells*), here its first term.
    pub fn share(&self, poissons_ratio: f64) -> f64 {
        let (nu, Self { width, thickness, clear, holders: [low, high] }) = (poissons_ratio, *self);
        let length = CLEAR * clear + (ENDS + 0.5 * RUNGS * (thickness / low + thickness / high)) * thickness;
        let beta = 0.5 * core::f64::consts::PI * width * width / ((width + thickness) * length);
        // Narrower, and rounding would show; it bends as a beam.
        if beta < 1e-3 {
            return 0.0;
        }
        let decayed = libm::exp(-2.0 * beta);
        let tanh = (1.0 - decayed) / (1.0 + decayed);
        let waves = 4.0 * beta * decayed / (1.0 - decayed * decayed);
        1.0 - 2.0 * (1.0 + nu) * tanh / (beta * (3.0 + nu - (1.0 - nu) * waves))
    }
}

/// Factor on EI of a wall, neck or rib that cannot curl across its width: 1 to 1/(1 − ν²), as the design's [`PlaneStrain`] has it.
#[inline(never)]
pub fn plate_factor(design: &Design, plate: &Plate) -> f64 {
    let nu = design.material.poissons_ratio;
    let share = match design.plane_strain {
        PlaneStrain::Stress => 0.0,
        PlaneStrain::Strain => 1.0,
        PlaneStrain::Auto => plate.share(nu),
    };
    1.0 + share * nu * nu / (1.0 - nu * nu)
}
