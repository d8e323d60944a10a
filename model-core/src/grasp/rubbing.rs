//! A free object between fingers with friction: fingers and object move together, step by step.
//!
//! With friction the forces depend on the way, so that nothing may be tried by going there. A step goes a part p of what is left of the
//! fingers' ways, and leaves 1 − p of the force that was left over: an object that is let go with a force left over is let go
//! gradually. Where the object is then, C, follows from
//!
//! > Σ F_i(α_i + p Δα_i, C) + W = (1 − p) R⁰,
//!
//! each F_i from the finger's accepted state, by a quasi-Newton method that begins where the object's last steps lead. Where what sticks
//! begins to slip, the slope changes by orders of magnitude: a search that this surprises begins anew where a short part of the step leads, the
//! slope is taken anew, and a correction that leads beyond is followed by one along the chord and, where that hardly helps, by one half-way there.
//!
//! Where no step is found, the balance has ended, and the object falls, as slowly as it takes: with the fingers' coordinates as they are,
//! implicit steps of the motion against a drag, c (C − C⁰) = Σ F_i + W, lead to the next balance, which is flagged as a snap. So is a step
//! to another balance at once.
//!
//! Friction turns the object, a cylinder as well: there are always three freedoms. Forces that are less than 1e-4 of all, 1e-3 in single
//! precision, count as balanced; in a grip that slides everywhere they do not even turn the object any more.

use super::pace::Pace;
use super::slope::{Slope, dot, learn, minus, plus, returns, solve, within};
use super::together::{Answers, Step, short};
use super::{Balance, Grasp, HALVINGS, LONGEST, MAX_FINGERS, STEPS, Sum, largest, magnitude, magnitude3};
use crate::real::Real;
use crate::size::Size;
use crate::status::Status;

/// Forces left over that count as balanced, as a part of all and of 1 N: in double precision, and in units of the precision's
/// [`Real::EPSILON`].
const BALANCED: f64 = 1e-4;
const BALANCED_EPSILONS: f64 = 8e3;
/// What a step may miss its aim by, in parts of that.
const LEAVES: f64 = 0.8;
/// Corrections of the object's place in a step.
const CORRECTIONS: u32 = 16;
/// What a correction leaves as a rule of what there was; with more the slope is not what it was.
const GOOD: f64 = 0.65;
/// ... at most where it went too far, and at most at all.
const LESS: f64 = 0.9;
const WORSE: f64 = 10.0;
/// By how much it changes the forces at least, in parts of what is left; with less the fingers have not answered it.
const STILL: f64 = 0.1;
/// What a search that begins where the last steps lead may be off by for a slope of its own, in what a step may miss its aim by.
const NEAR: f64 = 30.0;
/// Part of a step that a prediction looks at.
const AHEAD: f64 = 1.0 / 32.0;
/// Calls that leave a step unfinished before it is halved.
const TRIES: u32 = 4;
/// Halvings of steps after which the balance is taken to have ended.
const HALVED: u32 = 4;
/// The drag against which the object falls at first and at least, N/mm, and what a step takes of it.
const DRAG: f64 = 10.0;
const LEAST_DRAG: f64 = 1e-3;
const EASES: f64 = 0.3;
/// Part of the energy that a step may lose: the work of one within a balance is stored and dissipated, but for the length of the step. More is
/// lost on the way to another balance.
const LOSES: f64 = 1e-3;

/// What is left of the fingers' ways, rad or mm.
type Ways = [f64; MAX_FINGERS];

/// What a balance with friction leaves for the next one, if all goes on as it went.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Course {
    /// How the forces answer the object's motion.
    slope: Option<Slope>,
    pace: Option<Pace>,
    going: Going,
    /// A step that was left unfinished: where the fingers go in it, rad or mm, and how many calls have not finished it.
    pending: Option<(Ways, u32)>,
    /// How far the search for the object's step in it has come.
    search: Option<Search>,
}

/// A search for the object's step.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Search {
    /// What is tried next, after which correction, and how the forces are expected to answer.
    object: [f64; 3],
    last: Option<Correction>,
    slope: Option<Slope>,
    /// It began as the last steps went: if the forces do not answer as they did, it is given up, unless it is nearly there.
    is_expected: bool,
    /// Places that it has tried.
    tried: u32,
    /// A place that was too far.
    beyond: Option<[f64; 3]>,
}

impl Search {
    /// One that has not begun.
    const ANEW: Self = Self::from([0.0; 3], None);

    /// One that begins with a guess.
    const fn from(object: [f64; 3], slope: Option<Slope>) -> Self {
        Self { object, last: None, slope, is_expected: false, tried: 0, beyond: None }
    }

    /// Judges the correction that has come to the place by what that leaves over, N: where the next one begins, and what the search has learnt.
    fn judge(&mut self, off: &[f64; 3], short: f64) -> Result<Next, Status> {
        let here = Next { from: self.object, off: *off, halves: false, holds: true, midway: None };
        let (Some(last), Some(slope)) = (self.last, &mut self.slope) else {
            return Ok(Next { holds: self.last.is_none() && self.slope.is_some(), ..here });
        };
        let (was, is) = (magnitude3(&last.off), magnitude3(off));
        let goes_on = dot(off, &last.off) > 0.0;
        if goes_on && is > WORSE * was {
            return Err(Status::Stagnated);
        }
        let mut next = here;
        if !goes_on && is > LESS * was {
            // Too far, beyond where it sticks or slips: from the same place along the chord, then half as far.
            next = Next { from: last.from, off: last.off, halves: last.stayed, ..next };
            self.beyond = Some(self.object);
        }
        next.holds = !goes_on || is <= GOOD * was;
        if next.holds {
            learn(slope, &last.more, &minus(&last.off, off));
        } else {
            let there = self.beyond.map(|far| minus(&far, &self.object).map(|part| 0.5 * part));
            next.midway = there.filter(|more| magnitude3(more) > short);
        }
        Ok(next)
    }

    /// Goes on to the next place.
    fn correct(&mut self, next: &Next, slope: &Slope) {
        let more = match (next.midway, self.last) {
            (Some(more), _) => more,
            (None, Some(last)) if next.halves => last.more.map(|part| 0.5 * part),
            _ => within(solve(slope, &next.off), LONGEST),
        };
        let stayed = next.from != self.object || next.midway.is_some();
        self.last = Some(Correction { from: next.from, off: next.off, more, stayed });
        self.object = plus(&next.from, &more);
    }
}

/// Where the next correction begins.
struct Next {
    /// The place, and by how much it misses the aim.
    from: [f64; 3],
    off: [f64; 3],
    /// It is half of the last one, which began there as well.
    halves: bool,
    /// The last one left as little as the slope said.
    holds: bool,
    /// It goes half-way to a place that was too far.
    midway: Option<[f64; 3]>,
}

/// How the steps go.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Going {
    /// Part of the ways that is gone in the next step.
    part: f64,
    /// Steps that failed since one that went all right.
    failed: u32,
    /// The drag, if the object falls; whether it has made a step since it began to.
    drag: Option<f64>,
    has_fallen: bool,
    /// It fell.
    fell: bool,
    /// The fingers have gone alone.
    alone: bool,
}

impl Default for Going {
    fn default() -> Self {
        Self { part: 1.0, failed: 0, drag: None, has_fallen: true, fell: false, alone: false }
    }
}

impl Going {
    /// A step went all right.
    fn goes_on(&mut self) {
        match &mut self.drag {
            // What is left is a whole again.
            None => self.part = (2.0 * self.part / (1.0 - self.part)).min(1.0),
            Some(drag) => {
                *drag = (*drag * EASES).max(LEAST_DRAG);
                (self.failed, self.has_fallen, self.fell) = (0, true, true);
            }
        }
    }

    /// A step failed; false if there is nothing left to try.
    fn tries_again(&mut self) -> bool {
        self.failed += 1;
        match &mut self.drag {
            None if self.failed > HALVED => (self.drag, self.failed, self.has_fallen) = (Some(DRAG), 0, false),
            None => self.part *= 0.5,
            Some(_) if self.failed > HALVINGS => return false,
            Some(drag) => *drag /= EASES,
        }
        true
    }
}

impl Sum {
    /// Energy that a step from here to there has lost, N·mm: the work of the motors and of what held the object, less what is stored and
    /// dissipated.
    #[inline(never)]
    fn lost(&self, there: &Self, ways: &[f64], step: &Step) -> f64 {
        let torques = self.torques.iter().zip(&there.torques).map(|(here, there)| 0.5 * step.part * (here + there));
        let motors: f64 = torques.zip(ways).map(|(torque, way)| torque * way).sum();
        motors - 0.5 * dot(&plus(&self.left, &there.left), &step.object) - (there.energy - self.energy)
    }
}

/// What a step is meant to do.
struct Aim {
    /// Part of the fingers' ways.
    part: f64,
    /// What it is meant to leave over, N, and how exactly.
    meant: [f64; 3],
    leaves: f64,
    /// The drag that the object falls against, N/mm; 0 where it is in balance all the way.
    drag: f64,
}

impl Aim {
    /// By what a step of the object misses it, N.
    #[inline(never)]
    fn missed_by(&self, left: &[f64; 3], object: &[f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|i| left[i] - self.meant[i] - self.drag * object[i])
    }
}

/// A correction of the object's step.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Correction {
    /// Where it began, and by how much that missed the aim.
    from: [f64; 3],
    off: [f64; 3],
    more: [f64; 3],
    /// If it is too long, half of it is next: the one before began there as well and was too long, or it goes half-way to a place
    /// that was too far.
    stayed: bool,
}

impl Correction {
    /// Whether it was so short that the forces have hardly changed by it.
    fn is_unanswered(&self, off: &[f64; 3], short: f64) -> bool {
        magnitude3(&self.more) < short && magnitude3(&minus(off, &self.off)) < STILL * magnitude3(off)
    }
}

impl<T: Real, S: Size> Grasp<'_, T, S> {
    /// Moves the fingers to coordinates while the object, let go, moves with them.
    pub(super) fn advance_rubbing(&mut self, to: &[f64]) -> Balance {
        let tolerance = BALANCED.max(BALANCED_EPSILONS * T::EPSILON.to_f64());
        let mut going = self.course.going;
        (going.fell, going.alone) = (going.drag.is_some(), false);
        let mut steps = 0;
        let mut here = self.sum();
        let status = loop {
            if self.left() < self.fingers.len() as u32 {
                break Status::MaxIterations;
            }
            // A step that was left unfinished comes first: with other coordinates it would be another problem.
            let pending = self.course.pending.take();
            let ways = match &pending {
                Some((to, _)) => self.ways(to),
                None => self.ways(to),
            };
            let forces: f64 = self.fingers.iter().map(|finger| magnitude(self.force(finger))).sum();
            let allowed = tolerance * (1.0 + forces);
            let balanced = largest(&here.left) <= allowed;
            if balanced && going.has_fallen && going.drag.take().is_some() {
                going.failed = 0;
            }
            if balanced && ways.iter().all(|way| *way == 0.0) && pending.is_none() {
                let held = here.touching > 0 && forces > 4.0 * tolerance;
                let fell = core::mem::take(&mut going).fell;
                break match if held { self.standing_rubbing(&ways) } else { Status::NoContact } {
                    Status::Converged if fell => Status::Snapped,
                    status => status,
                };
            }
            if steps >= STEPS {
                break Status::MaxIterations;
            }
            going.part = going.part.min(self.farthest(&ways));
            let (part, leaves) = (going.part, LEAVES * allowed);
            let aim = match going.drag {
                None => Aim { part, meant: here.left.map(|left| (1.0 - part) * left), leaves, drag: 0.0 },
                // From a balance that ends, the fingers have to go on a little for the object to fall.
                Some(drag) => Aim { part: if balanced { part } else { 0.0 }, meant: [0.0; 3], leaves, drag },
            };
            let come = self.course.search.filter(|_| pending.is_some()).map(|search| search.tried);
            match self.step_together(&ways, &aim, &here) {
                Ok((there, jumps)) => {
                    (here, steps) = (there, steps + 1);
                    going.goes_on();
                    going.fell |= jumps;
                }
                Err(_) if self.left() == 0 => {
                    let (mut target, tries) = pending.unwrap_or_default();
                    if tries == 0 {
                        target.iter_mut().zip(to).for_each(|(target, to)| *target = *to);
                    }
                    // Where a call has come no further, another would come no further either.
                    let comes_on = self.course.search.map(|search| search.tried) != come;
                    if comes_on && tries < TRIES {
                        self.course.pending = Some((target, tries + 1));
                    } else {
                        self.course.search = None;
                        going.tries_again();
                    }
                    break Status::MaxIterations;
                }
                Err(_) if going.tries_again() => {}
                Err(status) if going.alone => break status,
                Err(status) => {
                    // A finger that snaps does so alone, and the object falls to where it is in balance then.
                    if !self.go_alone(to) {
                        break status;
                    }
                    (here, steps) = (self.sum(), steps + 1);
                    going = Going { failed: 0, drag: Some(DRAG), fell: true, alone: true, ..going };
                }
            }
        };
        self.course.going = going;
        let known = status.is_trustworthy() || status == Status::Folded;
        let stiffness = self.course.slope.filter(|_| known).map(|slope| self.in_radians(&slope));
        self.report(status, &here, steps, stiffness)
    }

    /// One step of all, and whether the object jumps in it; or why there is none, and everything is as it was.
    fn step_together(&mut self, ways: &Ways, aim: &Aim, here: &Sum) -> Result<(Sum, bool), Status> {
        let search = self.course.search.take().or_else(|| self.expected(ways, aim, here)).unwrap_or(Search::ANEW);
        let mut found = self.search_together(ways, aim, here, search);
        if found.is_err() && self.left() > 0 && search.is_expected {
            found = self.search_together(ways, aim, here, Search::ANEW);
        }
        if found.is_ok() || self.left() > 0 {
            self.course.search = None;
        }
        if found.is_err() {
            self.show_accepted();
        }
        found
    }

    /// A search that begins where the last steps lead; without one, or where the object falls, there is none.
    #[inline(never)]
    fn expected(&self, ways: &Ways, aim: &Aim, here: &Sum) -> Option<Search> {
        if aim.drag > 0.0 {
            return None;
        }
        let (course, part) = (&self.course, aim.part);
        let object = if ways.iter().all(|way| *way == 0.0) {
            within(solve(&course.slope?, &here.left.map(|left| part * left)), LONGEST)
        } else {
            course.pace?.expects(&ways.map(|way| part * way))?
        };
        Some(Search { is_expected: true, ..Search::from(object, course.slope) })
    }

    /// A search that begins where a short part of the step leads, as if nothing that sticks there came to slip.
    ///
    /// In a whole step of the fingers, with the object where it was, everything slips, and the forces hardly answer the object any more.
    #[inline(never)]
    fn predicted(&mut self, ways: &Ways, aim: &Aim, here: &Sum) -> Result<Search, Status> {
        let step = Step::still(AHEAD * aim.part);
        let answers = self.answers(ways, &step, true)?.all_good()?;
        let ahead = [0, 1, 2].map(|i| (answers.left[i] - (1.0 - step.part) * here.left[i]) / AHEAD);
        let slope = self.slope(ways, &step, &answers.left, &ahead, false)?;
        let more = within(solve(&slope, &ahead), LONGEST);
        let last = Correction { from: [0.0; 3], off: ahead, more, stayed: false };
        Ok(Search { last: Some(last), tried: 1, ..Search::from(more, Some(slope)) })
    }

    /// Looks for the object's step, from where a search has come, and takes it. If the time runs out, the next call goes on from there.
    #[inline(never)]
    fn search_together(&mut self, ways: &Ways, aim: &Aim, here: &Sum, search: Search) -> Result<(Sum, bool), Status> {
        self.course.search = Some(search);
        let is_new = search.tried == 0 && !search.is_expected && aim.drag == 0.0;
        let mut search = if is_new { self.predicted(ways, aim, here)? } else { search };
        let mut step = Step { part: aim.part, object: search.object };
        let mut nearest: Option<(f64, [f64; 3])> = None;
        let mut anew = true;
        for correction in 0..CORRECTIONS {
            // Ways shorter than that of a slope lead nowhere: then from the best place, with a slope of its own.
            let leads_nowhere = search.last.is_some_and(|last| last.stayed && magnitude3(&last.more) < short::<T>());
            if let Some((_, object)) = nearest.filter(|_| leads_nowhere) {
                (search, anew) = (Search { object, last: None, slope: None, beyond: None, ..search }, true);
            }
            step.object = search.object;
            self.course.search = Some(Search { tried: search.tried + correction, ..search });
            let is_short = magnitude3(&step.object) <= LONGEST;
            if !is_short {
                return Err(Status::Stagnated);
            }
            let answers = self.answers(ways, &step, anew)?.all_good()?;
            let off = aim.missed_by(&answers.left, &step.object);
            if largest(&off) <= aim.leaves {
                return Ok(self.take_together(ways, aim, &step, here, &answers, search.slope));
            }
            let miss = magnitude3(&off);
            if nearest.is_none_or(|(least, _)| miss < least) {
                nearest = Some((miss, step.object));
            }
            if self.left() == 0 {
                return Err(Status::MaxIterations);
            }
            // So short a way may be less than what a finger leaves over: then from its accepted state.
            if !anew && search.last.is_some_and(|last| last.is_unanswered(&off, short::<T>())) {
                anew = true;
                continue;
            }
            let next = search.judge(&off, short::<T>())?;
            let slope = match search.slope.filter(|_| next.holds || next.midway.is_some()) {
                Some(slope) => slope,
                None if search.is_expected && miss > NEAR * aim.leaves => return Err(Status::Stagnated),
                // What stuck slips by now, or the other way round.
                None => {
                    let mut slope = self.slope(ways, &step, &answers.left, &off, false)?;
                    for (i, row) in slope.iter_mut().enumerate() {
                        row[i] += aim.drag;
                    }
                    slope
                }
            };
            search.slope = Some(slope);
            if aim.drag == 0.0 {
                self.course.slope = search.slope;
            }
            search.correct(&next, &slope);
            anew = false;
        }
        Err(Status::Stagnated)
    }

    /// Accepts a step, and keeps in mind how it went. Returns whether the object jumps in it.
    #[inline(never)]
    fn take_together(
        &mut self,
        ways: &Ways,
        aim: &Aim,
        step: &Step,
        here: &Sum,
        answers: &Answers<T>,
        slope: Option<Slope>,
    ) -> (Sum, bool) {
        if aim.drag == 0.0 {
            self.course.slope = slope.or(self.course.slope);
            self.course.pace.get_or_insert(Pace::UNKNOWN).learn(&ways.map(|way| step.part * way), &step.object);
        } else {
            (self.course.slope, self.course.pace) = (None, None);
        }
        let there = self.accept_together(ways, step, answers);
        let jumps = here.lost(&there, ways, step) > LOSES * here.energy.abs();
        (there, jumps)
    }

    /// Status of a place where nothing is left over: whether what moves the object is answered by a force back, in every direction.
    #[inline(never)]
    fn standing_rubbing(&mut self, ways: &Ways) -> Status {
        if !self.course.slope.is_some_and(|slope| returns(&slope)) {
            // That of the last step has been corrected on the way: the place's own decides.
            let here = self.sum().left;
            let found = self.slope(ways, &Step::still(0.0), &here, &here, true);
            self.show_accepted();
            self.course.slope = found.ok();
        }
        let snapped = self.fingers.iter().any(|finger| finger.follower.has_snapped());
        match &self.course.slope {
            None => Status::MaxIterations,
            Some(slope) if !returns(slope) => Status::Folded,
            Some(_) if snapped => Status::Snapped,
            Some(_) => Status::Converged,
        }
    }

    /// A slope with turns in rad.
    #[inline(never)]
    fn in_radians(&self, slope: &Slope) -> Slope {
        let unit = |i: usize| if i == 2 { self.size } else { 1.0 };
        core::array::from_fn(|i| core::array::from_fn(|j| slope[i][j] * unit(i) * unit(j)))
    }
}
