//! What the past of a material with memory adds to a member's forces (71).

use crate::real::Real;

/// What is left of the past at a node while a step is made: in the sign of the gradient and of the force f, in the step's unit. Nodes are
/// counted from the member's start.
pub(crate) trait Past<T: Real>: Copy {
    /// There is any: loops that have none are compiled without it.
    const IS_ANY: bool;

    /// Moment, of a chain of links that of the spring which begins at the node.
    fn moment(self, node: usize) -> T;

    /// Forces along and across.
    fn forces(self, node: usize) -> [T; 2];
}

/// A material without memory.
#[derive(Clone, Copy)]
pub(crate) struct NoPast;

impl<T: Real> Past<T> for NoPast {
    const IS_ANY: bool = false;

    #[inline(always)]
    fn moment(self, _: usize) -> T {
        T::ZERO
    }

    #[inline(always)]
    fn forces(self, _: usize) -> [T; 2] {
        [T::ZERO; 2]
    }
}

/// The most layers of a node: the accepted stress, and one for each term.
pub(crate) const MOST_LAYERS: usize = 5;

/// A member's stresses at the accepted state and what each term still has of them, and their weights in the present step.
#[derive(Clone, Copy)]
pub(crate) struct Remembered<'a, T> {
    /// Node by node, so many layers each.
    pub layers: &'a [[T; 3]],
    pub width: usize,
    pub weights: [T; MOST_LAYERS],
}

impl<T: Real> Remembered<'_, T> {
    /// The weighted sum of a node's layers, of which `pick` gives the part that is asked for. One and two terms, the usual numbers, go
    /// without a loop.
    #[inline(always)]
    fn sum(self, node: usize, pick: impl Fn(&[T; 3]) -> T) -> T {
        let layers = self.layers.get(node * self.width..).unwrap_or(&[]);
        let [now, first, second, ..] = self.weights;
        match (self.width, layers) {
            (2, [s, h, ..]) => now * pick(s) + first * pick(h),
            (3, [s, h, g, ..]) => now * pick(s) + first * pick(h) + second * pick(g),
            _ => {
                let layers = layers.iter().zip(self.weights).take(self.width);
                layers.fold(T::ZERO, |sum, (layer, weight)| sum + weight * pick(layer))
            }
        }
    }
}

impl<T: Real> Past<T> for Remembered<'_, T> {
    const IS_ANY: bool = true;

    #[inline(always)]
    fn moment(self, node: usize) -> T {
        self.sum(node, |&[moment, ..]| moment)
    }

    #[inline(always)]
    fn forces(self, node: usize) -> [T; 2] {
        [self.sum(node, |&[_, along, _]| along), self.sum(node, |&[.., across]| across)]
    }
}
