//! Where the following of a motion can begin, and how far its steps may go.

use super::phase::Phase;
use super::{Follower, START_CHECKS};
use crate::access::Access;
use crate::newton::gaps::Sweep;
use crate::object::{Motion, Object};
use crate::real::Real;
use crate::size::Size;
use crate::units::Seen;

/// Part of the largest step that is allowed where the force depends on the path.
const ON_A_PATH: f64 = 0.25;

impl<T: Real, S: Size, O: Object<T>> Follower<T, S, O> {
    /// Puts the undeformed finger where the following of a motion to `first` can begin: at the largest coordinate not
    /// above `first` at which the object lies clear in front of the finger, searched back over a half turn (or 500 units of
    /// length) at most [`START_CHECKS`] places, a quarter of the largest step apart where that many reach.
    ///
    /// Returns false, and leaves the follower lost, if there is none.
    pub fn start(&mut self, first: f64) -> bool {
        self.phase = Phase::Lost;
        if self.model.cells() == 0 || !first.is_finite() {
            return false;
        }
        let (step, reach) = match self.motion {
            Motion::Rotating { .. } => (self.settings.max_angle_step, core::f64::consts::PI),
            Motion::Translating { .. } => {
                let unit = self.model.units.length.to_f64();
                (self.settings.max_distance_step * unit, 500.0 * unit)
            }
        };
        let spacing = (0.25 * step).max(reach / f64::from(START_CHECKS - 1));
        let mut places = (0..START_CHECKS).map(|check| f64::from(check) * spacing).take_while(|back| *back <= reach);
        places.any(|back| self.begin(first - back))
    }

    /// Puts the undeformed finger at a coordinate if the object lies clear in front of it there; otherwise the follower is
    /// lost. One evaluation of the gaps.
    pub fn begin(&mut self, coordinate: f64) -> bool {
        self.rest();
        self.phase = Phase::Lost;
        let clear = self.model.cells() > 0 && self.is_clear(T::of(coordinate));
        if clear {
            self.timeline.stand(T::of(coordinate));
            self.phase = Phase::Following;
        }
        clear
    }

    /// The finger at rest neither touches the object nor has passed it: the object lies on the front beam's outer side. The workspace shows
    /// the finger at rest.
    #[inline(never)]
    pub(super) fn is_clear(&mut self, coordinate: T) -> bool {
        let object = self.put_to_rest(coordinate);
        let (_, sweep) = self.work.evaluate(&self.model, &self.timeline.present, &object, T::ZERO);
        self.shows_clear(&sweep)
    }

    /// The same on the way elsewhere: where the finger at rest is not clear, that costs the front beam only, and the workspace shows nothing
    /// that may be read.
    #[inline(never)]
    pub(super) fn is_clear_on_the_way(&mut self, coordinate: T) -> bool {
        let sweep = self.sweep_at_rest(coordinate);
        self.shows_clear(&sweep) && self.is_clear(coordinate)
    }

    /// The gaps of the finger at rest at a coordinate; the workspace shows nothing that may be read.
    #[inline(never)]
    pub(super) fn sweep_at_rest(&mut self, coordinate: T) -> Sweep<T> {
        let object = self.put_to_rest(coordinate);
        self.work.place(&self.model, &self.timeline.present, &object)
    }

    #[inline(never)]
    fn put_to_rest(&mut self, coordinate: T) -> Seen<T, O> {
        self.timeline.present.rest();
        self.work.history.memory.mute();
        self.seen(coordinate)
    }

    fn shows_clear(&self, sweep: &Sweep<T>) -> bool {
        sweep.nearest >= T::ZERO && !self.rests_behind(sweep)
    }

    /// Looks for contacts as densely as the object asks, as soft as friction asks.
    #[inline(never)]
    pub(super) fn refine(&mut self) {
        self.model.refine(Seen::new(self.object, &self.model.units).sharpest());
        self.model.rubs = self.work.history.slip.is_given();
    }

    /// Counts fewer contacts, for who has found no room for all ([`Status::ContactCapacity`](crate::status::Status)), until another object is set or
    /// another coefficient of friction; the following of a motion must begin anew. False if there are as few as may be.
    #[inline(never)]
    pub(crate) fn spare_contacts(&mut self) -> bool {
        self.model.spare()
    }

    /// Largest step of the coordinate.
    pub(crate) fn max_step(&self) -> T {
        self.largest_step
    }

    /// Allows the largest steps: what the settings say, and on a sharp object less, so that none passes through it unseen.
    pub(super) fn allow_steps(&mut self) {
        self.largest_step = self.step_on_object();
        self.step = self.largest_step;
    }

    #[inline(never)]
    pub(super) fn step_on_object(&self) -> T {
        let (allowed, unit) = match self.motion {
            Motion::Rotating { .. } => (T::of(self.settings.max_angle_step), T::one()),
            Motion::Translating { .. } => {
                let unit = self.model.units.length;
                (T::of(self.settings.max_distance_step) * unit, unit)
            }
        };
        // Where slip turns round, the force depends on how far the motion goes in one step; and stresses that do not grow evenly in a step are
        // remembered otherwise than they were: at 1 °/s steps of 0.5° would be off by 0.03 % of the force.
        let allowed = if self.work.history.is_kept() { allowed * T::of(ON_A_PATH) } else { allowed };
        if self.model.fineness <= 1 {
            return allowed;
        }
        let arm = match self.motion {
            Motion::Rotating { axis } => {
                let [x, y] = axis.map(|place| T::of(place) / self.model.units.length);
                let [u, v] = self.model.base;
                let length = self.model.samples.as_ref().at(self.model.sample_count.saturating_sub(1)).arc;
                ((x - u) * (x - u) + (y - v) * (y - v)).sqrt() + length
            }
            Motion::Translating { .. } => T::one(),
        };
        allowed.min(T::of(0.5) * self.model.sharpest / arm * unit)
    }

    /// The object as the solver sees it at a coordinate: in the finger's frame and units.
    // Every shape's displacement: one copy of it in the flash.
    #[inline(never)]
    pub(crate) fn seen(&self, coordinate: T) -> Seen<T, O> {
        Seen::new(self.object.displaced(&self.motion.world_to_finger(coordinate)), &self.model.units)
    }
}
