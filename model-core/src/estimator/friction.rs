//! The estimate with friction: the way that the contact has come, and the interval where it is not known.

use core::ops::ControlFlow;

use super::interval::Interval;
use super::path::Path;
use super::{CONVERGES_WITHIN, Estimate, Estimator, SHORT_WAY};
use crate::equilibrium::{Patience, SlipWay, Sought};
use crate::real::Real;
use crate::size::{Blank, Size};
use crate::solution::Reading;

/// What the estimate with friction keeps from tick to tick.
#[derive(Clone, Copy)]
pub(super) struct Rub {
    pub path: Path,
    /// The place of friction's history that was followed to, rad.
    pub place: f64,
    /// Ticks since one was for what lies beside it.
    pub waited: u16,
    /// The forces at the place of friction's history, and at the measured angle.
    pub reading: Reading<f32>,
    shown: Reading<f32>,
    /// Derivatives of them with the motor angle, per rad.
    pub per_angle: Reading<f32>,
    /// The same where the motion turns round, so that what slips sticks.
    pub per_angle_back: Reading<f32>,
    /// The forces if everything slipped as while closing, and as while opening, where that is known.
    closing: Option<End>,
    opening: Option<End>,
    /// Those with which the forces at a shifted object are compared.
    pub slipping: Option<End>,
    /// What is looked at in the next tick that has time for it.
    pub turn: Turn,
    /// The place has moved since the derivatives were begun.
    pub moved: bool,
    /// The forces were those of an opening finger.
    opens: bool,
    /// The measured angle is farther from the place than the derivatives reach, or the other way than those that are known.
    is_far: bool,
    /// Derivatives that are known: with the angle, with the angle back, and with the object's place.
    pub has_angle: bool,
    pub has_back: bool,
    pub has_centre: bool,
}

/// An end of what the forces may be, and the place where it was found, rad.
#[derive(Clone, Copy)]
pub(super) struct End {
    pub at: f64,
    pub reading: Reading<f32>,
}

/// Whose turn it is to be looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Turn {
    Angle,
    Back,
    Slip,
    CentreX,
    CentreY,
    Rest,
}

/// Newton iterations in which the forces with another past are found, as a rule.
pub(super) const PAST: u32 = 8;
/// Shortest way from tick to tick that shows how the forces change, rad.
const SHORTEST_WAY: f64 = 0.25 * core::f64::consts::TAU / 4096.0;
/// By how many plays two angles in a row, and one alone, are behind the motion's front where it has gone back from there: less is noise.
const GOES_BACK: [f32; 2] = [1.5, 2.5];
/// Over how many plays forces are moved along at most.
const FARTHEST: f32 = 5.0;
/// For how many plays after a turn the forces may change otherwise than on the way.
const SOON: f32 = 3.0;
/// No forces.
pub(super) const NOTHING: Reading<f32> = Reading { force: [0.0; 2], normal: 0.0, torque: 0.0 };

impl Blank for Rub {
    const BLANK: Self = Self::EMPTY;
}

impl Rub {
    /// Nothing is known; all zeros.
    pub const EMPTY: Self = Self {
        path: Path::EMPTY,
        place: 0.0,
        waited: 0,
        reading: NOTHING,
        shown: NOTHING,
        per_angle: NOTHING,
        per_angle_back: NOTHING,
        closing: None,
        opening: None,
        slipping: None,
        turn: Turn::Angle,
        moved: false,
        opens: false,
        is_far: false,
        has_angle: false,
        has_back: false,
        has_centre: false,
    };

    /// The forces if everything had slipped one way, if that is known near the place.
    pub fn end(&self, way: SlipWay) -> Option<Reading<f32>> {
        let end = match way {
            SlipWay::Closing => self.closing.as_ref(),
            SlipWay::Opening => self.opening.as_ref(),
        };
        let way = |end: &End| self.place - end.at;
        let near = end.filter(|end| way(end) == 0.0 || self.has_angle && way(end).abs() <= SHORT_WAY);
        near.map(|end| end.reading.along(way(end) as f32, &self.per_angle))
    }

    /// The finger has come a known way, and has gone back on it by more than noise.
    fn goes_back(&self, play: f64) -> bool {
        !self.path.unknown && self.path.goes_back(play, GOES_BACK.map(|plays| reach(play, plays)))
    }

    /// Takes these forces of a past, or that there are none.
    pub fn put(&mut self, way: SlipWay, found: Option<Reading<f32>>) {
        let found = found.map(|reading| End { at: self.place, reading });
        match way {
            SlipWay::Closing => self.closing = found,
            SlipWay::Opening => self.opening = found,
        }
    }

    /// The forces that may be, at the place of friction's history: as the follower has them, and as they are with another past. `None` while
    /// an end is not known.
    fn ends(&self) -> Option<[Reading<f32>; 2]> {
        let way = self.path.way();
        if !self.path.unknown {
            return Some([self.reading; 2]);
        }
        let other = if self.path.supposed { Some(self.reading) } else { self.end(way.other()) };
        Some([self.end(way)?, other?])
    }
}

/// So many plays, rad; where there is none, counts of a servo.
fn reach(play: f64, plays: f32) -> f32 {
    plays * (play as f32).max(4.0 * SHORTEST_WAY as f32)
}

impl<T: Real, S: Size> Estimator<T, S> {
    /// Where a finger is to go that moves with its object, rad.
    pub(super) fn lead_path(&mut self, motor_angle: f64) -> f64 {
        self.follow_history(motor_angle);
        self.rub().path.front(self.slack().0)
    }

    /// Where a finger is to go at a measured angle, rad: where friction's history is.
    pub(super) fn follow_path(&mut self, motor_angle: f64) -> f64 {
        let mut rub = self.rub();
        if self.follower.has_equilibrium()
            && self.follower.solution().touching() == 0
            && let Some(at) = rub.path.follow_open(motor_angle)
        {
            self.keep(rub);
            return at;
        }
        self.follow_history(motor_angle)
    }

    fn follow_history(&mut self, motor_angle: f64) -> f64 {
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

    /// Where a motion begins from an unknown past, goes on from the one that it takes longest to forget, as soon as that is found. The iterations
    /// spent of so many; a break if none is left for the motion.
    pub(super) fn suppose_path(&mut self, budget: u32) -> ControlFlow<u32, u32> {
        let mut rub = self.rub();
        let path = rub.path;
        let past = path.way().other();
        let asks = path.unknown && !path.supposed && !path.gave_up && path.leads() && path.at() != rub.place;
        if !asks || self.follower.approaches() || self.follower.solution().touching() == 0 {
            return ControlFlow::Continue(0);
        }
        let is_short = budget < CONVERGES_WITHIN;
        let now = if is_short { budget } else { (budget - 1).min(PAST) };
        let sought = self.follower.suppose(past, Patience { now, most: PAST, is_short });
        match sought {
            Sought::Found(()) => {
                rub.reading = self.taken(self.follower.solution().reading());
                rub.path.suppose(&rub.reading, rub.place);
            }
            Sought::Nowhere => rub.path.gave_up = true,
            Sought::Waits => {}
        }
        self.keep(rub);
        let is_spent = is_short || matches!(sought, Sought::Waits);
        if is_spent { ControlFlow::Break(now) } else { ControlFlow::Continue(now) }
    }

    /// The estimate at the measured angle, its derivative, interval and standard deviation, with so many iterations for what lies beside it. Where
    /// the object is `free` it is that of the motion's front: what the rest of the angle does to an object that gives way is not known, and forces
    /// that balance each other stay so.
    pub(super) fn read_rubbing(&mut self, estimate: &mut Estimate, aside: u32, free: bool) {
        let mut rub = self.rub();
        if self.follower.solution().touching() == 0 {
            let mut path = rub.path;
            path.open();
            self.keep(Rub { path, ..Rub::EMPTY });
            (estimate.force_per_angle, estimate.standard_deviation, estimate.sensitivity_age) = ([0.0; 2], 0.0, 0);
            estimate.interval = None;
            return;
        }
        let reading = self.taken(self.follower.solution().reading());
        let came = rub.path.at() - rub.place;
        let way = rub.path.way();
        let opens = way == SlipWay::Opening;
        if core::mem::replace(&mut rub.opens, opens) != opens {
            // What slipped sticks.
            (rub.has_angle, rub.per_angle, rub.turn) = (rub.has_back, rub.per_angle_back, Turn::Angle);
        }
        if came.abs() > 2.0 * SHORT_WAY {
            // The forces may have changed otherwise on the way.
            (rub.has_angle, rub.has_back, rub.turn) = (false, false, Turn::Angle);
        } else if rub.has_angle && !free && came * way.sign() > SHORTEST_WAY {
            // On a way that goes on the forces themselves say how they change.
            rub.per_angle = NOTHING.plus((1.0 / came) as f32, &reading.plus(-1.0, &rub.reading));
        }
        rub.reading = reading;
        (rub.place, rub.waited) = (rub.path.at(), rub.waited.saturating_add(1));
        rub.moved |= rub.path.moves();
        if rub.path.unknown && rub.path.supposed && self.follower.slips(way) {
            // Whatever the past was, it has slipped this way by now.
            rub.path.know();
        }
        if aside > 0 {
            let spent = self.look_aside(&mut rub, estimate, aside);
            estimate.iterations = estimate.iterations.saturating_add(spent as u16);
        }
        self.show_rubbing(rub, estimate, free);
    }

    /// The follower has come to the place of a turn, rad, that it was behind: the forces there.
    pub(super) fn turn_at(&mut self, place: f64) {
        let (rub, reading) = (self.rub(), self.taken(self.follower.solution().reading()));
        let mut path = rub.path;
        path.turn_with(&reading);
        self.keep(Rub { path, place, reading, ..rub });
        self.jumped();
    }

    /// The finger has jumped: its forces change otherwise than they did.
    pub(super) fn jumped(&mut self) {
        let rub = self.rub();
        self.keep(Rub { has_angle: false, has_back: false, turn: Turn::Angle, ..rub });
    }

    /// The forces are those of the measured angle: of the finger's place, or moved along from there.
    pub(super) fn is_at_angle(&self) -> bool {
        let has_time = self.settings().budget >= CONVERGES_WITHIN;
        let reaches = |rub: &Rub| !rub.is_far && (has_time || rub.has_angle || rub.path.ahead_of(rub.place) == 0.0);
        self.rub.as_ref().first().is_none_or(reaches)
    }

    /// Shows what is known at the measured angle, unless that is too far ([`Self::is_at_angle`]).
    pub(super) fn show_rubbing(&mut self, mut rub: Rub, estimate: &mut Estimate, free: bool) {
        let given = self.given();
        let ends = rub.ends();
        let rest = if rub.has_angle && !free { rub.path.ahead_of(rub.place) as f32 } else { 0.0 };
        let [one, other] = ends.unwrap_or([rub.reading; 2]).map(|end| end.along(rest, &rub.per_angle));
        // Where it turned round the finger may be still, as it was.
        let (play, backlash) = self.slack();
        let reach = |plays: f32| reach(play, plays);
        let turned = rub.path.turned(backlash).copied();
        // A motion from an unknown past, or one that has just turned round, may have begun anywhere within the play.
        let lag = if (rub.path.supposed || turned.is_some()) && rub.has_angle { play as f32 } else { 0.0 };
        let [behind, ahead] = [-lag, lag].map(|lag| [one, other].map(|end| end.along(lag, &rub.per_angle)));
        // Within the play it may have turned round as well: the finger has stayed at the motion's front, or gone back from there.
        let short = if free { 0.0 } else { rub.path.short_of_front(play) as f32 };
        let stayed = if rub.has_angle { one.along(short, &rub.per_angle) } else { one };
        let back = if rub.has_back { stayed.along(-short, &rub.per_angle_back) } else { one };
        let others = [other, turned.unwrap_or(other), behind[0], behind[1], ahead[0], ahead[1]];
        // Farther behind than noise it has gone back.
        let goes_back = !free && rub.goes_back(play);
        let beyond = short.abs().max(rest.abs()) > reach(FARTHEST);
        rub.is_far = !free && (beyond || goes_back && !rub.has_back);
        if rub.is_far {
            self.keep(rub);
            return;
        }
        // The middle of what may be: of a past that is known, what is.
        rub.shown = if goes_back { back } else { one.plus(0.5, &other.plus(-1.0, &one)) };
        (estimate.force, estimate.torque) = (rub.shown.force, rub.shown.torque);
        estimate.interval = ends.map(|_| {
            let interval = Interval::over(&one, &others).with(estimate.force, estimate.torque);
            // Soon after a turn the forces change otherwise than they did on the way.
            let is_fresh = !free && rub.path.turned(backlash + f64::from(reach(SOON))).is_some();
            interval.up_to(&stayed).up_to(&back).up_to(if is_fresh { &rub.reading } else { &one })
        });
        let per_angle = if goes_back { &rub.per_angle_back } else { &rub.per_angle };
        estimate.force_per_angle = if rub.has_angle { per_angle.force } else { [0.0; 2] };
        self.slopes.youngs_modulus = estimate.force_magnitude();
        let known = rub.has_angle && rub.has_centre;
        estimate.standard_deviation = match estimate.interval.filter(|_| known) {
            Some(interval) => libm::hypotf(given.standard_deviation(&self.slopes), interval.deviation()),
            None => f32::INFINITY,
        };
        self.keep(rub);
    }

    /// A reading of the follower with the motor's torque.
    pub(super) fn taken(&self, reading: Reading<T>) -> Reading<f32> {
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
