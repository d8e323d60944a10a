//! Looking at a place beside the accepted equilibrium, which stays: what friction would answer to a small motion, and what the forces would be
//! with another past.

use super::{Follower, Moved, SlipWay};
use crate::contact::{ContactState, SlipState};
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

impl<T: Real, S: Size, O: Object<T>> Follower<T, S, O> {
    /// Looks at a place with at most so many Newton iterations. What they leave is not looked at where there is a single one: it is for the
    /// derivative of a short way. `None` if there is no equilibrium or the iterations do not converge; at most one evaluation more.
    pub(crate) fn peek(&mut self, aside: Aside<T>, iterations: u32) -> Option<Reading<T>> {
        let status = self.look(&aside, iterations, true)?.status;
        let found = (status == Status::Converged || iterations == 1).then(|| self.solution_at(&aside).reading());
        self.work.history.slip.forced = ContactState::Open;
        self.show_accepted();
        found.filter(|found| (found.force[0] + found.force[1] + found.torque + found.normal).is_finite())
    }

    /// Takes a past for the accepted one in which everything has slipped one way; false, and everything as it was, if no equilibrium is found
    /// with it within so many iterations.
    pub(crate) fn suppose(&mut self, way: SlipWay, iterations: u32) -> bool {
        let aside = Aside { along: T::ZERO, moved: Moved::NONE, forced: Some(way) };
        let attempt = self.look(&aside, iterations, true);
        let converged = attempt.is_some_and(|attempt| attempt.status == Status::Converged);
        let found = converged && self.solution().touching() > 0;
        self.work.history.slip.forced = ContactState::Open;
        if found {
            let at = self.timeline.at();
            self.drift = T::ZERO;
            self.accept(at);
            self.timeline.stand(at);
        } else {
            self.show_accepted();
        }
        found
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
    pub(super) fn look(&mut self, aside: &Aside<T>, iterations: u32, anew: bool) -> Option<Attempt<T>> {
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
        self.work.history.slip.forced = aside.forced.map_or(ContactState::Open, SlipWay::state);
        let limits = Limits {
            iterations,
            budget: iterations,
            tolerance: NewtonSettings::<T>::of_precision().tolerance,
            hessian: self.settings.hessian,
            margin: T::of(self.settings.margin) / self.model.units.length,
            thins: self.model.fineness <= 1,
        };
        let (present, accepted) = self.timeline.present_and_accepted();
        let judged = Judged { state: accepted, drift: self.drift };
        let attempt = self.work.newton(&self.model, &mut self.factored, present, &seen, judged, &limits);
        self.sweep = attempt.sweep;
        Some(attempt)
    }
}
