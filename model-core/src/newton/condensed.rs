//! What condensation leaves: of a member at its joints and force, of a contact row on its own span.

use crate::real::Real;
use crate::size::Blank;

/// Condensed Hessian and gradient of a member in (a, b, x, y).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Condensed<T> {
    pub aa: T,
    pub ab: T,
    pub bb: T,
    /// Entries of a, of b and of the force with the force, and the correction of the end-to-end vector.
    pub ax: [T; 2],
    pub bx: [T; 2],
    pub xx: T,
    pub xy: T,
    pub yy: T,
    pub corrections: Corrections<T>,
}

/// What a member's interior takes from the gradient at a and b and from the end-to-end vector.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Corrections<T> {
    pub ra: T,
    pub rb: T,
    pub rx: [T; 2],
}

impl<T: Real> Blank for Condensed<T> {
    const BLANK: Self = Self {
        aa: T::ZERO,
        ab: T::ZERO,
        bb: T::ZERO,
        ax: [T::ZERO; 2],
        bx: [T::ZERO; 2],
        xx: T::ZERO,
        xy: T::ZERO,
        yy: T::ZERO,
        corrections: Corrections { ra: T::ZERO, rb: T::ZERO, rx: [T::ZERO; 2] },
    };
}

/// What a front span's condensed entries are to the contact rows on the spans above it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Front<T> {
    /// Entries of its joints and of its force with the force.
    pub ax: [T; 2],
    pub bx: [T; 2],
    pub xx: T,
    pub xy: T,
    pub yy: T,
    /// Correction of its end-to-end vector.
    pub rx: [T; 2],
}

impl<T: Real> Blank for Front<T> {
    const BLANK: Self =
        Self { ax: [T::ZERO; 2], bx: [T::ZERO; 2], xx: T::ZERO, xy: T::ZERO, yy: T::ZERO, rx: [T::ZERO; 2] };
}

impl<T: Real> Condensed<T> {
    pub fn front(&self) -> Front<T> {
        Front { ax: self.ax, bx: self.bx, xx: self.xx, xy: self.xy, yy: self.yy, rx: self.corrections.rx }
    }
}

/// A row's entries with its own span, after condensation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Own<T> {
    /// With the span's force; once the row has its column, with a force that goes through all that lies below as well.
    pub x: [T; 2],
    /// −n·∂P with the angles of the three nodes of its element, before condensation, mm.
    pub entries: [T; 3],
    /// Σ w C n: how the span's stretch and shear under the row move the sample, mm/N.
    pub strain: [T; 2],
}

impl<T: Real> Blank for Own<T> {
    const BLANK: Self = Self { x: [T::ZERO; 2], entries: [T::ZERO; 3], strain: [T::ZERO; 2] };
}
