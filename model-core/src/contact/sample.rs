//! Samples of the front beam and the gaps they see.

use crate::object::{Gap, Object};
use crate::real::{Real, Vec2};
use crate::size::Blank;

/// A material point of the front beam's centreline at which the gap is checked.
///
/// Its position is the start of its span plus Σ wᵢ dᵢ (strained directions), with wᵢ the full weight of the nodes before `node`,
/// `weights` for the three nodes from `node` on, and `rigid` times the rigid end of the span.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<T> {
    /// Cell whose front span carries the sample.
    pub cell: u16,
    /// First node with a weight of its own (index into the model's nodes).
    pub node: u16,
    /// Weights of that node and the next two, mm.
    pub weights: [T; 3],
    /// Part of the span's rigid end, 0 … 1.
    pub rigid: T,
    /// Arc length from the front beam's base, mm.
    pub arc: T,
    /// Half the beam's thickness, mm: distance from the centreline to the surface.
    pub half_thickness: T,
}

impl<T: Real> Blank for Sample<T> {
    const BLANK: Self =
        Self { cell: 0, node: 0, weights: [T::ZERO; 3], rigid: T::ZERO, arc: T::ZERO, half_thickness: T::ZERO };
}

/// Gap of a sample's surface point to the object.
#[inline]
pub(crate) fn sample_gap<T: Real, O: Object<T>>(object: &O, sample: &Sample<T>, position: Vec2<T>) -> Gap<T> {
    let mut gap = object.gap(position);
    gap.distance -= sample.half_thickness;
    gap
}
