//! A gap, across which a rung's free end is kept from passing: no element at all. Its way follows from what lies around it
//! (`newton::end_gaps`).

use super::{Constants, Depth, Element, Node, Past, Strain};
use crate::contact::{Row, Sample};
use crate::real::Real;

/// A member that is a gap.
pub(crate) struct EndGap;

impl<T: Real> Element<T> for EndGap {
    const SPARES_TANGENT: bool = false;

    /// Leaves a way of nothing, for which the gap's own takes its place.
    fn walk<D: Depth, P: Past<T>>(
        _: Constants<'_, T>,
        _: P,
        _: &[T],
        _: &[Row<T>],
        nodes: &mut [Node<T>],
        out: &mut Strain<T>,
    ) {
        for node in nodes {
            (node.strained, node.lever, node.bent) = (node.e, [T::ZERO; 2], [T::ZERO; 2]);
            (node.gradient, node.curvature) = (T::ZERO, T::ZERO);
            node.set_coupling([T::ZERO; 2]);
        }
        (out.chord, out.compliance, out.steepest) = ([T::ZERO; 2], [T::ZERO; 3], T::ZERO);
    }

    fn bend(_: Constants<'_, T>, _: &[T], _: &mut [Node<T>], _: &mut Strain<T>) {}

    fn lever(_: Constants<'_, T>, _: usize, _: &Sample<T>, _: &[Node<T>]) -> [[T; 2]; 3] {
        [[T::ZERO; 2]; 3]
    }

    fn between(_: &[T], first: u16, _: &Sample<T>, _: T) -> (u16, [T; 3]) {
        (first, [T::ZERO; 3])
    }

    fn turns(_: &Sample<T>, _: T) -> (usize, [T; 3]) {
        (0, [T::ZERO; 3])
    }

    fn section(_: &[T], _: impl Fn(usize) -> T, _: usize) -> (T, T) {
        (T::ZERO, T::ZERO)
    }

    fn arc(_: &[T], _: usize) -> T {
        T::ZERO
    }

    fn point(_: &[T], _: impl Fn(usize) -> [T; 2], _: usize, _: &mut [T; 2]) -> Option<[T; 2]> {
        None
    }

    fn point_back(_: &[T], _: impl Fn(usize) -> [T; 2], _: usize, _: &mut [T; 2]) -> Option<[T; 2]> {
        None
    }
}
