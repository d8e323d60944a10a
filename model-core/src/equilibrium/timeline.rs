//! A state at three instants: the present one, which a step is looking for, the last one accepted, and the one before that.
//!
//! A step begins at the accepted instant, predicted along the line through the last two where both are of one motion (40). It ends with
//! [`Timeline::accept`] or [`Timeline::reject`]; nothing else copies a state.

use super::SlipWay;
use crate::contact::ContactState;
use crate::model::Model;
use crate::real::Real;
use crate::size::Size;
use crate::state::State;

/// Longest prediction, in lengths of the last step.
const FARTHEST: f64 = 4.0;
/// Longest prediction backwards with friction: back to the instant before, but for rounding.
const BACK: f64 = 1.01;

/// What is looked for from the accepted instant over several calls.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Search {
    /// The next step, to larger coordinates or to smaller ones.
    Step { forward: bool },
    /// The same place with a past in which everything has slipped one way.
    Past(SlipWay),
}

/// The instants, and the coordinates of the accepted ones.
pub(crate) struct Timeline<T: Real, S: Size> {
    pub(crate) present: State<T, S>,
    pub(crate) accepted: State<T, S>,
    pub(super) previous: State<T, S>,
    at: T,
    before: T,
    /// Time since the accepted instant, s, and how much of it the step takes that is being looked for.
    elapsed: T,
    taken: T,
    /// The previous instant is of the same motion, and something touches at both.
    predicts: bool,
    /// Iterations that the search has had whose last instant is the previous one; 0 for none. (An `Option` would not be all zeros.)
    waits: u32,
    search: Search,
    /// The previous instant is a mark, which stays: nothing is predicted from it.
    is_marked: bool,
}

impl<T: Real, S: Size> Timeline<T, S> {
    pub(super) const EMPTY: Self = Self {
        present: State::EMPTY,
        accepted: State::EMPTY,
        previous: State::EMPTY,
        at: T::ZERO,
        before: T::ZERO,
        elapsed: T::ZERO,
        taken: T::ZERO,
        predicts: false,
        waits: 0,
        search: Search::Step { forward: false },
        is_marked: false,
    };

    /// Makes room for a model; false if there is none.
    pub(super) fn fit(&mut self, model: &Model<T, S>) -> bool {
        self.present.fit(model) && self.accepted.fit(model) && self.previous.fit(model)
    }

    /// The undeformed finger, present and accepted.
    pub(super) fn rest(&mut self) {
        self.present.rest();
        self.accepted.rest();
        (self.predicts, self.waits) = (false, 0);
        (self.elapsed, self.taken) = (T::ZERO, T::ZERO);
    }

    /// The instant that a step is looking for, and the accepted one.
    #[inline(always)]
    pub(super) fn present_and_accepted(&mut self) -> (&mut State<T, S>, &State<T, S>) {
        (&mut self.present, &self.accepted)
    }

    /// Largest difference of an angle between the present and the accepted instant, rad.
    pub(super) fn moved(&self, model: &Model<T, S>) -> T {
        self.present.largest_move(&self.accepted, model)
    }

    /// Coordinate of the accepted instant.
    #[inline]
    pub(crate) fn at(&self) -> T {
        self.at
    }

    /// Time passes, s.
    pub(super) fn pass(&mut self, seconds: T) {
        self.elapsed += seconds;
    }

    /// Time that the step takes which is being looked for, s.
    pub(super) fn taken(&self) -> T {
        self.taken
    }

    /// That step takes at most so long, s.
    pub(super) fn take_at_most(&mut self, seconds: T) {
        self.taken = self.taken.min(seconds);
    }

    /// Expresses the given loads in another unit, which the old one is `part` of.
    pub(super) fn reload(&mut self, part: T) {
        for load in [&mut self.present.load, &mut self.accepted.load, &mut self.previous.load] {
            *load = load.map(|force| part * force);
        }
    }

    /// Expresses all forces in another unit, which the old one is `part` of.
    pub(super) fn express(&mut self, part: T, model: &Model<T, S>) {
        self.present.express(part, model);
        self.accepted.express(part, model);
        self.previous.express(part, model);
    }

    /// Time that no accepted instant has had yet, s.
    pub(crate) fn elapsed(&self) -> T {
        self.elapsed
    }

    /// The step that is being looked for goes to a coordinate on the way to another, and takes its part of the time.
    pub(super) fn take(&mut self, target: T, to: T) {
        let (part, whole) = (target - self.at, to - self.at);
        self.taken = if part == whole { self.elapsed } else { self.elapsed * (part / whole).abs().min(T::one()) };
    }

    /// The accepted instant is at another coordinate now, and nothing is known of a motion.
    pub(super) fn stand(&mut self, at: T) {
        (self.at, self.before) = (at, at);
        (self.predicts, self.waits) = (false, 0);
    }

    /// Way to a coordinate, in lengths of the last step, if both are of one motion.
    pub(super) fn ahead(&self, to: T) -> Option<T> {
        let last = self.at - self.before;
        (self.predicts && last != T::ZERO).then(|| (to - self.at) / last)
    }

    /// A step along a motion that is known.
    pub(super) fn predicts(&self) -> bool {
        self.predicts
    }

    /// Everything that touches at the accepted instant sticks, without a tangential force.
    pub(super) fn stick(&mut self) {
        let touching = self.accepted.touching_count;
        self.accepted.slips.as_mut().iter_mut().take(touching).for_each(|state| *state = ContactState::Stick);
        self.accepted.tangential.as_mut().iter_mut().take(touching).for_each(|force| *force = T::ZERO);
    }

    /// What has been accepted is not a guide to the next step.
    pub(super) fn stop_predicting(&mut self) {
        self.predicts = false;
    }

    /// Moves the present instant on to a coordinate, along the line through the last two accepted ones.
    /// With friction a motion that turns round goes another way: backwards nothing is predicted beyond the two.
    pub(super) fn predict(&mut self, to: T, rubs: bool, model: &Model<T, S>) {
        let follows = |part: &T| part.abs() <= T::of(FARTHEST) && !(rubs && *part < -T::of(BACK));
        if let Some(part) = self.ahead(to).filter(follows) {
            self.present.predict(&self.previous, part, model);
        }
    }

    /// Accepts the present instant as that of a coordinate.
    pub(super) fn accept(&mut self, at: T, model: &Model<T, S>) {
        // A coordinate that has come again tells nothing of the motion.
        if at != self.at && !self.is_marked {
            self.previous.copy(&self.accepted, model);
            self.before = self.at;
        }
        self.accepted.copy(&self.present, model);
        (self.at, self.waits) = (at, 0);
        self.elapsed = (self.elapsed - self.taken).max(T::ZERO);
        self.taken = T::ZERO;
        self.predicts = !self.is_marked && self.accepted.touching_count > 0 && self.previous.touching_count > 0;
    }

    /// Back to the accepted instant.
    pub(super) fn reject(&mut self, model: &Model<T, S>) {
        self.present.copy(&self.accepted, model);
        self.taken = T::ZERO;
    }

    /// Keeps the accepted instant, for [`Self::go_back`], until [`Self::unmark`].
    pub(super) fn mark(&mut self, model: &Model<T, S>) {
        self.previous.copy(&self.accepted, model);
        (self.predicts, self.waits, self.is_marked) = (false, 0, true);
    }

    /// Some instant is marked.
    pub(super) fn is_marked(&self) -> bool {
        self.is_marked
    }

    /// Puts the present instant aside, of a search that has had so many iterations and goes on in a later call; the present one is the accepted one
    /// again. It takes the previous one's place, so that nothing is predicted until a step is accepted; false while that is marked.
    pub(super) fn put_aside(&mut self, search: Search, spent: u32, model: &Model<T, S>) -> bool {
        if !self.is_marked {
            self.previous.copy(&self.present, model);
            (self.predicts, self.search, self.waits) = (false, search, spent);
            // It is no instant of the motion, not even where the accepted coordinate comes again.
            self.before = self.at;
            self.reject(model);
        }
        !self.is_marked
    }

    /// The present instant is the one that was put aside in this search: the iterations that it has had. Zero, and nothing happens, where none was.
    pub(super) fn take_up(&mut self, search: Search, model: &Model<T, S>) -> u32 {
        if !self.is_sought(search) {
            return 0;
        }
        self.present.copy(&self.previous, model);
        core::mem::take(&mut self.waits)
    }

    /// Some search waits for a later call.
    pub(super) fn is_waited_for(&self) -> bool {
        self.waits > 0
    }

    /// This search waits for a later call.
    pub(super) fn is_sought(&self, search: Search) -> bool {
        self.waits > 0 && self.search == search
    }

    /// The accepted instant is the marked one again.
    pub(super) fn go_back(&mut self, model: &Model<T, S>) {
        self.accepted.copy(&self.previous, model);
    }

    pub(super) fn unmark(&mut self) {
        self.is_marked = false;
    }
}

#[cfg(test)]
mod tests {
    use std::boxed::Box;

    use super::*;
    use crate::size::Paper;

    /// Where the motor comes back from a search that was put aside, nothing is predicted from what that had found.
    #[test]
    fn what_was_put_aside_is_no_instant_of_the_motion() {
        let (model, mut timeline) = (Box::new(Model::EMPTY), Box::new(Timeline::<f64, Paper>::EMPTY));
        timeline.stand(1.0);
        timeline.present.touching_count = 1;
        for at in [1.0, 2.0, 3.0] {
            timeline.accept(at, &model);
        }
        assert_eq!(timeline.ahead(4.0), Some(1.0));
        for takes_up in [false, true] {
            let back = Search::Step { forward: false };
            assert!(timeline.put_aside(back, 2, &model));
            assert_eq!(timeline.ahead(4.0), None);
            assert!(!takes_up || timeline.take_up(back, &model) == 2);
            timeline.accept(3.0, &model);
            assert_eq!(timeline.ahead(4.0), None);
        }
        timeline.accept(3.5, &model);
        assert_eq!(timeline.ahead(4.0), Some(1.0));
    }
}
