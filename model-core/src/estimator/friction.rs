//! The estimate with friction: the way that the contact has come, derivatives along it, and the interval where it is not known.

use super::path::{Interval, Path};
use super::{DIFFERENTIATE_EVERY, DIFFERENTIATE_WITHIN, Estimate, Estimator};
use crate::equilibrium::{Aside, Moved, SlipWay};
use crate::real::{Real, Vec2};
use crate::size::{Blank, Size};
use crate::solution::Reading;
use crate::uncertainty::Slopes;

/// What the estimate with friction keeps from tick to tick.
#[derive(Clone, Copy)]
pub(super) struct Rub {
    pub path: Path,
    /// The forces at the place of friction's history, and at the measured angle.
    reading: Reading<f32>,
    shown: Reading<f32>,
    /// Derivatives of them with the motor angle, per rad.
    per_angle: Reading<f32>,
    /// The forces if everything slipped as while closing, and as while opening, where that is known.
    closing: Option<Reading<f32>>,
    opening: Option<Reading<f32>>,
    /// What is looked at in the next tick that has time for it.
    turn: Turn,
    /// The place has moved since the derivatives were begun.
    moved: bool,
    /// Derivatives that are known: with the angle, and with the object's place.
    has_angle: bool,
    has_centre: bool,
}

/// Whose turn it is to be looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Turn {
    Angle,
    CentreX,
    CentreY,
    Rest,
}

/// A short way, in counts of the servo, over which a derivative with the angle is taken; in mm one with the object's place.
const SHORT_ANGLE: f64 = 1.5e-3;
const SHORT_SHIFT: f64 = 0.05;
/// Newton iterations in which the forces with another past are found, as a rule.
const PAST: u32 = 8;

/// No forces.
const NOTHING: Reading<f32> = Reading { force: [0.0; 2], normal: 0.0, torque: 0.0 };

impl Blank for Rub {
    const BLANK: Self = Self::EMPTY;
}

impl Rub {
    /// Nothing is known; all zeros.
    pub const EMPTY: Self = Self {
        path: Path::EMPTY,
        reading: NOTHING,
        shown: NOTHING,
        per_angle: NOTHING,
        closing: None,
        opening: None,
        turn: Turn::Angle,
        moved: false,
        has_angle: false,
        has_centre: false,
    };

    fn of(&self, way: SlipWay) -> Option<&Reading<f32>> {
        match way {
            SlipWay::Closing => self.closing.as_ref(),
            SlipWay::Opening => self.opening.as_ref(),
        }
    }

    /// The forces that may be, at the place of friction's history: as the follower has them, and as they are with another past. `None` while
    /// an end is not known.
    fn ends(&self) -> Option<[Reading<f32>; 2]> {
        let way = self.path.way();
        if !self.path.unknown {
            return Some([self.reading; 2]);
        }
        let other = if self.path.supposed { Some(&self.reading) } else { self.of(way.other()) };
        Some([*self.of(way)?, *other?])
    }
}

impl<T: Real, S: Size> Estimator<T, S> {
    /// Where a finger is to go that moves with its object, rad.
    pub(super) fn lead_path(&mut self, motor_angle: f64) -> f64 {
        self.follow_path(motor_angle);
        self.rub().path.front(self.slack().0)
    }

    /// Where friction's history is at a measured angle, rad.
    pub(super) fn follow_path(&mut self, motor_angle: f64) -> f64 {
        let (play, backlash) = self.slack();
        let mut rub = self.rub();
        // Where it turns round, the angle was ahead of the history by the play.
        let ahead = if rub.has_angle { rub.path.way().sign() * play } else { 0.0 };
        let now = rub.reading.plus(ahead as f32, &rub.per_angle);
        let at = rub.path.follow(motor_angle, play, backlash, &now);
        self.keep(rub);
        at
    }

    /// What friction keeps from tick to tick.
    pub(super) fn rub(&self) -> Rub {
        self.rub.as_ref().first().copied().unwrap_or(Rub::EMPTY)
    }

    pub(super) fn keep(&mut self, rub: Rub) {
        if let Some(slot) = self.rub.as_mut().first_mut() {
            *slot = rub;
        }
    }

    /// The play with which the history follows, and how far a motion may go before the finger follows it for certain, rad.
    fn slack(&self) -> (f64, f64) {
        let given = self.given();
        let play = f64::from(given.quantisation);
        (play, f64::from(given.backlash) + play)
    }

    /// Where a motion begins from an unknown past, goes on from the one that it takes longest to forget; the iterations spent.
    pub(super) fn suppose_path(&mut self, budget: u32) -> u32 {
        let mut rub = self.rub();
        let path = rub.path;
        if !path.unknown || path.supposed || !path.moves() || self.follower.solution().touching() == 0 {
            return 0;
        }
        let most = budget.saturating_sub(1).min(PAST);
        if self.follower.suppose(path.way().other(), most) {
            let with = self.taken(self.follower.solution().reading());
            rub.path.suppose(&with);
            self.keep(rub);
        }
        most
    }

    /// The estimate at the measured angle, which took so many iterations, its derivative, interval and standard deviation; `None` where there is no
    /// time to look at anything else. Where the object is `free` it is that of the motion's front: what the rest of the angle does to an object that
    /// gives way is not known, and forces that balance each other stay so.
    pub(super) fn read_rubbing(&mut self, estimate: &mut Estimate, iterations: Option<u32>, free: bool) {
        let mut rub = self.rub();
        if self.follower.solution().touching() == 0 {
            let mut path = rub.path;
            path.open();
            self.keep(Rub { path, ..Rub::EMPTY });
            (estimate.force_per_angle, estimate.standard_deviation, estimate.sensitivity_age) = ([0.0; 2], 0.0, 0);
            estimate.interval = None;
            return;
        }
        rub.reading = self.taken(self.follower.solution().reading());
        rub.moved |= rub.path.moves();
        let way = rub.path.way();
        if rub.path.unknown && rub.path.supposed && self.follower.slips(way) {
            // Whatever the past was, it has slipped this way by now.
            rub.path.know();
        }
        if iterations.is_some_and(|iterations| iterations <= DIFFERENTIATE_WITHIN) {
            let spent = self.look_aside(&mut rub, estimate);
            estimate.iterations = estimate.iterations.saturating_add(spent as u16);
        }
        let given = self.given();
        let ends = rub.ends();
        let rest = if rub.has_angle && !free { rub.path.rest() as f32 } else { 0.0 };
        let [one, other] = ends.unwrap_or([rub.reading; 2]).map(|end| end.plus(rest, &rub.per_angle));
        // Where it turned round the finger may be still, as it was.
        let (_, backlash) = self.slack();
        let turned = rub.path.turned(backlash).copied();
        // The middle of what may be: of a past that is known, what is.
        rub.shown = one.plus(0.5, &other.plus(-1.0, &one));
        (estimate.force, estimate.torque) = (rub.shown.force, rub.shown.torque);
        estimate.interval = ends.map(|_| Interval::over(&one, [other].into_iter().chain(turned)).with(estimate));
        estimate.force_per_angle = if rub.has_angle { rub.per_angle.force } else { [0.0; 2] };
        self.slopes.youngs_modulus = estimate.force_magnitude();
        let known = rub.has_angle && rub.has_centre;
        estimate.standard_deviation = match estimate.interval.filter(|_| known) {
            Some(interval) => libm::hypotf(given.standard_deviation(&self.slopes), interval.deviation()),
            None => f32::INFINITY,
        };
        self.keep(rub);
    }

    /// Looks at what is oldest beside the present place: one thing a tick. The iterations spent.
    fn look_aside(&mut self, rub: &mut Rub, estimate: &mut Estimate) -> u32 {
        if rub.path.unknown {
            let way = rub.path.way();
            let beside = if rub.path.supposed { None } else { Some(way.other()) };
            let missing = [Some(way), beside].into_iter().flatten().find(|&past| rub.of(past).is_none());
            // As the place moves on, so do the ends.
            let moved = rub.path.moves().then_some(beside.unwrap_or(way));
            if let Some(past) = missing.or(moved) {
                let aside = Aside { along: T::ZERO, moved: Moved::NONE, forced: Some(past) };
                let found = self.follower.peek(aside, PAST).map(|found| self.taken(found));
                match past {
                    SlipWay::Closing => rub.closing = found,
                    SlipWay::Opening => rub.opening = found,
                }
                return PAST;
            }
        }
        if rub.turn == Turn::Rest {
            // At rest at once: what stuck may slip by now.
            if !rub.moved || rub.path.moves() && estimate.sensitivity_age < DIFFERENTIATE_EVERY {
                return 0;
            }
            (rub.turn, rub.moved) = (Turn::Angle, false);
        }
        let angle = SHORT_ANGLE * rub.path.way().sign();
        let unit = |on: Turn| if rub.turn == on { T::of(SHORT_SHIFT) } else { T::ZERO };
        let shift = [unit(Turn::CentreX), unit(Turn::CentreY)];
        let along = if rub.turn == Turn::Angle { T::of(angle * self.ratio) } else { T::ZERO };
        let moved = Moved { shift, ..Moved::NONE };
        let found = self.follower.peek(Aside { along, moved, forced: None }, 1);
        let Some(found) = found.map(|found| self.taken(found)) else { return 1 };
        let change = found.plus(-1.0, &rub.reading);
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
                (rub.has_angle, rub.turn) = (true, Turn::CentreX);
            }
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

    /// A reading of the follower with the motor's torque.
    fn taken(&self, reading: Reading<T>) -> Reading<f32> {
        let of = |value: T| value.to_f64() as f32;
        let torque = self.ratio as f32 * of(reading.torque);
        Reading { force: reading.force.map(of), normal: of(reading.normal), torque }
    }

    /// The forces of the estimate.
    #[cfg(test)]
    pub(super) fn rub_reading(&self) -> Reading<f32> {
        self.rub().shown
    }

    /// The follower is at a coordinate, with a trustworthy estimate: there is nothing to follow.
    pub(super) fn rests(&self, coordinate: f64) -> bool {
        let is_known = self.last.age == 0 && self.last.status.is_trustworthy() && self.follower.has_equilibrium();
        is_known
            && self.follower.solution().touching() > 0
            && T::of(coordinate).to_f64() == self.follower.solution().coordinate()
    }
}
