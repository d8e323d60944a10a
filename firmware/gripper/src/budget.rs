//! How many Newton iterations a tick may spend, so that it ends in its period.
//!
//! What an iteration takes is learnt from the ticks before. Where fewer fit into what is left of the period than an estimate
//! would need, the estimator tells its last good numbers with their age, and goes on in the next tick.

use model_core::estimator::EstimatorSettings;

/// As many as the estimator would spend by itself.
const MOST: u32 = EstimatorSettings::DEFAULT.budget;
/// A tick that was interrupted seems dearer than it was, so that what is learnt grows by no more than this part a tick, and
/// falls by no more.
const PACE: u32 = 8;

/// What iterations cost.
#[derive(Clone, Copy, Debug, Default)]
pub struct Budget {
    /// Ticks of the cost clock per iteration.
    each: u32,
}

impl Budget {
    /// Nothing learnt: everything is allowed.
    pub const NEW: Self = Self { each: 0 };

    /// Iterations that fit into this time, ticks of the cost clock. One always: otherwise it would never come to an end.
    pub fn iterations(&self, left: u32) -> u32 {
        left.checked_div(self.each).unwrap_or(MOST).clamp(1, MOST)
    }

    /// What an estimate took.
    pub fn spent(&mut self, cost: u32, iterations: u32) {
        let seen = cost / iterations.max(1);
        let step = self.each / PACE + 1;
        self.each = match self.each {
            0 => seen,
            each => seen.clamp(each.saturating_sub(step), each.saturating_add(step)),
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_fits_is_allowed() {
        let mut budget = Budget::NEW;
        assert_eq!(budget.iterations(0), MOST, "nothing is known");
        budget.spent(3_000, 3);
        assert_eq!([0, 999, 2_500, 5_000, 1_000_000].map(|left| budget.iterations(left)), [1, 1, 2, 5, MOST]);
    }

    #[test]
    fn one_interruption_hardly_changes_it_and_a_slow_clock_does() {
        let mut budget = Budget::NEW;
        budget.spent(1_000, 1);
        budget.spent(1_000_000, 1);
        assert!(budget.iterations(8_000) >= 7);
        for _ in 0..40 {
            budget.spent(8_000, 1);
        }
        assert_eq!(budget.iterations(8_000), 1);
        for _ in 0..40 {
            budget.spent(0, 2);
        }
        assert_eq!(budget.iterations(8_000), MOST);
    }
}
