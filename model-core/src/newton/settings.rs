//! What the Newton loop does otherwise in one precision than in another. The loop asks these settings, never the type.

use crate::real::{Real, Tolerance};

/// What a step with a kept factorisation leaves of small residuals at most, as a rule.
const NEARLY: f64 = 0.25;

/// Settings of the Newton loop.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NewtonSettings<T> {
    /// Contraction of the residuals by one step below which the next one keeps the factorisation (35); 0 for never.
    pub chord: T,
    /// What a kept factorisation does without is not evaluated.
    pub spares_tangents: bool,
    /// An attempt may begin with the factorisation of the last one, an earlier tick's.
    pub carries: bool,
    /// The front beam is strained again with the object's present normals (26).
    pub repositions: bool,
    /// Residuals of a solution.
    pub tolerance: Tolerance<T>,
    /// Residuals at which a step on the way to the coordinate asked for is accepted.
    pub on_the_way: Tolerance<T>,
}

impl<T: Real> NewtonSettings<T> {
    /// The defaults of a precision.
    ///
    /// In double precision a factorisation is kept below a contraction of 0.02; at 170/20 anything from 0.005 to 0.1 costs the same
    /// (`cargo xtask bench`). Motions in steps far below a count, such as those of differences, go on with it from tick to tick. In single
    /// precision one step is enough almost always, and none of these pays for its memory and code on the microcontroller: normals that are
    /// behind by a step matter less than its rounding, and a kept factorisation saves one part in a hundred of a count's instructions, which
    /// noting its rows costs again. With friction it saves up to a fifth of the most expensive ones.
    #[inline(always)]
    pub fn of_precision() -> Self {
        let is_double = T::EPSILON < T::of(1e-10);
        let Tolerance { gradient, length } = f32::TOLERANCE;
        Self {
            chord: if is_double { T::of(0.02) } else { T::ZERO },
            spares_tangents: is_double,
            carries: is_double,
            repositions: is_double,
            tolerance: T::TOLERANCE,
            on_the_way: Tolerance { gradient: T::of(f64::from(gradient)), length: T::of(f64::from(length)) },
        }
    }

    /// Factorisations are kept at all, for a finger with friction or without.
    #[inline(always)]
    pub fn keeps_factors(&self, rubs: bool) -> bool {
        rubs || self.chord > T::ZERO
    }

    /// The next step keeps the factorisation after one that has left this part of the residuals, which are now of this size, in tolerances.
    #[inline(always)]
    pub fn keeps(&self, rubs: bool, contraction: T, size: T) -> bool {
        contraction <= self.chord || rubs && contraction.min(T::of(NEARLY)) * size <= T::one()
    }
}
