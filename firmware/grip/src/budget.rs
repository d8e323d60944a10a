//! How many Newton iterations a tick may spend, so that it ends in its period.
//!
//! An estimate takes a fixed time (evaluation, reading, derivatives) and a time per iteration. Both are learnt from the ticks
//! before: a straight line through what was seen, and how far from it the ticks were, both of which forget. Ticks without an iteration do
//! not count: an open hand's are cheap for as long as it is open, and tell nothing of the tick in which it meets an object. Where there is
//! no time for more than a few, the clock is looked at after each: by then what it took is known, and how much time is left. What does not
//! fit waits for the next tick, and the estimator repeats its last good numbers with their age.

/// Part of what is known that every tick renews.
const PACE: f32 = 1.0 / 16.0;
/// An estimate that was interrupted seems more expensive than it was: what it took counts up to this multiple of what was expected, and
/// down to its reciprocal.
const STRANGE: f32 = 1.5;
/// How much longer than an estimate without an iteration one takes for each, as long as none was seen.
const UNSEEN: f32 = 4.0;
/// Variance of the number of iterations below which the ticks tell nothing of the slope: all of late took the same.
const ALIKE: f32 = 1e-4;
/// Part of an estimate's time that is then laid to its iterations. (A guess that a single other tick corrects.)
const LIKELY_SHARE: f32 = 0.75;
/// An estimate takes up to so many mean deviations more than expected, as a rule: with more samples in touch it takes longer.
const DEVIATIONS: f32 = 2.0;
/// Smallest part of an estimate of mean length that is laid to its iterations: an estimate that takes more of them takes longer.
const LEAST_SHARE: f32 = 0.25;

/// What iterations cost, ticks of the cost clock.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    /// As many as the estimator would spend by itself.
    most: u32,
    /// Whether anything was seen, and whether any iteration was.
    begun: bool,
    iterated: bool,
    /// Mean number of iterations, and of what the estimates took.
    iterations: f32,
    cost: f32,
    /// Variance of the iterations, and their covariance with the cost.
    variance: f32,
    covariance: f32,
    /// Mean deviation of the cost from what was expected, as a part of that.
    deviation: f32,
}

impl Budget {
    /// Nothing learnt, of an estimator that would spend so many iterations by itself.
    pub const fn new(most: u32) -> Self {
        Self {
            most,
            begun: false,
            iterated: false,
            iterations: 0.0,
            cost: 0.0,
            variance: 0.0,
            covariance: 0.0,
            deviation: 0.0,
        }
    }

    /// Iterations that the estimator would spend by itself.
    pub const fn most(&self) -> u32 {
        self.most
    }

    /// What one more iteration takes.
    fn each(&self) -> f32 {
        if !self.iterated {
            return UNSEEN * self.cost;
        }
        let most = self.cost / self.iterations.max(1.0);
        if self.variance < ALIKE {
            return LIKELY_SHARE * most;
        }
        (self.covariance / self.variance).max(LEAST_SHARE * most).min(most)
    }

    /// What an estimate of so many iterations is expected to take.
    fn expected(&self, iterations: u32) -> f32 {
        self.cost + (iterations as f32 - self.iterations) * self.each()
    }

    /// Iterations that fit into this time, ticks of the cost clock. One always: otherwise it would never come to an end.
    pub fn iterations(&self, left: u32) -> u32 {
        self.iterations_of(left, 1)
    }

    /// Whether an iteration more fits into this time, of which the tick has `spent` a part, on the last one `last`.
    pub fn allows_another(&self, left: u32, spent: u32, last: u32) -> bool {
        let next = self.each().max(last as f32) * (1.0 + DEVIATIONS * self.deviation);
        spent as f32 + next <= left as f32
    }

    /// The same for what may take so many times as many as an estimate.
    pub fn iterations_of(&self, left: u32, times: u32) -> u32 {
        if !self.begun {
            return 1;
        }
        let most = |count: u32| self.expected(count) * (1.0 + DEVIATIONS * self.deviation);
        let fits = |count: &u32| most(*count) <= left as f32;
        (1..=self.most.saturating_mul(times)).rev().find(fits).unwrap_or(1)
    }

    /// What an estimate took.
    pub fn spent(&mut self, cost: u32, iterations: u32) {
        if iterations == 0 && self.iterated {
            return;
        }
        let (mut cost, iterations) = (cost as f32, iterations as f32);
        if !self.begun || !self.iterated && iterations > 0.0 {
            *self = Self { begun: true, iterated: iterations > 0.0, iterations, cost, ..Self::new(self.most) };
            return;
        }
        let expected = (self.cost + (iterations - self.iterations) * self.each()).max(1.0);
        cost = cost.max(expected / STRANGE).min(expected * STRANGE);
        self.deviation += PACE * ((cost / expected - 1.0).abs() - self.deviation);
        let (more, dearer) = (iterations - self.iterations, cost - self.cost);
        self.iterations += PACE * more;
        self.cost += PACE * dearer;
        self.variance = (1.0 - PACE) * (self.variance + PACE * more * more);
        self.covariance = (1.0 - PACE) * (self.covariance + PACE * more * dearer);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MOST: u32 = 8;

    /// A clock by which an estimate takes a fixed time and a time per iteration.
    fn learnt(fixed: u32, each: u32, ticks: impl IntoIterator<Item = u32>) -> Budget {
        let mut budget = Budget::new(MOST);
        for iterations in ticks {
            budget.spent(fixed + each * iterations, iterations);
        }
        budget
    }

    #[test]
    fn what_fits_is_allowed() {
        assert_eq!(Budget::new(MOST).iterations(1_000_000), 1, "nothing is known");
        let budget = learnt(2_000, 1_000, [2, 3, 2, 1, 2, 3, 2, 2].into_iter().cycle().take(200));
        let allowed = [0, 2_990, 4_010, 5_010, 1_000_000].map(|left| budget.iterations(left));
        assert_eq!(allowed, [1, 1, 2, 3, MOST]);
    }

    #[test]
    fn what_takes_longer_may_where_there_is_time() {
        let budget = learnt(2_000, 1_000, [2, 3, 2, 1, 2, 3, 2, 2].into_iter().cycle().take(200));
        assert_eq!([4_010, 1_000_000].map(|left| budget.iterations_of(left, 3)), [2, 3 * MOST]);
    }

    /// The clock is looked at after each: one more is expected to take what the last one took, or what they take as a rule if that is more.
    #[test]
    fn another_is_allowed_while_there_is_time() {
        let budget = learnt(2_000, 1_000, [2, 3, 2, 1, 2, 3, 2, 2].into_iter().cycle().take(200));
        let allowed = |spent, last| budget.allows_another(10_000, spent, last);
        assert!(allowed(8_900, 500) && !allowed(9_100, 500), "as a rule");
        assert!(allowed(5_900, 4_000) && !allowed(6_100, 4_000), "the last one took longer");
        assert!(!allowed(11_000, 0), "the time is over");
        let unknown = Budget::new(MOST);
        assert!(unknown.allows_another(10_000, 5_000, 5_000) && !unknown.allows_another(10_000, 5_100, 5_100));
    }

    #[test]
    fn the_fixed_part_is_not_laid_to_the_iterations() {
        // Without contact an estimate takes no iteration; then it begins to take two and three.
        let free = std::iter::repeat_n(0, 500);
        let budget = learnt(3_000, 1_000, free.chain([2, 3].into_iter().cycle().take(100)));
        assert_eq!(budget.iterations(6_100), 3);
    }

    /// An open hand's ticks take no iteration and little time, however many there are; then it meets an object.
    #[test]
    fn cheap_ticks_of_an_open_hand_allow_no_dear_one() {
        let open = |mut budget: Budget| {
            for _ in 0..1_000 {
                budget.spent(60, 0);
            }
            budget
        };
        // What an iteration takes is not known: 240 is the guess.
        let guessed = [299, 530, 550, 1_000_000].map(|left| open(Budget::new(MOST)).iterations(left));
        assert_eq!(guessed, [1, 1, 2, MOST]);
        let known = learnt(60, 140, [1, 2].into_iter().cycle().take(100));
        let limits = [190, 210, 330, 350, 470, 490];
        assert_eq!(limits.map(|left| open(known).iterations(left)), limits.map(|left| known.iterations(left)));
        assert_eq!(limits.map(|left| known.iterations(left)), [1, 1, 1, 2, 2, 3]);
    }

    #[test]
    fn estimates_all_alike_allow_what_they_took_and_try_one_more() {
        let mut budget = learnt(200, 900, std::iter::repeat_n(1, 300));
        // 825 laid to the iteration, the rest to the estimate.
        assert_eq!([1_090, 1_110, 1_920, 1_930].map(|left| budget.iterations(left)), [1, 1, 1, 2]);
        // One that takes two shows that two take longer than that; it is kept in mind for a while.
        budget.spent(2_000, 2);
        for _ in 0..30 {
            budget.spent(1_100, 1);
        }
        assert_eq!([1_990, 2_040].map(|left| budget.iterations(left)), [1, 2]);
    }

    /// Estimates of as many iterations differ by the contact: what is allowed has room for those that take longer.
    #[test]
    fn what_is_allowed_has_room_for_dear_ones() {
        let spread = |dearer: u32| {
            let mut budget = Budget::new(MOST);
            for tick in 0..400 {
                let iterations = [1, 2][tick % 2];
                budget.spent(1_000 + 1_000 * iterations + [0, dearer][tick / 2 % 2], iterations);
            }
            budget
        };
        assert_eq!([3_100, 4_100].map(|left| spread(0).iterations(left)), [2, 3]);
        // Two iterations take 3,000 or 4,000.
        assert_eq!([3_100, 3_900, 5_100].map(|left| spread(1_000).iterations(left)), [1, 1, 2]);
    }

    #[test]
    fn one_interruption_hardly_changes_it_and_a_slow_clock_does() {
        let mut budget = learnt(500, 500, [1, 2, 3].into_iter().cycle().take(99));
        let before = budget.iterations(4_200);
        budget.spent(1_000_000, 1);
        assert!(budget.iterations(4_200) + 1 >= before, "{before}");
        for iterations in [1, 2, 3].into_iter().cycle().take(150) {
            budget.spent(8_000 * iterations, iterations);
        }
        assert_eq!(budget.iterations(8_100), 1);
        for iterations in [1, 2, 3].into_iter().cycle().take(300) {
            budget.spent(iterations, iterations);
        }
        assert_eq!(budget.iterations(8_000), MOST);
    }
}
