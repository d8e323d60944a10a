//! One step, stage by stage: residuals at a state, then the increments that are to take them away.

use super::condense::Diagonal;
use super::evaluated::Evaluated;
use super::factored::Factored;
use super::gaps::Sweep;
use super::inertia::Inertia;
use super::kinematics::SMALL;
use super::residual::Largest;
use super::settings::NewtonSettings;
use super::{Hessian, Workspace, end_gaps, slip};
use crate::contact::coulomb;
use crate::element::{Depth, Places, Residuals, Tangents};
use crate::model::Model;
use crate::object::Object;
use crate::real::Real;
use crate::size::Size;
use crate::state::State;

/// Increment of an angle below which the normals of a step leave nothing to replace, as a rule, rad.
const NOTHING_TO_REPOSITION: f64 = 1e-6;
/// Part of the gradient's tolerance up to which forces may be misdirected before the front is strained again.
const MISDIRECTED: f64 = 0.01;

impl<T: Real, S: Size> Workspace<T, S> {
    /// Front beam and gaps at a state, and nothing else.
    #[inline(never)]
    pub(crate) fn place<O: Object<T>>(&mut self, model: &Model<T, S>, state: &State<T, S>, object: &O) -> Sweep<T> {
        let Self { kinematics, contacts, history, .. } = self;
        kinematics.direct(model, state);
        contacts.recall(model, state);
        kinematics.place_front::<Places>(model, &history.memory, state, contacts.rows());
        contacts.sweep(model, state, kinematics, object, T::ZERO, history.slip.room())
    }

    /// Kinematics, gaps, forces, gradient and second derivatives at a state.
    pub(crate) fn evaluate<O: Object<T>>(
        &mut self,
        model: &Model<T, S>,
        state: &State<T, S>,
        object: &O,
        margin: T,
    ) -> (Largest<T>, Sweep<T>) {
        self.kinematics.direct(model, state);
        self.evaluate_to::<O, Tangents>(model, state, object, margin)
    }

    /// As [`Self::evaluate`] after a whole step, but without the second derivatives: they stay those of an earlier state where that
    /// spares something.
    pub(crate) fn evaluate_residuals<O: Object<T>>(
        &mut self,
        model: &Model<T, S>,
        state: &State<T, S>,
        object: &O,
        margin: T,
    ) -> (Largest<T>, Sweep<T>) {
        if self.increment.largest <= T::of(SMALL) {
            self.kinematics.turn(model, self.increment.angle.as_ref());
        } else {
            self.kinematics.direct(model, state);
        }
        self.evaluate_to::<O, Residuals>(model, state, object, margin)
    }

    fn evaluate_to<O: Object<T>, D: Depth>(
        &mut self,
        model: &Model<T, S>,
        state: &State<T, S>,
        object: &O,
        margin: T,
    ) -> (Largest<T>, Sweep<T>) {
        let NewtonSettings { repositions, tolerance, .. } = NewtonSettings::<T>::of_precision();
        let Self { effort, kinematics, contacts, residual, increment, history, .. } = self;
        let (slip, memory) = (&history.slip, &history.memory);
        let rubs = slip.rubs();
        effort.evaluates();
        contacts.recall(model, state);
        if rubs {
            slip.pair(model, state, contacts);
        }
        // After a small step the normals are those of the object up to second order: nothing is left to replace, as a rule.
        let at_once = !repositions || !D::TANGENT && increment.largest <= T::of(NOTHING_TO_REPOSITION);
        if at_once {
            kinematics.place_front::<D>(model, memory, state, contacts.rows());
        } else {
            kinematics.place_front::<Places>(model, memory, state, contacts.rows());
        }
        let mut sweep = contacts.sweep(model, state, kinematics, object, margin, slip.room());
        // Too many near samples: only those that penetrate need rows.
        if sweep.near_overflow {
            sweep = contacts.sweep(model, state, kinematics, object, T::ZERO, slip.room());
        }
        if rubs {
            slip.pair(model, state, contacts);
        }
        if repositions && !(at_once && contacts.misdirected(model) <= T::of(MISDIRECTED) * tolerance.gradient) {
            contacts.redirect();
            if rubs {
                slip::redirect(contacts.rows_mut());
            }
            kinematics.place_front::<D>(model, memory, state, contacts.rows());
            contacts.measure(model, kinematics, object);
        }
        if rubs {
            slip.measure(model, state, kinematics, contacts);
            slip::turn(model, kinematics, contacts.rows());
        }
        kinematics.complete::<D>(model, memory, state);
        let mut worst = residual.gather(model, kinematics, contacts, &sweep);
        if rubs {
            worst.length = worst.length.max(slip.missed(model, contacts.rows()));
        }
        (worst, sweep)
    }

    /// Factorises at the evaluated state and borders the factorisation by the rows; returns the number of negative pivots.
    pub(crate) fn factorise(
        &mut self,
        model: &Model<T, S>,
        factored: &mut Factored<T, S>,
        diagonal: Diagonal<T>,
    ) -> usize {
        let Self { kinematics, contacts, residual, right, solution, increment, .. } = self;
        let at = Evaluated { model, kinematics, contacts };
        solution.forget();
        factored.make(at, residual, diagonal, right, increment.angle.as_mut())
    }

    /// Borders a factorisation by the present rows.
    pub(crate) fn border(&mut self, model: &Model<T, S>, factored: &mut Factored<T, S>) {
        let Self { kinematics, contacts, right, solution, increment, .. } = self;
        let at = Evaluated { model, kinematics, contacts };
        solution.forget();
        factored.kkt.forget_rows();
        factored.border.make(at, &factored.kkt, right, increment.angle.as_mut());
    }

    /// Factorises at the evaluated state, settles the active set and finds the increments.
    pub(crate) fn solve(
        &mut self,
        model: &Model<T, S>,
        factored: &mut Factored<T, S>,
        hessian: Hessian,
        shift: T,
    ) -> Inertia {
        let inertia = self.judge(model, factored, hessian, shift);
        self.find(model, factored);
        inertia
    }

    /// As [`Self::solve`], for a step that is taken only if it is stable or lets the object go: otherwise there are no increments.
    pub(crate) fn solve_if_stable(&mut self, model: &Model<T, S>, factored: &mut Factored<T, S>) -> Option<Inertia> {
        let inertia = self.judge(model, factored, Hessian::Newton, T::ZERO);
        if !inertia.is_stable() && self.solution.presses(&self.contacts) {
            return None;
        }
        self.find(model, factored);
        Some(inertia)
    }

    /// Factorises at the evaluated state and settles the active set.
    #[inline(never)]
    fn judge(&mut self, model: &Model<T, S>, factored: &mut Factored<T, S>, hessian: Hessian, shift: T) -> Inertia {
        self.effort.solves();
        if hessian == Hessian::Newton {
            self.contacts.add_turning(S::CONTACTS);
        }
        self.factorise(model, factored, Diagonal::of(hessian, shift));
        factored.kkt.note(&self.contacts, self.history.slip.rubs());
        self.settle(factored)
    }

    /// Finds the increments at the evaluated state with an earlier factorisation, if that has the present rows (35).
    /// Where a rib's end is at the back beam, what is across its face turns too much with it: there is none then.
    pub(crate) fn solve_kept(&mut self, model: &Model<T, S>, factored: &mut Factored<T, S>) -> Option<Inertia> {
        let Self { effort, kinematics, contacts, residual, right, increment, .. } = self;
        if end_gaps::any_shut(model, kinematics)
            || !factored.kkt.has_gaps_of(model, kinematics)
            || !factored.kkt.takes(model, contacts)
        {
            return None;
        }
        effort.solves();
        let at = Evaluated { model, kinematics, contacts };
        factored.border.load(at, residual, &factored.kkt, right, increment.angle.as_mut());
        let inertia = self.settle(factored);
        self.find(model, factored);
        Some(inertia)
    }

    /// Settles the contacts on the bordered factorisation.
    fn settle(&mut self, factored: &Factored<T, S>) -> Inertia {
        let Self { contacts, right, solution, history, .. } = self;
        let settled = solution.settle(&factored.border, right, contacts, &history.slip);
        Inertia::of(factored.kkt.excess, settled, contacts)
    }

    /// Finds the increments from the settled contacts.
    #[inline(never)]
    fn find(&mut self, model: &Model<T, S>, factored: &Factored<T, S>) {
        let Self { kinematics, contacts, right, solution, increment, history, .. } = self;
        let Factored { kkt, border, .. } = factored;
        let slip = &history.slip;
        let at = Evaluated { model, kinematics, contacts };
        if slip.rubs() {
            coulomb::turn(contacts.rows(), T::one(), solution.delta.as_mut());
        }
        increment.find(at, kkt, border, right, solution.delta.as_ref());
        if slip.rubs() {
            coulomb::turn(contacts.rows(), -T::one(), solution.delta.as_mut());
        }
    }

    /// Adds `part` of the increments to a state.
    pub(crate) fn apply(&self, model: &Model<T, S>, state: &mut State<T, S>, part: T) {
        state.add(model, &self.contacts, &self.solution, &self.increment, part);
    }
}
