//! What all fingers answer together to a step of fingers and object that is tried, and taking that step.
//!
//! Nothing is accepted while a step is tried: each finger is solved from its accepted state, with the friction's history up to there.

use heapless::Vec;

use super::slope::Slope;
use super::{Grasp, LEAST, MAX_FINGERS, Sum};
use crate::equilibrium::{Answer, Aside, FOLLOW_ITERATIONS, Moved};
use crate::object::Shape;
use crate::real::Real;
use crate::size::Size;
use crate::status::Status;

/// Newton iterations of a finger at a place.
const PATIENCE: u32 = 8;
/// Way over which the forces' derivatives are taken, mm, in the two precisions: less than a step's, so that what slips goes on slipping.
const SHORT: f64 = 1e-5;
const SHORT_SINGLE: f64 = 1e-3;

/// The way over which they are taken in a precision, mm.
pub(super) fn short<T: Real>() -> f64 {
    if T::EPSILON.to_f64() > 1e-10 { SHORT_SINGLE } else { SHORT }
}

/// Where a step leads: part of the fingers' ways, and step of the object (mm, mm, and the turn times the size).
#[derive(Clone, Copy)]
pub(super) struct Step {
    pub part: f64,
    pub object: [f64; 3],
}

impl Step {
    /// The object stays.
    pub fn still(part: f64) -> Self {
        Self { part, object: [0.0; 3] }
    }
}

/// The forces that fingers answer together, and what each answers.
pub(super) struct Answers<T> {
    /// As [`Sum::left`].
    pub left: [f64; 3],
    pub each: Vec<Answer<T>, MAX_FINGERS>,
}

impl<T> Answers<T> {
    /// The same if every finger has found an equilibrium; else the status of the first one that has not.
    pub fn all_good(self) -> Result<Self, Status> {
        let failed = self.each.iter().find(|answer| answer.status != Status::Converged);
        failed.map(|answer| answer.status).map_or(Ok(self), Err)
    }
}

impl<T: Real, S: Size> Grasp<'_, T, S> {
    /// There is friction.
    pub(super) fn rubs(&self) -> bool {
        self.fingers.iter().any(|finger| finger.follower.rubs())
    }

    /// The fingers go to their coordinates while the object stays; false if one cannot.
    #[inline(never)]
    pub(super) fn go_alone(&mut self, to: &[f64]) -> bool {
        let mut all = true;
        for (index, &to) in to.iter().enumerate() {
            let left = self.left().clamp(LEAST, FOLLOW_ITERATIONS);
            let Some(finger) = self.fingers.get_mut(index) else { break };
            let outcome = finger.follower.follow_within(to, left);
            self.spent = self.spent.saturating_add(outcome.iterations.max(1));
            all &= outcome.status.is_trustworthy();
        }
        all
    }

    /// What is left of the fingers' ways, rad or mm.
    #[inline(never)]
    pub(super) fn ways(&self, to: &[f64]) -> [f64; MAX_FINGERS] {
        let mut ways = [0.0; MAX_FINGERS];
        for ((way, finger), to) in ways.iter_mut().zip(&self.fingers).zip(to) {
            *way = T::of(*to).to_f64() - finger.follower.solution().coordinate();
        }
        ways
    }

    /// The largest part of the ways that no finger's step is too long for.
    #[inline(never)]
    pub(super) fn farthest(&self, ways: &[f64]) -> f64 {
        let parts = self.fingers.iter().zip(ways).map(|(finger, way)| finger.follower.max_step().to_f64() / way.abs());
        // Of no way a division by zero leaves no bound.
        parts.fold(1.0, f64::min)
    }

    /// −Σ dF/dC at a step (N, mm, and the turn times the size), where the forces are known. With friction they differ with the way: they are
    /// those towards where the object is pushed. Each finger is solved `anew` from its accepted state or from where it is.
    pub(super) fn slope(
        &mut self,
        ways: &[f64],
        at: &Step,
        here: &[f64; 3],
        pushed: &[f64; 3],
        anew: bool,
    ) -> Result<Slope, Status> {
        let mut slope = [[0.0; 3]; 3];
        for j in 0..3 {
            let short = short::<T>();
            let way = if pushed[j] < 0.0 { -short } else { short };
            if self.left() == 0 {
                return Err(Status::MaxIterations);
            }
            let mut beside = *at;
            beside.object[j] += way;
            let there = self.answer_in(ways, &beside, 1, anew)?.left;
            for i in 0..3 {
                slope[i][j] = (here[i] - there[i]) / way;
            }
        }
        Ok(slope)
    }

    /// What the fingers answer a step.
    pub(super) fn answers(&mut self, ways: &[f64], step: &Step, anew: bool) -> Result<Answers<T>, Status> {
        self.answer_in(ways, step, PATIENCE, anew)
    }

    /// The same within so many iterations of each.
    fn answer_in(&mut self, ways: &[f64], step: &Step, patience: u32, anew: bool) -> Result<Answers<T>, Status> {
        let [wx, wy] = self.load.force;
        let mut left = [wx, wy, self.load.moment];
        let mut each = Vec::new();
        let to = [0, 1].map(|i| self.centre[i] + step.object[i]);
        for index in 0..self.fingers.len() {
            let patience = patience.min(self.left().max(LEAST));
            let aside = self.aside(index, ways, step);
            let Some(finger) = self.fingers.get_mut(index) else { continue };
            let placement = finger.placement;
            let about = placement.point_back(to).map(T::of);
            let answer = finger.follower.answer(&aside, about, patience, anew).ok_or(Status::OutOfRange)?;
            self.spent = self.spent.saturating_add(answer.iterations);
            let [x, y, moment] = answer.wrench.map(Real::to_f64);
            let [x, y] = placement.vector([x, y]);
            left = [left[0] + x, left[1] + y, left[2] + placement.sense() * moment];
            // As much room as for fingers.
            let _ = each.push(answer);
        }
        left[2] /= self.size;
        if left.iter().all(|part| part.is_finite()) { Ok(Answers { left, each }) } else { Err(Status::Stagnated) }
    }

    /// A step as a finger's own world has it.
    fn aside(&self, index: usize, ways: &[f64], step: &Step) -> Aside<T> {
        let way = ways.get(index).copied().unwrap_or_default();
        let [x, y, turn] = step.object;
        let moved = self.fingers.get(index).map_or(Moved::NONE, |finger| Moved {
            about: finger.placement.point_back(self.centre).map(T::of),
            turn: T::of(finger.placement.sense() * turn / self.size),
            shift: finger.placement.vector_back([x, y]).map(T::of),
        });
        Aside { along: T::of(step.part * way), moved, forced: None }
    }

    /// Accepts what was tried last.
    pub(super) fn accept_together(&mut self, ways: &[f64], step: &Step, answers: &Answers<T>) -> Sum {
        let [x, y, turn] = step.object;
        let to = ([self.centre[0] + x, self.centre[1] + y], self.turn + turn / self.size);
        let object = self.given.moved(self.origin, to.0, to.1);
        for (index, answer) in answers.each.iter().enumerate() {
            let aside = self.aside(index, ways, step);
            if let Some(finger) = self.fingers.get_mut(index) {
                let seen: Shape<T> = finger.placement.object_back(&object).into();
                finger.follower.take(&aside, answer, seen);
            }
        }
        (self.centre, self.turn) = to;
        self.sum()
    }

    /// The accepted states are shown again.
    pub(super) fn show_accepted(&mut self) {
        for finger in &mut self.fingers {
            finger.follower.show_accepted();
        }
    }
}
