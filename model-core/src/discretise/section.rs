//! Stiffness and compliance of cross-sections.

use super::Physics;
use crate::design::{Design, PlaneStrain};

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
