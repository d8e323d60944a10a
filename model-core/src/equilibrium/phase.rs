//! What the follower does from call to call: follow, look beyond the end of a branch, or wait for the return.

use super::{Follower, Outcome, Target};
use crate::object::Object;
use crate::real::Real;
use crate::size::Size;
use crate::status::Status;

/// What the follower is doing between calls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Phase<T> {
    /// There is no accepted equilibrium.
    Lost,
    /// At an accepted equilibrium.
    Following,
    /// On the way from the end of a branch to rest.
    Folding { target: T, shift: T, spent: u32 },
    /// The branch cannot be followed beyond the accepted equilibrium and no other was found; the path back is open.
    Ended { forward: bool },
}

/// Ends of branches that one call looks beyond. Where two branches end into each other, more would go on for ever.
const FOLDS: u32 = 24;
impl<T: Real, S: Size, O: Object<T>> Follower<T, S, O> {
    /// Follows the equilibrium towards a coordinate with at most `budget` Newton iterations and accepted steps.
    ///
    /// With `max-iterations` the coordinate was not reached yet; the next call goes on from where this one stopped.
    pub fn follow_within(&mut self, to: impl Into<Target>, budget: u32) -> Outcome {
        let to = to.into();
        if self.model.cells() == 0 || !to.is_valid() {
            return Outcome::at(Status::OutOfRange);
        }
        self.timeline.pass(T::of(to.time_step_s));
        let outcome = self.follow_on(T::of(to.coordinate), budget, false);
        self.named(outcome)
    }

    /// It is on the way from the end of a branch to rest.
    pub(crate) fn is_folding(&self) -> bool {
        matches!(self.phase, Phase::Folding { .. })
    }

    /// Where it is room that lacks, iterations are of no use.
    pub(super) fn named(&self, outcome: Outcome) -> Outcome {
        match outcome.status {
            Status::MaxIterations if self.crowded => Outcome { status: Status::ContactCapacity, ..outcome },
            _ => outcome,
        }
    }

    /// Follows towards a coordinate in the time that has passed; where it `is_short` of iterations, as well as they allow.
    pub(super) fn follow_on(&mut self, to: T, budget: u32, is_short: bool) -> Outcome {
        let mut outcome = Outcome::at(Status::OutOfRange);
        let mut folds = 0;
        loop {
            match self.phase {
                Phase::Lost => {
                    // An open hand is a new beginning.
                    if !self.is_clear(to) {
                        outcome.status = Status::OutOfRange;
                        return outcome;
                    }
                    self.rest();
                    self.timeline.stand(to);
                }
                Phase::Ended { forward } => {
                    if (to > self.timeline.at()) == forward {
                        outcome.status = self.or_open_hand(to, self.failed);
                        return outcome;
                    }
                    self.phase = Phase::Following;
                }
                Phase::Folding { target, shift, spent } => {
                    let left = budget.saturating_sub(outcome.iterations);
                    if left == 0 {
                        outcome.status = Status::MaxIterations;
                        return outcome;
                    }
                    folds += u32::from(spent == 0);
                    if folds > FOLDS {
                        self.reject();
                        self.phase = Phase::Ended { forward: target > self.timeline.at() };
                        continue;
                    }
                    self.fold(target, shift, spent, left, &mut outcome);
                }
                Phase::Following => {
                    let done = self.advance(to, budget, is_short, &mut outcome);
                    if let Some(status) = done {
                        // A search that goes on in the next call has no time to lose.
                        let shows = !status.is_trustworthy() && !self.timeline.is_waited_for();
                        outcome.status = if shows { self.or_open_hand(to, status) } else { status };
                        return outcome;
                    }
                }
            }
        }
    }

    /// Where no branch leads on but the object lies clear of the undeformed finger, that is the equilibrium: an open hand
    /// is always a new beginning. Otherwise the accepted state is shown with the status that says what failed.
    pub(super) fn or_open_hand(&mut self, to: T, failed: Status) -> Status {
        // A budget that ran out says nothing about the branch.
        if failed != Status::MaxIterations && self.is_clear(to) {
            self.rest();
            self.accept(to);
            return self.standing();
        }
        self.show_accepted();
        failed
    }
}
