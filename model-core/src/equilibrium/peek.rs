//! Looking at a place beside the accepted equilibrium, which stays: what friction would answer to a small motion, and what the forces would be
//! with another past.

use super::{Follower, SlipWay};
use crate::contact::{ContactState, SlipState};
use crate::newton::attempt::{Judged, Limits};
use crate::newton::settings::NewtonSettings;
use crate::object::{Displacement, Object};
use crate::real::{Real, Vec2};
use crate::size::Size;
use crate::solution::Reading;
use crate::status::Status;

/// Where to look, from the accepted equilibrium.
#[derive(Clone, Copy)]
pub(crate) struct Aside<T> {
    /// Way along the motion, rad or mm.
    pub along: T,
    /// Shift of the object, world frame, mm.
    pub shift: [T; 2],
    /// Everything that touches slips one way, whatever its past.
    pub forced: Option<SlipWay>,
}

impl<T: Real, S: Size, O: Object<T>> Follower<T, S, O> {
    /// Looks at a place with at most so many Newton iterations. What they leave is not looked at where there is a single one: it is for the
    /// derivative of a short way. `None` if there is no equilibrium or the iterations do not converge; at most one evaluation more.
    pub(crate) fn peek(&mut self, aside: Aside<T>, iterations: u32) -> Option<Reading<T>> {
        let status = self.look(aside, iterations)?;
        let found = (status == Status::Converged || iterations == 1).then(|| {
            let mut reading = self.solution().reading();
            let at = self.timeline.at() + aside.along;
            let [x, y] = self.solution().force_finger();
            let world = self.motion.world_to_finger(at).vector_back(Vec2::new(x, y));
            reading.force = [world.x, world.y];
            reading
        });
        self.work.history.slip.forced = ContactState::Open;
        self.show_accepted();
        found.filter(|found| (found.force[0] + found.force[1] + found.torque + found.normal).is_finite())
    }

    /// Takes a past for the accepted one in which everything has slipped one way; false, and everything as it was, if no equilibrium is found
    /// with it within so many iterations.
    pub(crate) fn suppose(&mut self, way: SlipWay, iterations: u32) -> bool {
        let aside = Aside { along: T::ZERO, shift: [T::ZERO; 2], forced: Some(way) };
        let found = self.look(aside, iterations) == Some(Status::Converged) && self.solution().touching() > 0;
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

    /// Newton's method at a place, from the accepted state; the workspace shows what it ends at.
    fn look(&mut self, aside: Aside<T>, iterations: u32) -> Option<Status> {
        if !self.has_equilibrium() || self.timeline.is_marked() {
            return None;
        }
        self.reject();
        let at = self.timeline.at();
        let object = self.object;
        let [x, y] = aside.shift;
        let one = T::one();
        self.object =
            object.displaced(&Displacement { rotation: Vec2::new(one, T::ZERO), translation: Vec2::new(x, y) });
        let seen = self.seen(at + aside.along);
        self.object = object;
        self.aim(at + aside.along);
        self.work.history.slip.shift_object(
            self.motion.world_to_finger(at + aside.along).vector(Vec2::new(x, y)),
            self.model.units.length,
        );
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
        Some(self.work.newton(&self.model, &mut self.factored, present, &seen, judged, &limits).status)
    }
}
