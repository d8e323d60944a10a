//! The way to a place whose past is unknown: as if there were no friction, which takes steps four times as long and fewer iterations of each.
//!
//! At its end everything that touches sticks, without a tangential force: of all the states that friction allows there, the one in their middle.

use super::Follower;
use crate::newton::Workspace;
use crate::object::Object;
use crate::real::Real;
use crate::size::Size;

impl<T: Real, S: Size, O: Object<T>> Follower<T, S, O> {
    /// From the open hand where it is, leaves friction out until [`Self::arrive`].
    pub(crate) fn approach(&mut self) {
        self.work.history.slip.is_idle = self.rubs();
        self.allow_steps();
    }

    /// Friction is left out for now.
    pub(crate) fn approaches(&self) -> bool {
        self.work.history.slip.is_idle
    }

    /// Friction acts from here on.
    pub(crate) fn arrive(&mut self) {
        let at = self.timeline.at();
        self.timeline.stick();
        self.timeline.stand(at);
        self.reject();
        // Its past is the present pose.
        let object = self.seen(at);
        self.work.place(&self.model, &self.timeline.present, &object);
        let Workspace { kinematics, history, .. } = &mut self.work;
        history.slip.is_idle = false;
        history.begin(&self.model, &self.timeline.present, kinematics);
        self.show_accepted();
        self.allow_steps();
    }
}
