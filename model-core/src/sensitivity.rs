//! How the force changes with the motion and the object: the implicit function theorem on the factorised KKT.
//!
//! With the interior, the joints and the closures condensed, a change of the object enters through the contact border
//! only. Each touching sample has two rows there: its gap, n·dP + ε_c dμ = n·dC (+ dr), and the turning of its normal,
//! t·dP − ν/(μκ) = t·dC, where ν t is the change of the force by the turn and κ the curvature of the object's level line.
//! The second row is the contact curvature −μκ ttᵀ that the Newton step may leave out and a derivative may not.

use crate::contact::Row;
use crate::equilibrium::Follower;
use crate::newton::condense::Diagonal;
use crate::newton::{active_set, step};
use crate::object::Motion;
use crate::real::{Real, Vec2, vec2};
use crate::size::Size;

/// Derivatives of the force of the finger on the object (world frame, N).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensitivity<T> {
    /// With the motion's coordinate: N/rad of a motor angle, N/mm of a distance.
    pub coordinate: [T; 2],
    /// With the object's centre, world frame, N/mm: `centre[i]` is the derivative with respect to its i-th coordinate.
    pub centre: [[T; 2]; 2],
    /// With the object's radius, N/mm.
    pub radius: [T; 2],
    /// With Young's modulus, N/MPa: the force is proportional to it (a contact softness scaled with 1/E).
    pub youngs_modulus: [T; 2],
}

impl<T: Real, S: Size> Follower<T, S> {
    /// Derivatives at the last accepted equilibrium, the touching samples staying the same.
    ///
    /// `None` if the border has no room for two rows per touching sample, or there is no equilibrium; zero without
    /// contact.
    pub fn sensitivity(&mut self) -> Option<Sensitivity<T>> {
        let zero = [T::ZERO; 2];
        let mut result = Sensitivity { coordinate: zero, centre: [zero; 2], radius: zero, youngs_modulus: zero };
        if !self.has_equilibrium() {
            return None;
        }
        if self.touching() == 0 {
            return Some(result);
        }
        let force = self.force_finger();
        let world = self.force_world();
        let modulus = self.youngs_modulus();
        result.youngs_modulus = world.map(|f| f / modulus);
        let answer = self.border_derivatives(&mut result, force);
        self.show_accepted();
        answer.then_some(result)
    }

    fn border_derivatives(&mut self, result: &mut Sensitivity<T>, force: [T; 2]) -> bool {
        let displacement = self.displacement();
        let centre = displacement.point(self.object.centre);
        // Velocity of the object's centre in the finger frame, per unit of the coordinate.
        let drift = match self.motion {
            Motion::Rotating { axis } => {
                let arm = centre - vec2::<T>(axis);
                Vec2::new(-arm.y, arm.x)
            }
            Motion::Translating { direction } => -vec2::<T>(direction),
        };
        let Parts { ladder, work } = self.parts();
        // Two rows per touching sample: gap and turning of the normal.
        let count = work.row_count;
        let mut touching = 0;
        for j in 0..count {
            let row = work.rows.as_ref()[j];
            if row.multiplier > T::ZERO {
                work.rows.as_mut()[touching] = row;
                touching += 1;
            }
        }
        if 2 * touching > S::CONTACTS {
            return false;
        }
        for j in (0..touching).rev() {
            let row = work.rows.as_ref()[j];
            let turning = Row {
                normal: [-row.normal[1], row.normal[0]],
                softness: -T::one() / (row.multiplier * row.curvature).max(T::EPSILON),
                ..row
            };
            work.rows.as_mut()[2 * j] = row;
            work.rows.as_mut()[2 * j + 1] = turning;
        }
        let rows = 2 * touching;
        work.row_count = rows;
        step::factorise(ladder, work, Diagonal { curvature: T::one(), shift: T::ZERO });
        work.factored.as_mut().copy_from_slice(work.flexibility.as_ref());
        active_set::factorise(work.factored.as_mut(), rows, S::CONTACTS, work.order.as_mut());

        // Change of the force on the object, finger frame, for a drift of the centre and a growth of the radius.
        let mut change = |drift: Vec2<T>, growth: T| {
            for j in 0..rows {
                let row = &work.rows.as_ref()[j];
                let along = row.normal[0] * drift.x + row.normal[1] * drift.y;
                work.row_delta.as_mut()[j] = if j % 2 == 0 { along + growth } else { along };
            }
            let (x, y) = (work.row_delta.as_mut(), work.spare.as_mut());
            active_set::solve(work.factored.as_ref(), rows, S::CONTACTS, work.order.as_ref(), x, y);
            let mut sum = Vec2::new(T::ZERO, T::ZERO);
            for j in 0..rows {
                let row = &work.rows.as_ref()[j];
                sum.x -= x[j] * row.normal[0];
                sum.y -= x[j] * row.normal[1];
            }
            sum
        };
        let one = T::one();
        let mut along = change(drift, T::ZERO);
        let x = change(displacement.vector(Vec2::new(one, T::ZERO)), T::ZERO);
        let y = change(displacement.vector(Vec2::new(T::ZERO, one)), T::ZERO);
        let radius = change(Vec2::new(T::ZERO, T::ZERO), one);
        if let Motion::Rotating { .. } = self.motion {
            // The world frame turns against the finger's.
            along -= Vec2::new(-force[1], force[0]);
        }
        let world = |v: Vec2<T>| {
            let w = displacement.vector_back(v);
            [w.x, w.y]
        };
        result.coordinate = world(along);
        result.centre = [world(x), world(y)];
        result.radius = world(radius);
        true
    }
}

/// The follower's parts that a derivative needs.
pub(crate) struct Parts<'a, T: Real, S: Size> {
    pub ladder: &'a crate::ladder::Ladder<T, S>,
    pub work: &'a mut crate::newton::Workspace<T, S>,
}
