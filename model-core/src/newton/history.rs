//! What a finger remembers of its accepted past: one mechanism for all that depends on the path.
//!
//! [`History::begin`] forgets, as at an open hand. [`History::aim`] says what the step that follows goes through; its iterations read the
//! past and the aim, and change neither, so that a step is rejected by aiming anew. [`History::accept`] takes an accepted state for the past.

use super::gaps::Contacts;
use super::kinematics::Kinematics;
use super::memory::Memory;
use super::slip::Slip;
use crate::model::Model;
use crate::object::Displacement;
use crate::real::Real;
use crate::size::Size;
use crate::state::State;

/// All that outlives a step.
pub(crate) struct History<T: Real, S: Size> {
    /// Friction.
    pub slip: Slip<T, S>,
    /// The material.
    pub memory: Memory<T, S>,
}

/// The way from the accepted state to the one that a step is looking for.
pub(crate) struct Way<T: Real> {
    /// The object's motion in the finger's frame, mm, and its turn there, rad.
    pub by: Displacement<T>,
    pub turned: T,
    /// Time that it takes, s.
    pub seconds: T,
}

impl<T: Real, S: Size> History<T, S> {
    pub const EMPTY: Self = Self { slip: Slip::EMPTY, memory: Memory::EMPTY };

    /// Makes room for a model; false if there is none.
    pub fn fit(&mut self, model: &Model<T, S>) -> bool {
        self.slip.fit(model) && self.memory.fit(model)
    }

    /// The force depends on the path.
    #[inline(always)]
    pub fn is_kept(&self) -> bool {
        self.slip.rubs() || self.memory.is_kept()
    }

    /// The hand is open and at rest: friction has no past. (Memory has none before, as kinematics are of a finger that has none.)
    pub fn begin(&mut self, model: &Model<T, S>, state: &State<T, S>, kinematics: &Kinematics<T, S>) {
        if self.slip.rubs() {
            self.slip.begin(model, state, kinematics);
        }
    }

    /// The step that follows goes this way from the accepted state.
    pub fn aim(&mut self, model: &Model<T, S>, accepted: &State<T, S>, way: &Way<T>) {
        if self.slip.rubs() {
            self.slip.aim(&way.by, way.turned, model.units.length);
        }
        if self.memory.is_kept() {
            self.memory.aim(model, accepted, way.seconds);
        }
    }

    /// A state is accepted, which kinematics and contacts show, after `before`.
    pub fn accept(
        &mut self,
        model: &Model<T, S>,
        state: &State<T, S>,
        before: &State<T, S>,
        kinematics: &Kinematics<T, S>,
        contacts: &Contacts<T, S>,
    ) {
        if self.slip.rubs() {
            self.slip.accept(model, state, before, kinematics, contacts.rows());
        }
        if self.memory.is_kept() {
            self.memory.accept(model, state, kinematics.nodes.as_ref(), kinematics.members.as_ref(), contacts.rows());
        }
    }
}
