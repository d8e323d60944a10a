//! Residuals at which an equilibrium is one.

use super::Follower;
use crate::design::Design;
use crate::object::Object;
use crate::real::{Real, Tolerance};
use crate::size::Size;

/// Bending stiffness over length of a beam up to which a precision's tolerance of moments is meant, N·mm, and the length for that of
/// lengths, mm: twice those of a finger of 80 mm in a soft plastic. Rounding grows with a finger's stiffness and size, so the
/// tolerances of a larger one do too.
const MEANT: [f64; 2] = [20.0, 160.0];

/// A finger's stiffness and length over what the tolerances are meant for, at least 1.
pub(super) fn size(design: &Design) -> [f64; 2] {
    let mut most = [0.0_f64; 2];
    for beam in [&design.front, &design.back] {
        let length = libm::hypot(beam.tip[0] - beam.base[0], beam.tip[1] - beam.base[1]);
        let thickness = beam.thickness.at(0.0);
        let stiffness = design.material.youngs_modulus * beam.stiffness_factor * design.width.at(0.0) / 12.0;
        most[0] = most[0].max(stiffness * thickness * thickness * thickness / length);
        most[1] = most[1].max(length);
    }
    [(most[0] / MEANT[0]).max(1.0), (most[1] / MEANT[1]).max(1.0)]
}

impl<T: Real, S: Size, O: Object<T>> Follower<T, S, O> {
    /// Residuals of an equilibrium.
    pub(crate) fn tolerance(&self) -> Tolerance<T> {
        let Tolerance { gradient, length } = T::TOLERANCE;
        Tolerance { gradient: gradient * self.size[0], length: length * self.size[1] }
    }

    /// Residuals at which a step on the way to the coordinate asked for is accepted: single precision's, whatever the precision.
    pub(super) fn on_the_way(&self) -> Tolerance<T> {
        let Tolerance { gradient, length } = f32::TOLERANCE;
        let [moments, lengths] = self.size;
        Tolerance { gradient: T::of(f64::from(gradient)) * moments, length: T::of(f64::from(length)) * lengths }
    }
}
