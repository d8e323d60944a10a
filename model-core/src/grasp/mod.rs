//! A free object between fingers: where it comes to rest under a load, and how hard it is held.
//!
//! Each finger's equilibrium depends on where the object is, and its force on the object is −∂V_i/∂C, so the object rests
//! where Σ F_i + W = 0: a stationary point of the whole elastic energy Σ V_i(C) − W·C, and a stable one where that is least.
//! It is found by Newton's method with the fingers' dF/dC as second derivative, each step bounded and taken only if the
//! energy falls; between steps the fingers are followed, so that the grasp is the one that is reached from where the object
//! was held.
//!
//! Without friction a circle's contact forces all pass through its centre, so its balance is that of forces: the turn is left
//! alone. Other shapes turn as well, until the moments are in balance.
//!
//! With friction there is no such energy, and the place depends on the way: fingers and object move together, step by step
//! ([`Grasp::advance_within`]).

#[cfg(test)]
mod gripping;
mod margin;
mod pace;
mod portal;
mod resume;
mod rubbing;
mod slope;
mod survey;
mod together;
mod touches;

use heapless::Vec;

use crate::equilibrium::{FOLLOW_ITERATIONS, Follower, Mark};
use crate::linear::cholesky::cholesky;
use crate::newton::Effort;
pub use crate::object::Placement;
use crate::object::{Motion, ObjectDesign, ObjectError, Shape};
use crate::real::Real;
use crate::size::Size;
use crate::status::Status;
pub use margin::{Margin, Pull, Touch, margin};
pub use resume::{Held, Place};
pub use rubbing::Course;
pub use survey::{Bears, Survey};
pub use touches::touches;

/// The most fingers of a grasp.
pub const MAX_FINGERS: usize = 4;
/// Steps before the search for a balance is given up.
const STEPS: u32 = 200;
/// The longest step, mm (of a turn: at the object's outline).
const LONGEST: f64 = 1.0;
/// Halvings of a step before it is given up.
const HALVINGS: u32 = 12;
/// Newton iterations that every finger may take for a step that was begun, whatever is left.
const LEAST: u32 = 4;
/// By how many Newton iterations [`Grasp::release_within`] may exceed what it was allowed.
pub const EXCESS: u32 = LEAST * MAX_FINGERS as u32;
/// The least stiffness that is divided by, N/mm.
const SOFTEST: f64 = 0.05;

/// A finger of a grasp.
pub struct Finger<'a, T: Real, S: Size> {
    /// Its model, configured.
    pub follower: &'a mut Follower<T, S>,
    /// Where it is.
    pub placement: Placement,
    /// How its base moves, in the finger's own world.
    pub motion: Motion,
}

/// What pulls at the object besides the fingers.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Load {
    /// Force at the object's reference point (centre; of a polygon, the mean of its corners), N.
    pub force: [f64; 2],
    /// Moment, N·mm, counter-clockwise. Without friction a circle cannot be held against one.
    pub moment: f64,
}

/// Why there is no grasp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GraspError {
    /// Fewer than one or more than [`MAX_FINGERS`] fingers.
    Fingers {
        /// How many.
        count: usize,
    },
    /// The object is not a good one.
    Object(ObjectError),
    /// A half-plane has no end that could be free.
    Endless,
    /// A load that is not finite, or a moment on a circle.
    Load,
    /// Not as many coordinates as fingers, or one that is not finite.
    Coordinates,
    /// A finger's object is not the first one's.
    Different {
        /// Which finger, from 0.
        finger: usize,
    },
}

impl core::fmt::Display for GraspError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Fingers { count } => write!(f, "a grasp has 1 to {MAX_FINGERS} fingers, not {count}"),
            Self::Object(error) => error.fmt(f),
            Self::Endless => f.write_str("a half-plane cannot be free; allowed are circle, ellipse and polygon"),
            Self::Load => f.write_str("the load is not finite, or has a moment that nothing can hold a circle against"),
            Self::Coordinates => f.write_str("a finite coordinate is needed for each finger"),
            Self::Different { finger } => write!(f, "finger {finger} has another object than finger 0"),
        }
    }
}

impl core::error::Error for GraspError {}

/// Where the object rests, and what holds it. Grasp's world, mm, N, rad.
#[derive(Clone, Debug, PartialEq)]
pub struct Balance {
    /// `converged` or `snapped` (a finger has, or with friction the object) for a stable balance; `no-contact` if nothing holds the object and nothing
    /// pulls at it; `max-iterations` if it was still moving; `folded` if the balance is not stable; `stagnated` if no step
    /// leads further; else the status of the finger that could not be followed.
    pub status: Status,
    /// The object's reference point.
    pub centre: [f64; 2],
    /// Its turn since it was given.
    pub turn: f64,
    /// Force of each finger on the object.
    pub forces: Vec<[f64; 2], MAX_FINGERS>,
    /// Their sum: what they hold against the load.
    pub net: [f64; 2],
    /// Half of what the magnitudes of the fingers' forces exceed that of their sum by: the force with which they press
    /// against each other. With two opposed fingers and no load, the force of either; 0 if one finger bears all.
    pub squeeze: f64,
    /// Stiffness of the grasp: how force (N) and moment (N·mm) on the object rise against its motion (mm and rad, about the
    /// reference point). Positive definite where the balance is stable; zero if it was not found. With friction it is not symmetric, and that of a
    /// motion that goes on as the last one did.
    pub stiffness: [[f64; 3]; 3],
    /// What is left of force (N) and moment over the object's size (N).
    pub residual: f64,
    /// Steps taken.
    pub steps: u32,
    /// What that cost, in Newton iterations of a finger (derivatives count as one).
    pub iterations: u32,
}

/// Fingers with an object between them.
pub struct Grasp<'a, T: Real, S: Size> {
    fingers: Vec<Finger<'a, T, S>, MAX_FINGERS>,
    /// The object as it was given, its reference point then, and its size.
    given: ObjectDesign,
    origin: [f64; 2],
    size: f64,
    load: Load,
    centre: [f64; 2],
    turn: f64,
    /// The fingers have been closed.
    begun: bool,
    /// Newton iterations allowed for what is being done, and spent.
    allowed: u32,
    spent: u32,
    /// What the last balance with friction leaves for the next one.
    course: Course,
}

/// Sum over the fingers at the present place.
struct Sum {
    /// Σ V − W·C, with what friction has dissipated, N·mm.
    energy: f64,
    /// What the motors give against the contact, N·mm, or N of a translated base; with friction only.
    torques: [f64; MAX_FINGERS],
    /// Force and moment left, N and N·mm over the size: the energy's gradient with its sign changed.
    left: [f64; 3],
    touching: usize,
}

impl<'a, T: Real, S: Size> Grasp<'a, T, S> {
    /// Puts an object between fingers, which are opened. The object's place is where it is held until [`Self::release`].
    ///
    /// # Errors
    /// What is wrong with the number of fingers, the object or the load.
    pub fn new(
        mut fingers: Vec<Finger<'a, T, S>, MAX_FINGERS>,
        object: ObjectDesign,
        load: Load,
    ) -> Result<Self, GraspError> {
        if fingers.is_empty() {
            return Err(GraspError::Fingers { count: 0 });
        }
        object.validate().map_err(GraspError::Object)?;
        let (origin, size) = object.reference().ok_or(GraspError::Endless)?;
        let free = is_round(&object) && !fingers.iter().any(|finger| finger.follower.rubs());
        let finite = load.force.iter().all(|part| part.is_finite()) && load.moment.is_finite();
        if !finite || (free && load.moment != 0.0) {
            return Err(GraspError::Load);
        }
        for finger in &mut fingers {
            finger.follower.set_object(finger.placement.object_back(&object), finger.motion);
        }
        let (centre, turn, begun) = (origin, 0.0, false);
        Ok(Self {
            fingers,
            given: object,
            origin,
            size,
            load,
            centre,
            turn,
            begun,
            allowed: u32::MAX,
            spent: 0,
            course: Course::default(),
        })
    }

    /// Changes what pulls at the object; it stays where it is until [`Self::release`].
    ///
    /// # Errors
    /// A load that is not finite, or a moment on a circle.
    pub fn set_load(&mut self, load: Load) -> Result<(), GraspError> {
        let finite = load.force.iter().all(|part| part.is_finite()) && load.moment.is_finite();
        if !finite || (self.freedoms() == 2 && load.moment != 0.0) {
            return Err(GraspError::Load);
        }
        self.load = load;
        Ok(())
    }

    /// Moves the fingers' bases to coordinates (rad or mm, one per finger) while the object is held where it is; the first
    /// time from open fingers. Returns the status of the first finger that could not follow, or `converged`.
    ///
    /// # Errors
    /// Not as many finite coordinates as fingers.
    pub fn close(&mut self, coordinates: &[f64]) -> Result<Status, GraspError> {
        self.check(coordinates)?;
        let begun = core::mem::replace(&mut self.begun, true);
        let mut worst = Status::Converged;
        for (finger, &at) in self.fingers.iter_mut().zip(coordinates) {
            if !begun {
                finger.follower.start(at);
            }
            let status = finger.follower.follow(at).status;
            if worst.is_trustworthy() && !status.is_trustworthy() {
                worst = status;
            }
        }
        Ok(worst)
    }

    /// Lets the object go: it moves to where the fingers' forces balance the load.
    pub fn release(&mut self) -> Balance {
        self.release_within(u32::MAX)
    }

    /// The same with so many Newton iterations of a finger, derivatives counted as one each: no new step or derivative is begun when
    /// they are spent, and the last step takes [`EXCESS`] more at most. With `max-iterations` the balance is not reached; the
    /// next call goes on from where the object then is.
    pub fn release_within(&mut self, iterations: u32) -> Balance {
        (self.allowed, self.spent) = (iterations, 0);
        if self.rubs() {
            let mut at = [0.0; MAX_FINGERS];
            for (at, finger) in at.iter_mut().zip(&self.fingers) {
                *at = finger.follower.solution().coordinate();
            }
            return self.advance_rubbing(&at);
        }
        let tolerance = (1e-6_f64).max(2e3 * T::EPSILON.to_f64());
        let mut steps = 0;
        let mut here = self.sum();
        let mut known;
        let status = loop {
            known = None;
            if self.left() < self.fingers.len() as u32 {
                break Status::MaxIterations;
            }
            let Some(stiffness) = self.stiffness() else {
                break self.failure();
            };
            known = Some(stiffness);
            let n = self.freedoms();
            let forces: f64 = self.fingers.iter().map(|finger| magnitude(self.force(finger))).sum();
            if largest(&here.left) <= tolerance * (1.0 + forces) {
                // A finger that pushes the object away touches it with less and less until nothing is left to tell.
                let held = here.touching > 0 && forces > 4.0 * tolerance;
                break if held { self.standing(&self.scaled(&stiffness), n) } else { Status::NoContact };
            }
            if steps >= STEPS {
                break Status::MaxIterations;
            }
            steps += 1;
            let mut step = newton(&self.scaled(&stiffness), &here.left, n);
            let length = magnitude3(&step);
            if length > LONGEST {
                step = step.map(|part| part * LONGEST / length);
            }
            match self.descend(&here, step) {
                Ok(there) => here = there,
                Err(status) => {
                    here = self.sum();
                    break status;
                }
            }
        };
        self.report(status, &here, steps, known)
    }

    /// Moves the bases to coordinates (rad or mm, one per finger) while the object, let go, moves with them: with friction one step of all
    /// after the other, without it first the fingers and then the object, as no way matters. The fingers have been closed before.
    ///
    /// At most about so many Newton iterations, as [`Self::release_within`]: with `max-iterations` fingers and object have come as far as
    /// they have, in balance or not, and the next call goes on from there.
    ///
    /// # Errors
    /// Not as many finite coordinates as fingers.
    pub fn advance_within(&mut self, coordinates: &[f64], iterations: u32) -> Result<Balance, GraspError> {
        if self.rubs() && self.begun {
            self.check(coordinates)?;
            (self.allowed, self.spent) = (iterations, 0);
            return Ok(self.advance_rubbing(coordinates));
        }
        self.close(coordinates)?;
        Ok(self.release_within(iterations))
    }

    fn check(&self, coordinates: &[f64]) -> Result<(), GraspError> {
        let good = coordinates.len() == self.fingers.len() && coordinates.iter().all(|at| at.is_finite());
        if good { Ok(()) } else { Err(GraspError::Coordinates) }
    }

    /// What was computed so far, all fingers together.
    pub fn effort(&self) -> Effort {
        self.fingers.iter().fold(Effort::default(), |sum, finger| sum.with(finger.follower.effort()))
    }

    /// Newton iterations that may still be spent.
    fn left(&self) -> u32 {
        self.allowed.saturating_sub(self.spent)
    }

    /// Goes along a step as far as the energy falls.
    fn descend(&mut self, here: &Sum, step: [f64; 3]) -> Result<Sum, Status> {
        if self.left() == 0 {
            return Err(Status::MaxIterations);
        }
        let from = (self.centre, self.turn);
        let mut marks: Vec<_, MAX_FINGERS> = Vec::new();
        for finger in &mut self.fingers {
            // As much room as for fingers.
            let _ = marks.push(finger.follower.mark());
        }
        let found = self.search(here, step, from, &marks);
        for finger in &mut self.fingers {
            finger.follower.unmark();
        }
        found
    }

    /// Halves a step until the energy falls; every part of it is tried from where it begins.
    fn search(
        &mut self,
        here: &Sum,
        step: [f64; 3],
        from: ([f64; 2], f64),
        marks: &[Mark<T, Shape<T>>],
    ) -> Result<Sum, Status> {
        let slope: f64 = here.left.iter().zip(&step).map(|(force, part)| force * part).sum();
        let mut part = 1.0;
        let mut failed = Status::Stagnated;
        for _ in 0..HALVINGS {
            match self.go(from, step.map(|x| x * part)) {
                Ok(()) => {
                    let there = self.sum();
                    let falls = there.energy <= here.energy - 1e-4 * part * slope;
                    // Close to the end the energy's digits run out before the forces' do.
                    let better = largest(&there.left) < 0.5 * largest(&here.left);
                    if falls || better {
                        return Ok(there);
                    }
                    if self.left() == 0 {
                        // The next call goes on from here: from where the step began it would only repeat it.
                        return Err(Status::MaxIterations);
                    }
                }
                Err(status) => failed = status,
            }
            for (finger, mark) in self.fingers.iter_mut().zip(marks) {
                finger.follower.go_back(mark);
            }
            (self.centre, self.turn) = from;
            if self.left() == 0 {
                return Err(Status::MaxIterations);
            }
            part *= 0.5;
        }
        Err(failed)
    }

    /// Moves the object by a step (mm, mm, and the turn times the size); where a finger cannot follow, the object is nowhere.
    fn go(&mut self, from: ([f64; 2], f64), step: [f64; 3]) -> Result<(), Status> {
        let to = ([from.0[0] + step[0], from.0[1] + step[1]], from.1 + step[2] / self.size);
        for index in 0..self.fingers.len() {
            self.take(index, from, to)?;
        }
        (self.centre, self.turn) = to;
        Ok(())
    }

    /// One finger sees the object move from a place and turn to another.
    fn take(&mut self, index: usize, from: ([f64; 2], f64), to: ([f64; 2], f64)) -> Result<(), Status> {
        let (given, origin) = (self.given, self.origin);
        let left = self.left().clamp(LEAST, FOLLOW_ITERATIONS);
        let Some(finger) = self.fingers.get_mut(index) else { return Ok(()) };
        let placement = finger.placement;
        let seen = |centre, turn| placement.object_back(&given.moved(origin, centre, turn));
        let shift = placement.vector_back([to.0[0] - from.0[0], to.0[1] - from.0[1]]);
        let shifted = finger.follower.shift_marked(shift, seen(to.0, from.1), left);
        // Without an iteration it still costs an evaluation.
        let mut spent = shifted.iterations.max(1);
        let mut status = shifted.status;
        if status.is_trustworthy() && to.1 != from.1 {
            let turn = placement.sense() * (to.1 - from.1);
            let left = left.saturating_sub(spent);
            let turned = finger.follower.turn_marked(placement.point_back(to.0), turn, seen(to.0, to.1), left);
            spent += turned.iterations;
            status = turned.status;
        }
        self.spent = self.spent.saturating_add(spent);
        if status.is_trustworthy() { Ok(()) } else { Err(status) }
    }

    /// 2 for a circle or a bore, whose turn nothing depends on without friction, else 3.
    fn freedoms(&self) -> usize {
        if is_round(&self.given) && !self.rubs() { 2 } else { 3 }
    }

    fn force(&self, finger: &Finger<'_, T, S>) -> [f64; 2] {
        finger.placement.vector(finger.follower.solution().force_world().map(Real::to_f64))
    }

    fn sum(&self) -> Sum {
        let [wx, wy] = self.load.force;
        let offset = [self.centre[0] - self.origin[0], self.centre[1] - self.origin[1]];
        let mut energy = -(wx * offset[0] + wy * offset[1]) - self.load.moment * self.turn;
        let mut left = [wx, wy, self.load.moment];
        let (mut touching, mut torques, rubs) = (0, [0.0; MAX_FINGERS], self.rubs());
        for (finger, torque) in self.fingers.iter().zip(&mut torques) {
            if rubs {
                let solution = finger.follower.solution();
                *torque = solution.motor_torque().to_f64();
                energy += solution.dissipated().to_f64();
            }
            let about = finger.placement.point_back(self.centre).map(T::of);
            let [x, y, moment] = finger.follower.solution().wrench(about).map(Real::to_f64);
            let [x, y] = finger.placement.vector([x, y]);
            left = [left[0] + x, left[1] + y, left[2] + finger.placement.sense() * moment];
            energy += finger.follower.solution().potential().to_f64();
            touching += finger.follower.solution().touching();
        }
        left[2] = if self.freedoms() == 3 { left[2] / self.size } else { 0.0 };
        Sum { energy, torques, left, touching }
    }

    /// −Σ dF/dC of the fingers, in N, mm and rad; none if one of them cannot say.
    fn stiffness(&mut self) -> Option<[[f64; 3]; 3]> {
        let mut sum = [[0.0; 3]; 3];
        self.spent = self.spent.saturating_add(self.fingers.len() as u32);
        for finger in &mut self.fingers {
            let placement = finger.placement;
            let about = placement.point_back(self.centre).map(T::of);
            let own = finger.follower.object_stiffness(about)?.map(|row| row.map(Real::to_f64));
            let (x, y, s) = (placement.vector([1.0, 0.0]), placement.vector([0.0, 1.0]), placement.sense());
            // Rows: the grasp's axes; columns: the finger's.
            let turned = [[x[0], y[0], 0.0], [x[1], y[1], 0.0], [0.0, 0.0, s]];
            for i in 0..3 {
                for j in 0..3 {
                    for (k, row) in own.iter().enumerate() {
                        for (l, value) in row.iter().enumerate() {
                            sum[i][j] -= turned[i][k] * value * turned[j][l];
                        }
                    }
                }
            }
        }
        Some(sum)
    }

    /// The stiffness with turns in mm at the outline.
    fn scaled(&self, stiffness: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
        let unit = |i: usize| if i == 2 { 1.0 / self.size } else { 1.0 };
        core::array::from_fn(|i| {
            core::array::from_fn(|j| 0.5 * (stiffness[i][j] + stiffness[j][i]) * unit(i) * unit(j))
        })
    }

    /// Status of a place where nothing is left over of the fingers' forces and the load.
    fn standing(&self, scaled: &[[f64; 3]; 3], n: usize) -> Status {
        // A hair more, so that a direction in which nothing changes is not a matter of rounding.
        let hair = 1e-6 * (0..n).map(|i| scaled[i][i].abs()).fold(0.0, f64::max);
        if cholesky(scaled, n, hair).is_err() {
            return Status::Folded;
        }
        let snapped = self.fingers.iter().any(|finger| finger.follower.has_snapped());
        if snapped { Status::Snapped } else { Status::Converged }
    }

    /// Why a stiffness is missing.
    fn failure(&self) -> Status {
        let lost = self.fingers.iter().any(|finger| !finger.follower.has_equilibrium());
        if lost { Status::OutOfRange } else { Status::ContactCapacity }
    }

    fn report(&mut self, status: Status, here: &Sum, steps: u32, known: Option<[[f64; 3]; 3]>) -> Balance {
        let mut forces = Vec::new();
        for finger in &self.fingers {
            // As much room as for fingers.
            let _ = forces.push(self.force(finger));
        }
        let net = forces.iter().fold([0.0; 2], |sum, force| [sum[0] + force[0], sum[1] + force[1]]);
        let total: f64 = forces.iter().map(|&force| magnitude(force)).sum();
        Balance {
            status,
            centre: self.centre,
            turn: self.turn,
            net,
            squeeze: 0.5 * (total - magnitude(net)),
            forces,
            stiffness: known.unwrap_or_default(),
            residual: largest(&here.left),
            steps,
            iterations: self.spent,
        }
    }
}

/// Nothing depends on the object's turn.
fn is_round(object: &ObjectDesign) -> bool {
    matches!(object, ObjectDesign::Circle { .. } | ObjectDesign::Bore { .. })
}

fn magnitude([x, y]: [f64; 2]) -> f64 {
    libm::hypot(x, y)
}

#[inline(never)]
fn magnitude3(v: &[f64; 3]) -> f64 {
    libm::sqrt(v.iter().map(|x| x * x).sum())
}

#[inline(never)]
fn largest(left: &[f64; 3]) -> f64 {
    // NaN counts as large.
    left.iter().fold(0.0, |most: f64, part| if part.abs() <= most { most } else { part.abs() })
}

/// The Newton step on the leading n freedoms, with as much added to the diagonal as makes it positive definite.
#[inline(never)]
fn newton(stiffness: &[[f64; 3]; 3], left: &[f64; 3], n: usize) -> [f64; 3] {
    let largest = (0..n).map(|i| stiffness[i][i].abs()).fold(SOFTEST, f64::max);
    let mut shift = 0.0;
    let mut factor = cholesky(stiffness, n, -1e-9 * largest);
    for _ in 0..60 {
        if factor.is_ok() {
            break;
        }
        shift = (2.0 * shift).max(1e-2 * largest);
        factor = cholesky(stiffness, n, shift);
    }
    let Ok(l) = factor else { return [0.0; 3] };
    let mut x = *left;
    for i in 0..n {
        for k in 0..i {
            x[i] -= l[i][k] * x[k];
        }
        x[i] /= l[i][i];
    }
    for i in (0..n).rev() {
        for k in i + 1..n {
            x[i] -= l[k][i] * x[k];
        }
        x[i] /= l[i][i];
    }
    for unused in x.iter_mut().skip(n) {
        *unused = 0.0;
    }
    x
}
