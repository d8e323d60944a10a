//! The loop: Newton's method at one coordinate, and what it says of the state that it ends at.

use super::factored::Factored;
use super::gaps::Sweep;
use super::inertia::Inertia;
use super::residual::Largest;
use super::settings::NewtonSettings;
use super::{Hessian, Workspace};
use crate::model::Model;
use crate::object::Object;
use crate::real::{Real, Tolerance};
use crate::size::Size;
use crate::state::State;
use crate::status::Status;

/// New rows of a short step's first iteration beyond which they are thinned.
pub(crate) const MANY: usize = 7;
/// Rows that do not touch yet, at most, if a tick has time for one iteration only.
pub(crate) const FEW: usize = 3;
/// Largest difference of an angle, rad, at which one state's inertia is taken for another's (see the module `equilibrium`).
pub const NEAR_ENOUGH: f64 = 2e-3;
/// Change of an angle, in units of the precision's [`Real::EPSILON`], below which a Newton step is rounding.
const ROUNDING: f64 = 1e3;
/// Part of [`NEAR_ENOUGH`] up to which an attempt begins with the last one's factorisation: beyond, it would have to judge its solution.
const CARRIED: f64 = 0.3;
/// A gradient beyond which no iteration comes back, N·mm.
const ENDLESS: f64 = 1e12;
/// Part of the residuals that an iteration must leave at most to count as progress, how many may leave more, and the residuals, in
/// tolerances, below which these are the precision's floor.
const PROGRESS: f64 = 0.7;
const STALLS: u32 = 6;
const FLOOR: f64 = 100.0;

/// What one attempt may take, and when it has converged.
pub(crate) struct Limits<T> {
    /// Iterations; judging the solution may take one more, within the budget.
    pub iterations: u32,
    pub budget: u32,
    pub tolerance: Tolerance<T>,
    pub hessian: Hessian,
    /// Gap within which a sample takes part before it touches, mm.
    pub margin: T,
    /// A short step: of many new rows at its first iteration only the deepest are kept.
    pub thins: bool,
    /// The tick has time for one iteration only: its work is bounded, and the next tick does the rest.
    pub is_short: bool,
}

/// A state that is known to be stable, and how far it is from the one whose inertia says so, rad.
pub(crate) struct Judged<'a, T: Real, S: Size> {
    pub state: &'a State<T, S>,
    pub drift: T,
}

/// Result of Newton's method at one coordinate.
pub(crate) struct Attempt<T> {
    pub status: Status,
    pub iterations: u32,
    /// What the last factorisation says, and how far the state has moved from the one that it was made at.
    pub inertia: Option<Inertia>,
    pub drift: T,
    /// Some iterate was unstable with contacts that had settled.
    unstable: bool,
    /// Largest change of an angle in the smallest step, rad.
    least_turn: T,
    pub residual: Largest<T>,
    pub sweep: Sweep<T>,
}

impl<T: Real> Attempt<T> {
    fn new() -> Self {
        let unknown = T::of(Largest::<T>::UNKNOWN);
        Self {
            status: Status::MaxIterations,
            iterations: 0,
            inertia: None,
            drift: T::ZERO,
            unstable: false,
            least_turn: unknown,
            residual: Largest { gradient: unknown, length: unknown },
            sweep: Sweep::NONE,
        }
    }

    /// Why it failed.
    pub fn cause(&self) -> Status {
        if self.unstable {
            Status::Folded
        } else if self.inertia.is_some_and(|inertia| !inertia.settled) {
            Status::Unsettled
        } else if self.least_turn <= T::of(ROUNDING) * T::EPSILON
            || self.status == Status::Converged && self.inertia.is_some_and(|inertia| !inertia.is_stable())
        {
            // Steps that are rounding, or an inertia that no matrix has.
            Status::Precision
        } else {
            Status::Stagnated
        }
    }

    /// It has failed for lack of iterations. (An iterate on the way may find more samples touching than there is room for.)
    pub fn is_cut_off(&self) -> bool {
        let finite = self.residual.gradient < T::of(ENDLESS) && self.residual.length.is_finite();
        finite && matches!(self.status, Status::MaxIterations | Status::ContactCapacity)
    }

    /// Takes what an iteration's step says.
    fn note(&mut self, inertia: Inertia) {
        self.inertia = Some(inertia);
        self.unstable |= inertia.is_unstable();
        self.iterations += 1;
    }
}

/// How the residuals go down.
struct Progress<T> {
    /// Smallest and last size of the residuals, in tolerances.
    best: T,
    last: T,
    stalled: u32,
}

impl<T: Real> Progress<T> {
    fn new() -> Self {
        let unknown = T::of(Largest::<T>::UNKNOWN);
        Self { best: unknown, last: unknown, stalled: 0 }
    }

    /// Takes the residuals of an iterate: their size as a part of the last one's, or `None` where no more is to come of it.
    fn next(&mut self, size: T) -> Option<T> {
        if size < self.best * T::of(PROGRESS) {
            (self.best, self.stalled) = (size, 0);
        } else {
            self.stalled += 1;
            if self.stalled > STALLS && size < T::of(FLOOR) {
                return None;
            }
        }
        let last = core::mem::replace(&mut self.last, size);
        Some(size / last)
    }
}

impl<T: Real, S: Size> Workspace<T, S> {
    /// Newton's method from a state, at the object where the coordinate α has it: θ, λ and μ become those of the last iterate.
    pub(crate) fn newton<O: Object<T>>(
        &mut self,
        model: &Model<T, S>,
        factored: &mut Factored<T, S>,
        state: &mut State<T, S>,
        object: &O,
        judged: Judged<'_, T, S>,
        limits: &Limits<T>,
    ) -> Attempt<T> {
        let settings = NewtonSettings::<T>::of_precision();
        let (near, newton) = (T::of(NEAR_ENOUGH), limits.hessian == Hessian::Newton);
        let rubs = self.history.slip.rubs();
        self.solution.is_bounded = limits.is_short;
        let mut attempt = Attempt::new();
        let mut progress = Progress::new();
        // The last step was a whole one of a factorisation that may be kept; or that of the last attempt is near enough to begin with.
        let moved = judged.drift + state.largest_move(judged.state, model);
        let carries = settings.carries && factored.is_near && newton && !self.history.is_kept();
        let mut may_keep = carries && moved <= T::of(CARRIED) * near;
        if may_keep {
            // No step has led here.
            (attempt.drift, self.increment.largest) = (moved, T::one());
        }
        loop {
            let (residual, sweep) = if may_keep && settings.spares_tangents {
                self.evaluate_residuals(model, state, object, limits.margin)
            } else {
                self.evaluate(model, state, object, limits.margin)
            };
            (attempt.residual, attempt.sweep) = (residual, sweep);
            if attempt.iterations == 0 && limits.thins {
                self.contacts.thin(MANY);
            }
            if limits.is_short {
                self.contacts.cut(FEW);
            }

            // The ways out: converged, out of iterations, beyond all bounds (NaN included), or at the precision's floor.
            if residual.is_within(&limits.tolerance) {
                if attempt.iterations == 0 {
                    attempt.drift = judged.drift + state.largest_move(judged.state, model);
                }
                // The last factorisation was made at another state: where that is not near enough, judge the solution itself.
                let is_stable = attempt.inertia.is_none_or(|inertia| inertia.is_stable())
                    && factored.kkt.has_gaps_of(model, &self.kinematics);
                if !newton || is_stable && attempt.drift <= near {
                    attempt.status = Status::Converged;
                } else if attempt.iterations < limits.budget {
                    attempt.status = Status::Converged;
                    if self.kinematics.lacks_tangent {
                        self.evaluate(model, state, object, limits.margin);
                    }
                    attempt.note(self.solve(model, factored, Hessian::Newton, T::ZERO));
                    attempt.drift = T::ZERO;
                }
                return attempt;
            }
            if attempt.iterations >= limits.iterations {
                if sweep.overflow {
                    attempt.status = Status::ContactCapacity;
                }
                return attempt;
            }
            if residual.gradient >= T::of(ENDLESS) {
                return attempt;
            }
            let size = residual.size(&limits.tolerance);
            let Some(contraction) = progress.next(size) else {
                attempt.status = if sweep.overflow { Status::ContactCapacity } else { Status::Stagnated };
                return attempt;
            };

            let keeps = may_keep && settings.keeps(rubs, contraction, size);
            let kept = if keeps { self.solve_kept(model, factored) } else { None };
            let inertia = match kept {
                Some(inertia) => inertia,
                None => {
                    if may_keep && settings.spares_tangents {
                        self.evaluate(model, state, object, limits.margin);
                    }
                    attempt.drift = T::ZERO;
                    self.solve(model, factored, limits.hessian, T::ZERO)
                }
            };
            attempt.note(inertia);

            let (part, turn) = (self.increment.clip(), self.increment.largest);
            attempt.drift += part * turn;
            attempt.least_turn = attempt.least_turn.min(turn);
            self.apply(model, state, part);
            // What the factorisation is kept for would have to be judged at the end.
            let is_near = attempt.drift <= near;
            may_keep = settings.keeps_factors(rubs) && is_near && part == T::one() && newton;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is reported where a step fails and nothing is found beyond.
    #[test]
    fn only_an_unstable_state_is_a_fold() {
        let stable = Inertia { excess: 1, border: 1, settled: true };
        let failed = |inertia: Option<Inertia>, unstable, least_turn| {
            Attempt::<f32> { iterations: 25, inertia, unstable, least_turn, ..Attempt::new() }.cause()
        };
        assert_eq!(failed(Some(stable), true, 0.1), Status::Folded);
        assert_eq!(failed(Some(Inertia { settled: false, ..stable }), false, 0.1), Status::Unsettled);
        assert_eq!(failed(Some(stable), false, 1e-5), Status::Precision);
        assert_eq!(failed(Some(stable), false, 0.1), Status::Stagnated);
        assert_eq!(failed(None, false, 0.1), Status::Stagnated);
    }

    /// Iterates that leave less each time go on, those at a floor end, and how much the last step has left is known.
    #[test]
    fn residuals_that_stall_at_a_floor_end_the_loop() {
        let mut progress = Progress::<f64>::new();
        progress.next(80.0);
        assert_eq!(progress.next(8.0), Some(0.1));
        assert!((0..STALLS).all(|_| progress.next(7.0).is_some()));
        assert_eq!(progress.next(7.0), None);
        let mut far = Progress::<f64>::new();
        assert!((0..20).all(|_| far.next(2.0 * FLOOR).is_some()), "far from the floor it may yet come down");
    }
}
