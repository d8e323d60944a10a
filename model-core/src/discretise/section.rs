//! Compliance of cross-sections.

use super::Physics;
use crate::design::Design;

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
