//! What the past of a material with memory adds to a member's forces (71).

use crate::real::Real;

/// What is left of the past at a node while a step is made: in the sign of the gradient and of the force f, in the step's unit.
pub(crate) trait Past<T: Real>: Copy {
    /// There is any: loops that have none are compiled without it.
    const IS_ANY: bool;

    /// At a node of the member, counted from its start: moment (of a chain of links, that of the spring which begins at the node), and
    /// forces along and across.
    fn at(self, node: usize) -> [T; 3];
}

/// A material without memory.
#[derive(Clone, Copy)]
pub(crate) struct NoPast;

impl<T: Real> Past<T> for NoPast {
    const IS_ANY: bool = false;

    #[inline(always)]
    fn at(self, _: usize) -> [T; 3] {
        [T::ZERO; 3]
    }
}

/// A member's stresses at the accepted state and what each term still has of them, and their weights in the present step.
#[derive(Clone, Copy)]
pub(crate) struct Remembered<'a, T> {
    /// Node by node, an entry per weight.
    pub layers: &'a [[T; 3]],
    pub weights: &'a [T],
}

impl<T: Real> Past<T> for Remembered<'_, T> {
    const IS_ANY: bool = true;

    #[inline]
    fn at(self, node: usize) -> [T; 3] {
        let layers = self.layers.get(node * self.weights.len()..).unwrap_or(&[]);
        let mut sum = [T::ZERO; 3];
        for (layer, &weight) in layers.iter().zip(self.weights) {
            for (sum, &part) in sum.iter_mut().zip(layer) {
                *sum += weight * part;
            }
        }
        sum
    }
}
