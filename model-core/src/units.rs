//! The finger's own units of length and force, in which the solver computes.
//!
//! A finger of 4 mm in rubber and one of 2 m in steel pose the same problem but for two scales: a length and a force. The solver
//! therefore sees neither millimetres nor newtons. Lengths are divided by a unit length, forces by a unit force, and tolerances and
//! every other bound are the same numbers for all fingers. Both units are powers of two, so that the conversion adds no rounding.
//! They are 1 mm and 1 N for a finger of 80 mm in a soft plastic.
//!
//! Conversion happens where a finger is discretised (`discretise`), where an object is looked at (`Seen`) and where results are read
//! (`equilibrium`, `sensitivity`); everything between is dimensionless.

use crate::object::{Displacement, Gap, Object};
use crate::real::{Real, Vec2};
use crate::size::Blank;

/// Units of length and force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units<T> {
    /// Unit of length, mm; a power of two.
    pub length: T,
    /// Unit of force, N; a power of two.
    pub force: T,
}

impl<T: Real> Units<T> {
    /// Of a blank model: all zeros.
    pub(crate) const NONE: Self = Self { length: T::ZERO, force: T::ZERO };

    /// Unit of moment and energy, N·mm.
    pub fn moment(&self) -> T {
        self.length * self.force
    }

    /// A vector in mm from one in units of length.
    #[inline]
    pub(crate) fn millimetres(&self, [x, y]: [T; 2]) -> [T; 2] {
        [self.length * x, self.length * y]
    }

    /// A vector in N from one in units of force.
    #[inline]
    pub(crate) fn newtons(&self, [x, y]: [T; 2]) -> [T; 2] {
        [self.force * x, self.force * y]
    }
}

/// An object as the solver sees it: points, distances and curvatures in units of length.
#[derive(Clone, Copy)]
pub(crate) struct Seen<T, O> {
    object: O,
    /// Unit of length, mm, and its inverse.
    length: T,
    inverse: T,
}

impl<T: Real, O: Object<T>> Seen<T, O> {
    pub(crate) fn new(object: O, units: &Units<T>) -> Self {
        Self { object, length: units.length, inverse: T::one() / units.length }
    }
}

impl<T: Real, O: Object<T>> Blank for Seen<T, O> {
    const BLANK: Self = Self { object: O::BLANK, length: T::ZERO, inverse: T::ZERO };
}

impl<T: Real, O: Object<T>> Object<T> for Seen<T, O> {
    fn displaced(&self, by: &Displacement<T>) -> Self {
        Self { object: self.object.displaced(by), ..*self }
    }

    #[inline]
    fn gap(&self, point: Vec2<T>) -> Gap<T> {
        let gap = self.object.gap(point * self.length);
        Gap { distance: gap.distance * self.inverse, curvature: gap.curvature * self.length, ..gap }
    }

    fn sharpest(&self) -> T {
        self.object.sharpest() * self.inverse
    }

    #[inline]
    fn clears(&self, point: Vec2<T>, least: T) -> bool {
        self.object.clears(point * self.length, least * self.length)
    }
}
