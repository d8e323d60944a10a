//! What the past of a material with memory adds to a member's forces (71).

use crate::real::Real;

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

impl<T: Real> Past<T> for Remembered<'_, T> {
    const IS_ANY: bool = true;

    /// The weighted sum of the node's layers. One and two terms, the usual numbers, go without a loop.
    #[inline(always)]
    fn stresses(self, node: usize) -> [T; 3] {
        let layers = self.layers.get(node * self.width..).unwrap_or(&[]);
        let [now, first, second, ..] = self.weights;
        match (self.width, layers) {
            (2, [s, h, ..]) => [0, 1, 2].map(|part| now * s[part] + first * h[part]),
            (3, [s, h, g, ..]) => [0, 1, 2].map(|part| now * s[part] + first * h[part] + second * g[part]),
            _ => {
                let mut sum = [T::ZERO; 3];
                for (layer, weight) in layers.iter().zip(self.weights).take(self.width) {
                    sum = [0, 1, 2].map(|part| sum[part] + weight * layer[part]);
                }
                sum
            }
        }
    }
}
