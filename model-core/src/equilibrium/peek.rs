//! Looking at a place beside the accepted equilibrium, which stays: what friction would answer to a small motion, and what the forces would be
//! with another past.

use super::timeline::Search;
use super::{Follower, Moved, SlipWay};
use crate::contact::SlipState;
use crate::newton::attempt::{Attempt, Judged, Limits};
use crate::newton::settings::NewtonSettings;
use crate::object::Object;
use crate::real::Real;
use crate::size::Size;
use crate::solution::{Reading, Solution};
use crate::status::Status;

/// Where to look, from the accepted equilibrium.
#[derive(Clone, Copy)]
pub(crate) struct Aside<T> {
    /// Way along the motion, rad or mm.
    pub along: T,
    /// How the object has moved there. One that spins is not moved otherwise.
    pub moved: Moved<T>,
    /// Everything that touches slips one way, whatever its past.
    pub forced: Option<SlipWay>,
}

/// What a search has come to.
#[derive(Clone, Copy)]
pub(crate) enum Sought<X> {
    /// It has found this.
    Found(X),
    /// There is nothing to be found.
    Nowhere,
    /// It goes on in the next call.
    Waits,
}

/// Newton iterations that a search may have in a call, and in all.
#[derive(Clone, Copy)]
pub(crate) struct Patience {
    pub now: u32,
    pub most: u32,
    /// What an iteration costs is bounded.
    pub is_short: bool,
}

impl<T: Real, S: Size, O: Object<T>> Follower<T, S, O> {
    /// Looks at a place with one Newton iteration. What that leaves is not looked at: it is for the derivative of a short way. `None` if there is no
    /// equilibrium; at most one evaluation more.
    pub(crate) fn peek(&mut self, aside: Aside<T>, is_short: bool) -> Option<Reading<T>> {
        self.look(&aside, 1, true, is_short)?;
        let found = self.solution_at(&aside).reading();
        self.show_accepted();
        found.is_finite().then_some(found)
    }

    /// The forces at the accepted place with a past in which everything has slipped one way.
    pub(crate) fn seek(&mut self, way: SlipWay, within: Patience) -> Sought<Reading<T>> {
        let sought = self.seek_past(way, within);
        let found = match sought {
            Sought::Found(()) => Sought::Found(self.solution().reading()),
            Sought::Nowhere => Sought::Nowhere,
            Sought::Waits => return Sought::Waits,
        };
        self.show_accepted();
        found
    }

    /// Takes a past for the accepted one in which everything has slipped one way, if there is an equilibrium with it; otherwise everything is as it was.
    pub(crate) fn suppose(&mut self, way: SlipWay, within: Patience) -> Sought<()> {
        let mut sought = self.seek_past(way, within);
        if matches!(sought, Sought::Found(())) && self.solution().touching() == 0 {
            sought = Sought::Nowhere;
        }
        match sought {
            Sought::Found(()) => {
                let at = self.timeline.at();
                self.drift = T::ZERO;
                self.accept(at);
                self.timeline.stand(at);
            }
            Sought::Nowhere => self.show_accepted(),
            Sought::Waits => {}
        }
        sought
    }

    /// The search for a past with these iterations is going on.
    pub(crate) fn seeks(&self, way: SlipWay) -> bool {
        self.timeline.is_sought(Search::Past(way))
    }

    /// Looks for an equilibrium at the accepted place with another past, from where an earlier call has left off; the workspace shows it if one is
    /// found, and the accepted one if the search waits.
    fn seek_past(&mut self, way: SlipWay, within: Patience) -> Sought<()> {
        let aside = Aside { along: T::ZERO, moved: Moved::NONE, forced: Some(way) };
        let search = Search::Past(way);
        self.reject();
        let spent = self.timeline.take_up(search, &self.model);
        let attempt = self.look(&aside, within.now.min(within.most.saturating_sub(spent)), false, within.is_short);
        let Some(attempt) = attempt else { return Sought::Nowhere };
        let spent = spent + attempt.iterations;
        if attempt.status == Status::Converged && self.solution().reading().is_finite() {
            return Sought::Found(());
        }
        let waits = attempt.is_cut_off() && spent < within.most;
        if waits && self.timeline.put_aside(search, spent, &self.model) {
            self.show_accepted();
            return Sought::Waits;
        }
        Sought::Nowhere
    }

    /// Everything that touches slips this way.
    pub(crate) fn slips(&self, way: SlipWay) -> bool {
        let slip = match way {
            SlipWay::Closing => SlipState::Up,
            SlipWay::Opening => SlipState::Down,
        };
        let solution = self.solution();
        solution.touching() > 0 && solution.contacts().all(|contact| contact.slip == Some(slip))
    }

    /// What the workspace shows at a place, to be read.
    pub(super) fn solution_at(&self, aside: &Aside<T>) -> Solution<'_, T, S> {
        Solution { coordinate: self.timeline.at() + aside.along, ..self.solution() }
    }

    /// Newton's method at a place, from the accepted state or, not `anew`, from where the workspace is; it shows what it ends at.
    /// Where there `is_short` time, what an iteration costs is bounded.
    pub(super) fn look(&mut self, aside: &Aside<T>, iterations: u32, anew: bool, is_short: bool) -> Option<Attempt<T>> {
        if !self.has_equilibrium() || self.timeline.is_marked() {
            return None;
        }
        if anew {
            self.reject();
        }
        let to = self.timeline.at() + aside.along;
        let object = self.object;
        let moved = if self.spin.is_none() { aside.moved } else { self.spin.moved(aside.along) };
        self.object = object.displaced(&aside.moved.displacement());
        let seen = self.seen(to);
        self.object = object;
        self.aim_past(to, &moved);
        let own = self.work.history.slip.forced;
        self.work.history.slip.forced = aside.forced.map_or(own, SlipWay::state);
        let limits = Limits {
            iterations,
            budget: iterations,
            tolerance: NewtonSettings::<T>::of_precision().tolerance,
            hessian: self.settings.hessian,
            margin: T::of(self.settings.margin) / self.model.units.length,
            thins: self.model.fineness <= 1,
            is_short,
        };
        let (present, accepted) = self.timeline.present_and_accepted();
        let judged = Judged { state: accepted, drift: self.drift };
        let attempt = self.work.newton(&self.model, &mut self.factored, present, &seen, judged, &limits);
        (self.sweep, self.work.history.slip.forced) = (attempt.sweep, own);
        Some(attempt)
    }
}
