//! What the past of a material with memory adds to a member's forces (71).

use crate::real::Real;
use crate::size::{Blank, Size};

/// What is left of the past at a node while a step is made: in the sign of the gradient and of the force f, in the step's unit. Nodes are
/// counted from the member's start.
pub(crate) trait Past<T: Real>: Copy {
    /// There is any: loops that have none are compiled without it.
    const IS_ANY: bool;

    /// Moment, of a chain of links that of the spring which begins at the node, and forces along and across.
    fn stresses(self, node: usize) -> [T; 3];

    /// The moment alone.
    #[inline(always)]
    fn moment(self, node: usize) -> T {
        let [moment, ..] = self.stresses(node);
        moment
    }

    /// The forces alone.
    #[inline(always)]
    fn forces(self, node: usize) -> [T; 2] {
        let [_, along, across] = self.stresses(node);
        [along, across]
    }
}

/// A material without memory.
#[derive(Clone, Copy)]
pub(crate) struct NoPast;

impl<T: Real> Past<T> for NoPast {
    const IS_ANY: bool = false;

    #[inline(always)]
    fn stresses(self, _: usize) -> [T; 3] {
        [T::ZERO; 3]
    }
}

/// What a node remembers.
pub(crate) struct Trace<T: Real, S: Size> {
    /// Elastic stresses S along and across at the accepted state.
    pub stress: [T; 2],
    /// Per term the part qᵢ of H/k: moment, along, across.
    pub left: S::Terms<[T; 3]>,
}

impl<T: Real, S: Size> Clone for Trace<T, S> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T: Real, S: Size> Copy for Trace<T, S> {}

impl<T: Real, S: Size> Blank for Trace<T, S> {
    const BLANK: Self = Self { stress: [T::ZERO; 2], left: S::Terms::BLANK };
}

impl<T: Real, S: Size> Trace<T, S> {
    /// H/k: moment, along, across.
    #[inline(always)]
    pub fn sum(&self) -> [T; 3] {
        let Some((&first, rest)) = self.left.as_ref().split_first() else { return [T::ZERO; 3] };
        rest.iter().fold(first, |sum, left| [0, 1, 2].map(|part| sum[part] + left[part]))
    }
}

/// What a member's nodes remember.
pub(crate) struct Remembered<'a, T: Real, S: Size>(pub &'a [Trace<T, S>]);

impl<T: Real, S: Size> Clone for Remembered<'_, T, S> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T: Real, S: Size> Copy for Remembered<'_, T, S> {}

impl<T: Real, S: Size> Past<T> for Remembered<'_, T, S> {
    const IS_ANY: bool = true;

    #[inline(always)]
    fn stresses(self, node: usize) -> [T; 3] {
        self.0.get(node).map_or([T::ZERO; 3], Trace::sum)
    }
}
