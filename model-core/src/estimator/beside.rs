//! What lies beside the place of a finger with friction, looked at in ticks that have time for it: how its forces change with the angle and with the
//! object's place, and what they would be with another past.

use super::friction::{End, NOTHING, PAST, Rub, Turn};
use super::{CONVERGES_WITHIN, DIFFERENTIATE_EVERY, DIFFERENTIATE_WITHIN, Estimate, Estimator, SHORT_WAY, Visit};
use crate::equilibrium::{Aside, Moved, Patience, SlipWay, Sought};
use crate::real::{Real, Vec2};
use crate::size::Size;
use crate::solution::Reading;
use crate::status::Status;
use crate::uncertainty::Slopes;

/// A short way, in counts of the servo, over which a derivative with the angle is taken; in mm one with the object's place.
const SHORT_ANGLE: f64 = 1.5e-3;
const SHORT_SHIFT: f64 = 0.05;
/// If a tick has no time for both, one in so many and one more looks beside the finger's place instead of following it.
const LOOK_EVERY: u16 = 8;

impl<T: Real, S: Size> Estimator<T, S> {
    /// Iterations that an estimate has left for what lies beside it, which has taken so many; none if it had to go on. Where there is time for
    /// one thing only, none either unless the motor rests.
    pub(super) fn left_aside(&self, spent: Option<u32>) -> u32 {
        let budget = self.settings().budget;
        let has_time = budget >= CONVERGES_WITHIN || self.has_rested;
        let spent = spent.filter(|&spent| has_time && spent <= DIFFERENTIATE_WITHIN);
        spent.map_or(0, |spent| budget.saturating_sub(spent).min(PAST))
    }

    /// In a motion without time for more than a step, a tick now and then is for what lies beside the place that the finger is at.
    /// One that goes on takes only what it cannot do without.
    pub(super) fn looks_first(&self, coordinate: f64, visit: Visit) -> bool {
        let (rub, last) = (self.rub(), &self.last);
        let budget = self.settings().budget;
        let goes_on = last.status == Status::Updating && self.seeks_past(&rub);
        let is_trusted = last.age == 0 && last.status.is_trustworthy();
        let is_due = if rub.has_angle { is_trusted && rub.waited >= LOOK_EVERY } else { rub.waited > 0 };
        let at = self.follower.solution().coordinate();
        let way = (T::of(coordinate).to_f64() - at) / self.ratio;
        let is_there = self.drive.coordinate(rub.place).is_some_and(|[place, _]| T::of(place).to_f64() == at);
        budget < CONVERGES_WITHIN
            && (goes_on || is_due)
            && (visit == Visit::First || !rub.has_angle)
            && is_there
            && self.follower.has_equilibrium()
            && !self.follower.approaches()
            && self.follower.solution().touching() > 0
            && (way != 0.0 || !rub.has_angle)
            && way.abs() <= SHORT_WAY
    }

    /// A look beside the last place, and its forces moved along to the measured angle: the status. `None` if there was nothing to look at.
    pub(super) fn look_along(&mut self, estimate: &mut Estimate) -> Option<Status> {
        let mut rub = self.rub();
        rub.moved |= rub.path.moves();
        let spent = self.look_aside(&mut rub, estimate, self.settings().budget);
        (rub.waited, estimate.iterations) = (0, estimate.iterations.saturating_add(spent as u16));
        if spent > 0 && rub.has_angle {
            self.show_rubbing(rub, estimate, false);
            return Some(if self.is_at_angle() { Status::Updating } else { Status::MaxIterations });
        }
        self.keep(rub);
        (spent > 0).then_some(Status::MaxIterations)
    }

    /// A search for the forces with another past is going on.
    fn seeks_past(&self, rub: &Rub) -> bool {
        rub.path.unknown && [SlipWay::Closing, SlipWay::Opening].iter().any(|&way| self.follower.seeks(way))
    }

    /// Looks at what is oldest beside the present place, in so many iterations: one thing a tick. The iterations spent.
    pub(super) fn look_aside(&mut self, rub: &mut Rub, estimate: &mut Estimate, iterations: u32) -> u32 {
        let is_short = self.settings().budget < CONVERGES_WITHIN;
        // Without time for both, first what moves the forces along.
        if rub.path.unknown && (rub.has_angle || !is_short) {
            let way = rub.path.way();
            let beside = if rub.path.supposed { None } else { Some(way.other()) };
            let missing = [Some(way), beside].into_iter().flatten().find(|&past| rub.end(past).is_none());
            // As the place moves on, so do the ends.
            let moved = rub.path.moves().then_some(beside.unwrap_or(way));
            if let Some(past) = missing.or(moved) {
                match self.follower.seek(past, Patience { now: iterations, most: PAST, is_short }) {
                    Sought::Found(found) => rub.put(past, Some(self.taken(found))),
                    Sought::Nowhere => rub.put(past, None),
                    Sought::Waits => {}
                }
                return iterations;
            }
        }
        if rub.turn == Turn::Rest {
            // At rest at once: what stuck may slip by now.
            if !rub.moved || rub.path.moves() && estimate.sensitivity_age < DIFFERENTIATE_EVERY {
                return 0;
            }
            (rub.turn, rub.moved) = (Turn::Angle, false);
        }
        let way = self.nearest_slip();
        if rub.turn == Turn::Slip && self.follower.slips(way) {
            (rub.slipping, rub.turn) = (Some(End { at: rub.place, reading: rub.reading }), Turn::CentreX);
        }
        let base = rub.slipping.filter(|base| base.at == rub.place);
        if matches!(rub.turn, Turn::CentreX | Turn::CentreY) && base.is_none() {
            // The finger has moved on.
            rub.turn = Turn::Slip;
        }
        let angle = SHORT_ANGLE * rub.path.way().sign() * if rub.turn == Turn::Back { -1.0 } else { 1.0 };
        let unit = |on: Turn| if rub.turn == on { T::of(SHORT_SHIFT) } else { T::ZERO };
        let shift = [unit(Turn::CentreX), unit(Turn::CentreY)];
        let turns = matches!(rub.turn, Turn::Angle | Turn::Back);
        let along = if turns { T::of(angle * self.ratio) } else { T::ZERO };
        let moved = Moved { shift, ..Moved::NONE };
        // An object that is elsewhere has been there all along, so that it has not been shifted: what slips goes on slipping, and what sticks
        // is compared with the same shift of what slips, whose first iterations are from the same place.
        let forced = (!turns).then_some(way);
        let found = self.follower.peek(Aside { along, moved, forced }, is_short);
        let Some(found) = found.map(|found| self.taken(found)) else { return 1 };
        let from = if turns { rub.reading } else { base.map_or(rub.reading, |base| base.reading) };
        let change = found.plus(-1.0, &from);
        let size = rub.reading.force.map(f64::from);
        let length = libm::hypot(size[0], size[1]);
        let along = |change: &Reading<f32>, way: f64| {
            let [x, y] = change.force.map(f64::from);
            ((x * size[0] + y * size[1]) / (length * way)) as f32
        };
        match rub.turn {
            Turn::Angle => {
                rub.per_angle = NOTHING.plus((1.0 / angle) as f32, &change);
                self.slopes = Slopes { angle: along(&change, angle), ..self.slopes };
                (rub.has_angle, rub.turn) = (true, Turn::Back);
            }
            Turn::Back => {
                rub.per_angle_back = NOTHING.plus((1.0 / angle) as f32, &change);
                (rub.has_back, rub.turn) = (true, Turn::Slip);
            }
            Turn::Slip => (rub.slipping, rub.turn) = (Some(End { at: rub.place, reading: found }), Turn::CentreX),
            Turn::CentreX => {
                self.slopes.centre[0] = along(&change, SHORT_SHIFT);
                rub.turn = Turn::CentreY;
            }
            Turn::CentreY | Turn::Rest => {
                self.slopes.centre[1] = along(&change, SHORT_SHIFT);
                // An object that grows comes nearer along its normals: where the contact is short, as one that is shifted.
                let normal = self.mean_normal();
                self.slopes.radius = normal[0] * self.slopes.centre[0] + normal[1] * self.slopes.centre[1];
                (rub.has_centre, rub.turn, estimate.sensitivity_age) = (true, Turn::Rest, 0);
            }
        }
        1
    }

    /// The slip that pulls the finger the way that friction does.
    fn nearest_slip(&self) -> SlipWay {
        let along = self.follower.solution().contacts().fold(T::ZERO, |sum, contact| sum + contact.tangential);
        if along < T::ZERO { SlipWay::Opening } else { SlipWay::Closing }
    }

    /// Mean normal out of the object, by force, world frame.
    fn mean_normal(&self) -> [f32; 2] {
        let mut sum = [T::ZERO; 2];
        for contact in self.follower.solution().contacts() {
            sum = [0, 1].map(|i| sum[i] + contact.force * contact.normal[i]);
        }
        let size = (sum[0] * sum[0] + sum[1] * sum[1]).sqrt();
        let world = self.follower.displacement().vector_back(Vec2::new(sum[0], sum[1]));
        if size > T::ZERO { [world.x, world.y].map(|part| (part / size).to_f64() as f32) } else { [0.0; 2] }
    }
}
