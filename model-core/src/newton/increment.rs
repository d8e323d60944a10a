//! The step: increments of all angles and multipliers from those of the contact rows (34).

use super::border::{Border, Right};
use super::condense::solve_interior;
use super::evaluated::Evaluated;
use super::factorisation::Factorisation;
use super::gaps::{Contacts, turned_by};
use super::slip;
use super::solution::ContactSolution;
use crate::access::Access;
use crate::contact::{ContactState, Direction, cell_of};
use crate::element::Node;
use crate::linear::banded;
use crate::model::Model;
use crate::real::Real;
use crate::size::{Size, Storage};
use crate::state::State;
use crate::topology::{CLAMPED, Kind};

/// Largest change of an angle in one step, rad.
pub(crate) const CLIP: f64 = 0.4;

/// The step in angles and closure multipliers.
pub(crate) struct Increment<T: Real, S: Size> {
    /// Δθ of each node, rad.
    pub angle: S::Nodes<T>,
    /// Δφ of the joints, rad, and Δλ, N.
    pub joints: S::Unknowns<T>,
    /// Largest magnitude of Δθ, rad.
    pub largest: T,
}

/// A member whose increments are sought: its index, Σ Δμ n of the contacts above it, and the rows that touch it.
struct Span<T> {
    index: usize,
    above: [T; 2],
    rows: core::ops::Range<usize>,
}

impl<T: Real, S: Size> Increment<T, S> {
    pub const EMPTY: Self = Self {
        angle: <S::Nodes<T> as Storage<T>>::EMPTY,
        joints: <S::Unknowns<T> as Storage<T>>::EMPTY,
        largest: T::ZERO,
    };

    /// Makes room for a model; false if there is none.
    pub fn fit(&mut self, model: &Model<T, S>) -> bool {
        self.angle.fit(model.node_count) && self.joints.fit(model.unknowns())
    }

    /// Finds it from the rows' steps Δμ.
    pub fn find(
        &mut self,
        at: Evaluated<'_, T, S>,
        kkt: &Factorisation<T, S>,
        border: &Border<T, S>,
        right: &Right<T, S>,
        delta: &[T],
    ) {
        let n = at.model.unknowns();
        let joints = self.joints.as_mut().run_mut(0..n);
        for (joint, &right) in joints.iter_mut().zip(right.joints.as_ref()) {
            *joint = right;
        }
        for (&delta, column) in delta.iter().zip(border.columns(n)).take(at.contacts.count) {
            if delta != T::ZERO {
                for (value, &entry) in joints.iter_mut().zip(column) {
                    *value -= entry * delta;
                }
            }
        }
        banded::backward(kkt.band.as_ref().run(0..n), joints);
        self.recover(at, kkt, border, delta);
    }

    /// Increments of the interior angles from those of joints, λ and μ.
    fn recover(&mut self, at: Evaluated<'_, T, S>, kkt: &Factorisation<T, S>, border: &Border<T, S>, delta: &[T]) {
        let Evaluated { model, contacts, .. } = at;
        let mut above = [T::ZERO; 2];
        self.largest = T::ZERO;
        let mut end = contacts.count;
        for index in model.cells()..model.topology.member_count() {
            self.recover_member(at, kkt, border, delta, Span { index, above: [T::ZERO; 2], rows: 0..0 });
        }
        for cell in (0..model.cells()).rev() {
            let rows = contacts.rows.as_ref().run(0..end);
            let own = rows.iter().rev().take_while(|row| cell_of(row) == cell).count();
            let rows = end - own..end;
            end = rows.start;
            let mut own_force = [T::ZERO; 2];
            for (row, &delta) in contacts.rows.as_ref().run(rows.clone()).iter().zip(delta.run(rows.clone())) {
                for i in 0..2 {
                    own_force[i] += delta * row.normal[i];
                }
            }
            self.recover_member(at, kkt, border, delta, Span { index: cell, above, rows });
            above = [above[0] + own_force[0], above[1] + own_force[1]];
        }
    }

    fn recover_member(
        &mut self,
        at: Evaluated<'_, T, S>,
        kkt: &Factorisation<T, S>,
        border: &Border<T, S>,
        delta: &[T],
        span: Span<T>,
    ) {
        let Evaluated { model, kinematics, contacts } = at;
        let Some(member) = model.member(span.index) else { return };
        let nodes = member.nodes();
        let joints = self.joints.as_ref();
        let da = if member.start == CLAMPED { T::ZERO } else { joints.at(usize::from(member.start)) };
        let db = joints.at(usize::from(member.end));
        let mut carried = [-span.above[0], -span.above[1]];
        for term in member.terms() {
            let x = usize::from(term.unknown);
            carried = [carried[0] + term.sign * joints.at(x), carried[1] + term.sign * joints.at(x + 1)];
        }
        let from_start = if kkt.curved {
            kinematics.nodes.as_ref().at(nodes.start).coupling()
        } else {
            model.coupling.as_ref().at(nodes.start)
        };
        let (Some(list), Some(factors), Some(angle)) = (
            kinematics.nodes.as_ref().get(nodes.clone()),
            kkt.interiors.as_ref().get(nodes.clone()),
            self.angle.as_mut().get_mut(nodes.clone()),
        ) else {
            return;
        };
        let pulled = |node: &Node<T>, [x, y]: [T; 2]| -node.gradient - (x * node.lever[0] + y * node.lever[1]);
        let (before, wide) = (from_start.map(|entry| entry * da), member.kind == Kind::Quadratic);
        // Start joints are other members' end joints, or do not move.
        let largest = if span.rows.is_empty() {
            solve_interior((list, factors, angle), before, db, wide, |node, _| pulled(node, carried))
        } else {
            let rows = contacts.rows.as_ref().run(span.rows.clone());
            let own = rows.iter().zip(delta.run(span.rows.clone()));
            let mut beyond = own.clone().rev().peekable();
            for (i, (value, node)) in angle.iter_mut().zip(list).enumerate().skip(1).rev() {
                // Contacts beyond this node pull the whole of it.
                while let Some((row, &delta)) = beyond.next_if(|(row, _)| usize::from(row.place.node) > nodes.start + i)
                {
                    carried = [carried[0] - delta * row.normal[0], carried[1] - delta * row.normal[1]];
                }
                *value = pulled(node, carried);
            }
            for ((row, &delta), own) in own.zip(border.own.as_ref().run(span.rows)) {
                if delta == T::ZERO {
                    continue;
                }
                let first = usize::from(row.place.node).wrapping_sub(nodes.start);
                for (k, &entry) in own.entries.iter().enumerate() {
                    if let Some(value) = angle.get_mut(first.wrapping_add(k)) {
                        *value -= delta * entry;
                    }
                }
            }
            solve_interior((list, factors, angle), before, db, wide, |_, right| right)
        };
        if let Some(start) = angle.first_mut() {
            *start = da;
        }
        self.largest = self.largest.max(largest);
    }

    /// Factor that keeps the largest change of an angle within [`CLIP`].
    pub fn clip(&self) -> T {
        let clip = T::of(CLIP);
        if self.largest > clip { clip / self.largest } else { T::one() }
    }
}

impl<T: Real, S: Size> State<T, S> {
    /// Adds `part` of a step to the angles θ, the closures' multipliers λ and the rows' multipliers μ; those that fall to zero leave the
    /// touching samples.
    pub(crate) fn add(
        &mut self,
        model: &Model<T, S>,
        contacts: &Contacts<T, S>,
        solution: &ContactSolution<T, S>,
        increment: &Increment<T, S>,
        part: T,
    ) {
        let angles = self.angle.as_mut().run_mut(0..model.node_count).iter_mut();
        for (angle, &delta) in angles.zip(increment.angle.as_ref()) {
            *angle += part * delta;
        }
        let steps = increment.joints.as_ref();
        for (lambda, closure) in self.lambda.as_mut().iter_mut().zip(model.topology.closures()) {
            let x = usize::from(closure.unknown);
            *lambda = [lambda[0] + part * steps.at(x), lambda[1] + part * steps.at(x + 1)];
        }
        let mut patches = contacts.patches.list().iter().peekable();
        let mut slide = T::ZERO;
        let mut touching = self.touching.as_mut().iter_mut().zip(self.multiplier.as_mut()).zip(self.normal.as_mut());
        let found = solution.delta.as_ref().iter().zip(solution.states.as_ref());
        self.touching_count = 0;
        let (mut tangential, mut slips) = (T::ZERO, ContactState::Open);
        for (j, (row, (&delta, &found))) in contacts.rows().iter().zip(found).enumerate() {
            if let Some(patch) = patches.next_if(|patch| patch.rows().start <= j) {
                slide = contacts.slide(patch, solution.delta.as_ref());
            }
            let multiplier = row.multiplier + part * delta;
            if S::RUBS && row.direction == Direction::Tangent {
                // It comes before its normal.
                tangential = multiplier;
                slips = if part == T::one() { found } else { slip::on_the_way(row.state, multiplier) };
            }
            let keeps = part != T::one() || found == ContactState::Closed;
            if row.only_pushes()
                && keeps
                && multiplier > T::ZERO
                && let Some(((sample, slot), normal)) = touching.next()
            {
                (*sample, *slot) = (row.sample, multiplier);
                *normal = turned_by(row.normal, part * (row.tilt + slide * row.curvature));
                if S::RUBS {
                    self.tangential.as_mut().put(self.touching_count, tangential);
                    self.slips.as_mut().put(self.touching_count, slips);
                }
                self.touching_count += 1;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::Row;
    use crate::size::{Blank, Paper};
    use std::boxed::Box;

    #[test]
    fn a_step_that_turns_too_far_is_clipped() {
        let mut increment: Box<Increment<f64, Paper>> = Box::new(Increment::EMPTY);
        increment.largest = 0.5 * CLIP;
        assert_eq!(increment.clip(), 1.0);
        increment.largest = 2.0 * CLIP;
        assert_eq!(increment.clip(), 0.5);
    }

    /// Rows that the law has opened leave the state by a whole step; a clipped one keeps them while they still push.
    #[test]
    fn the_state_keeps_the_rows_that_push() {
        let model: Box<Model<f64, Paper>> = Box::new(Model::EMPTY);
        let mut contacts: Box<Contacts<f64, Paper>> = Box::new(Contacts::EMPTY);
        for (row, (sample, multiplier)) in contacts.rows.iter_mut().zip([(4, 1.0), (5, 2.0), (6, 0.0)]) {
            *row = Row { sample, multiplier, normal: [-1.0, 0.0], ..Row::BLANK };
        }
        contacts.count = 3;
        let mut solution: Box<ContactSolution<f64, Paper>> = Box::new(ContactSolution::EMPTY);
        solution.delta[..3].copy_from_slice(&[-1.0, 0.5, 3.0]);
        solution.states[1..3].fill(ContactState::Closed);
        let increment: Box<Increment<f64, Paper>> = Box::new(Increment::EMPTY);
        let after = |part| {
            let mut state: Box<State<f64, Paper>> = Box::new(State::EMPTY);
            state.add(&model, &contacts, &solution, &increment, part);
            let count = state.touching_count;
            (state.touching[..count].to_vec(), state.multiplier[..count].to_vec())
        };
        assert_eq!(after(1.0), ([5, 6].to_vec(), [2.5, 3.0].to_vec()));
        assert_eq!(after(0.5), ([4, 5, 6].to_vec(), [0.5, 2.25, 1.5].to_vec()));
    }
}
