//! Finger and object move together: what the finger answers at a place beside the accepted equilibrium, and taking that place.
//!
//! With friction the way matters. An object that gives way while the finger goes on is one step of both; first one, then the other would
//! rub to and fro.

use super::{Aside, Follower};
use crate::object::Object;
use crate::real::Real;
use crate::size::Size;
use crate::status::Status;

/// What a finger answers at a place.
#[derive(Clone, Copy)]
pub(crate) struct Answer<T> {
    /// Force (N) on the object and its moment (N·mm) about a point, world frame.
    pub wrench: [T; 3],
    /// `converged` if it is a stable equilibrium.
    pub status: Status,
    pub iterations: u32,
    /// How far the state is from the one whose inertia says that it is stable, rad.
    drift: T,
}

impl<T: Real, S: Size, O: Object<T>> Follower<T, S, O> {
    /// Solves for a place, `anew` from the accepted state or from the place tried last, in at most so many Newton iterations; the answer's moment
    /// is about a point of the world, mm. The workspace shows the place until [`Self::take`] or [`Self::show_accepted`]. `None` if there is
    /// no equilibrium to go on from, or a material that remembers.
    pub(crate) fn answer(&mut self, aside: &Aside<T>, about: [T; 2], iterations: u32, anew: bool) -> Option<Answer<T>> {
        if self.remembers() {
            return None;
        }
        let attempt = self.look(aside, iterations, anew, false)?;
        let wrench = self.solution_at(aside).wrench(about);
        let stable = attempt.inertia.is_none_or(|inertia| inertia.is_stable());
        let status = match attempt.status {
            Status::Converged if !stable => Status::Folded,
            Status::Converged if self.presses_from_behind() => Status::OutOfRange,
            status => status,
        };
        // A look without a factorisation has at least evaluated.
        Some(Answer { wrench, status, iterations: attempt.iterations.max(1), drift: attempt.drift })
    }

    /// Accepts the place that was tried last, with the object that is there.
    pub(crate) fn take(&mut self, aside: &Aside<T>, answer: &Answer<T>, to: impl Into<O>) {
        let at = self.timeline.at() + aside.along;
        self.object = to.into();
        self.drift = answer.drift;
        self.factored.is_near = false;
        self.accept(at);
        // The object may have moved: neither the line through the last two states nor the force's fall is of the finger's motion alone.
        self.timeline.stop_predicting();
        self.begin_fall(at);
    }
}
