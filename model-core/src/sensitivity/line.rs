//! Derivatives of whatever can be read off an equilibrium, along a line of fingers, objects and motions.
//!
//! With the residuals' derivative along the line, ∂r/∂p, the border gives the velocity of the whole state, ẋ = −KKT⁻¹ ∂r/∂p: of angles,
//! multipliers and normals. x ± ẋ δ is an equilibrium of p ± δ up to second order, so that the central difference of anything read
//! there, y(x ± ẋ δ, p ± δ), is its derivative up to the same order (75): strains, which follow from the state, and derivatives of the force, which
//! follow from it by another factorisation. No equilibrium is sought anew.

use super::border::{self, Layout};
use super::design::{gather, residuals, take_rows};
use super::quarter;
use crate::contact::{Direction, sample_gap};
use crate::design::Design;
use crate::discretise::Discretisation;
use crate::equilibrium::{Follower, Parts};
use crate::object::{Motion, Object, Shape};
use crate::real::Real;
use crate::size::Size;
use crate::state::State;

/// One end of a line: a finger, an object and a motion, all a little way from those of an equilibrium.
#[derive(Clone, Copy, Debug)]
pub struct Side<'a, O> {
    /// The finger.
    pub design: &'a Design,
    /// The object, world frame.
    pub object: O,
    /// The motion.
    pub motion: Motion,
}

/// Room for the finger at both ends of a line.
pub struct Neighbours<T: Real, S: Size, O: Object<T> = Shape<T>> {
    /// At the lower and at the upper end.
    sides: [Follower<T, S, O>; 2],
    velocity: State<T, S>,
}

impl<T: Real, S: Size, O: Object<T>> Neighbours<T, S, O> {
    /// Before its first use.
    pub const EMPTY: Self = Self { sides: [Follower::EMPTY, Follower::EMPTY], velocity: State::EMPTY };
}

impl<T: Real, S: Size, O: Object<T>> Follower<T, S, O> {
    /// Derivatives along a line, per unit of its coordinate p, of what `read` reads off a follower, at the last accepted equilibrium. `sides`
    /// are those at p − `step` and p + `step`, where p is what the follower was configured with, by `how`: a finger whose model is of the
    /// same size, an object of the same kind, a motion. The touching samples stay the same.
    ///
    /// In `f64` a step of 5e-5 of the parameter's size leaves forces, strains and stiffness within 1e-5: stiff contacts magnify the rounding of
    /// a smaller one.
    ///
    /// `None` if there is no equilibrium, no room for two rows per touching sample, friction or memory, no model of the same size for one
    /// of the sides, or if `read` finds nothing; zero without contact.
    pub fn derivative_along<const N: usize>(
        &mut self,
        neighbours: &mut Neighbours<T, S, O>,
        sides: [Side<'_, O>; 2],
        how: &Discretisation,
        step: f64,
        read: impl Fn(&mut Self) -> Option<[T; N]>,
    ) -> Option<[T; N]> {
        if !self.has_equilibrium() || self.rubs() || self.remembers() {
            return None;
        }
        if self.solution().touching() == 0 {
            return Some([T::ZERO; N]);
        }
        for (beside, side) in neighbours.sides.iter_mut().zip(sides) {
            if !beside.stand_beside(self, (side.design, how), side.object, side.motion) {
                return None;
            }
        }
        let found = self.find_velocity(neighbours, step);
        self.show_accepted();
        found?;
        let Neighbours { sides: [below, above], velocity } = neighbours;
        let step = T::of(step);
        below.go_beside(self, velocity, -step);
        above.go_beside(self, velocity, step);
        let (below, above) = (read(below)?, read(above)?);
        let inverse = T::one() / (step + step);
        Some(core::array::from_fn(|i| inverse * (above[i] - below[i])))
    }

    /// Finds the velocity along the line that the neighbours are at, and leaves its residuals in the workspace; `None` if there is too
    /// little room.
    fn find_velocity(&mut self, neighbours: &mut Neighbours<T, S, O>, step: f64) -> Option<()> {
        self.complete_tangent();
        let layout = {
            let Parts { model, work, .. } = self.parts();
            border::widen(model, work, usize::MAX)?
        };
        let is_whole = layout.is_whole() && neighbours.velocity.fit(self.parts().model);
        if is_whole {
            let Neighbours { sides: [below, above], velocity } = neighbours;
            self.differ_beside(above, layout, T::of(0.5 / step), true);
            self.differ_beside(below, layout, T::of(-0.5 / step), false);
            let mut parts = self.parts();
            border::factorise(&mut parts, layout);
            border::velocity(&mut parts, layout, velocity);
        }
        let Parts { work, .. } = self.parts();
        border::narrow(work, layout);
        is_whole.then_some(())
    }

    /// Adds `part` of a neighbour's residuals at the accepted state to the workspace's, or puts it in their place.
    fn differ_beside(&mut self, beside: &mut Self, layout: Layout, part: T, is_first: bool) {
        let object = beside.seen(T::of(self.solution().coordinate()));
        let (state, Parts { model, work, .. }) = self.state_and_parts();
        let Parts { model: other, work: found, .. } = beside.parts();
        take_rows(other, found, work, layout);
        residuals(other, found, state);
        gather(model, work, found, part, is_first);
        for j in 0..layout.rows() {
            let Some(&row) = work.contacts.rows.as_ref().get(j) else { return };
            let place = other.place(row.sample);
            let gap = sample_gap(&object, &place, found.kinematics.position(other, &place));
            let error = if row.direction == Direction::Turning {
                // By how much the normal turns, as a way along an object that stays where it is: (43).
                let Some(normal) = j.checked_sub(1).and_then(|gap| work.contacts.rows.as_ref().get(gap)) else {
                    return;
                };
                let (n, t) = (normal.normal, quarter(normal.normal));
                let scale = row.normal[0] * t[0] + row.normal[1] * t[1];
                scale * (n[0] * gap.normal.y - n[1] * gap.normal.x) / row.curvature
            } else {
                gap.distance + other.contact_softness() * row.multiplier
            };
            // A row's right-hand side is −gap − softness · multiplier.
            let before = if is_first { -(row.softness * row.multiplier) } else { row.gap };
            if let Some(row) = work.contacts.rows.as_mut().get_mut(j) {
                row.gap = before + part * error;
            }
        }
    }
}
