//! How the force changes with the motion and the object: the implicit function theorem on the factorised KKT.
//!
//! With the interior, the joints and the closures condensed, a change of the object enters through the contact border
//! only. Where the object moves with the velocity v at the sample and turns at the rate ω, each touching sample has two rows
//! there: its gap, n·dP + ε_c dμ = n·v (+ dr), and the turning of its normal, t·dP − (ν − μω)/(μκ) = t·v, where ν t is the
//! change of the force by the turn and κ the curvature of the object's level line. The second row is the contact curvature
//! −μκ ttᵀ that the Newton step may leave out and a derivative may not. On a flat face κ is 0: so that nothing is divided by
//! it, the unknown of that row is ν̂ = (ν − μω)/√(μκ), and what is known of the force, μω, goes to the right-hand sides.

use crate::contact::Row;
use crate::equilibrium::Follower;
use crate::newton::condense::Diagonal;
use crate::newton::{active_set, gaps, step};
use crate::object::{Motion, Object};
use crate::real::{Real, Vec2, vec2};
use crate::size::Size;

/// Derivatives of the force of the finger on the object (world frame, N).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensitivity<T> {
    /// With the motion's coordinate: N/rad of a motor angle, N/mm of a distance.
    pub coordinate: [T; 2],
    /// With the object's centre, world frame, N/mm: `centre[i]` is the derivative with respect to its i-th coordinate.
    pub centre: [[T; 2]; 2],
    /// With the object's radius, N/mm; for shapes other than circles, with the growth of their outline on all sides.
    pub radius: [T; 2],
    /// With Young's modulus, N/MPa: the force is proportional to it (a contact softness scaled with 1/E).
    pub youngs_modulus: [T; 2],
}

impl<T: Real, S: Size, O: Object<T>> Follower<T, S, O> {
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
        let one = T::one();
        // The object's motion in the finger frame, per unit of the coordinate.
        let drift = match self.motion {
            Motion::Rotating { axis } => Drift::turning(one, vec2(axis)),
            Motion::Translating { direction } => Drift::along(-vec2::<T>(direction)),
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
            let turning = Row { normal: [-row.normal[1], row.normal[0]], softness: T::ZERO, ..row };
            work.rows.as_mut()[2 * j] = row;
            work.rows.as_mut()[2 * j + 1] = turning;
        }
        let rows = 2 * touching;
        work.row_count = rows;
        step::factorise(ladder, work, Diagonal { curvature: T::one(), shift: T::ZERO });
        for i in 0..rows {
            for j in 0..rows {
                let at = i * S::CONTACTS + j;
                let scaled =
                    weight(work.rows.as_ref(), i) * weight(work.rows.as_ref(), j) * work.flexibility.as_ref()[at];
                work.factored.as_mut()[at] = if i == j && i % 2 == 1 { scaled - one } else { scaled };
            }
        }
        active_set::factorise(work.factored.as_mut(), rows, S::CONTACTS, work.order.as_mut());

        // Change of the force on the object, finger frame, for a motion of the object and a growth of its outline.
        let mut change = |drift: Drift<T>, growth: T| {
            for i in 0..rows {
                let row = work.rows.as_ref()[i];
                let place = gaps::sample_position(ladder, work, &ladder.samples.as_ref()[usize::from(row.sample)]);
                let v = drift.at(place);
                let mut value = row.normal[0] * v.x + row.normal[1] * v.y;
                if i % 2 == 0 {
                    value += growth;
                }
                for j in (1..rows).step_by(2) {
                    let known = work.rows.as_ref()[j].multiplier * drift.turn;
                    value -= work.flexibility.as_ref()[i * S::CONTACTS + j] * known;
                }
                work.row_delta.as_mut()[i] = weight(work.rows.as_ref(), i) * value;
            }
            let (x, y) = (work.row_delta.as_mut(), work.spare.as_mut());
            active_set::solve(work.factored.as_ref(), rows, S::CONTACTS, work.order.as_ref(), x, y);
            let mut sum = Vec2::new(T::ZERO, T::ZERO);
            for j in 0..rows {
                let row = &work.rows.as_ref()[j];
                let known = if j % 2 == 0 { T::ZERO } else { row.multiplier * drift.turn };
                let force = weight(work.rows.as_ref(), j) * x[j] + known;
                sum.x -= force * row.normal[0];
                sum.y -= force * row.normal[1];
            }
            sum
        };
        let mut along = change(drift, T::ZERO);
        let x = change(Drift::along(displacement.vector(Vec2::new(one, T::ZERO))), T::ZERO);
        let y = change(Drift::along(displacement.vector(Vec2::new(T::ZERO, one))), T::ZERO);
        let radius = change(Drift::along(Vec2::new(T::ZERO, T::ZERO)), one);
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

/// How fast the object moves in the finger frame.
#[derive(Clone, Copy)]
struct Drift<T: Real> {
    /// Velocity of the object's point at the origin, mm per unit.
    velocity: Vec2<T>,
    /// Rate ω at which it turns, counter-clockwise, rad per unit.
    turn: T,
}

impl<T: Real> Drift<T> {
    /// Without a turn.
    fn along(velocity: Vec2<T>) -> Self {
        Self { velocity, turn: T::ZERO }
    }

    /// About a point.
    fn turning(turn: T, centre: Vec2<T>) -> Self {
        Self { velocity: Vec2::new(turn * centre.y, -turn * centre.x), turn }
    }

    /// Velocity v of the object's point at a place.
    fn at(&self, place: Vec2<T>) -> Vec2<T> {
        self.velocity + Vec2::new(-self.turn * place.y, self.turn * place.x)
    }
}

/// What a row is multiplied with: 1 for a gap, √(μκ) for the turning of its normal.
fn weight<T: Real>(rows: &[Row<T>], index: usize) -> T {
    let row = &rows[index];
    if index.is_multiple_of(2) { T::one() } else { (row.multiplier * row.curvature).max(T::ZERO).sqrt() }
}

/// The follower's parts that a derivative needs.
pub(crate) struct Parts<'a, T: Real, S: Size> {
    pub ladder: &'a crate::ladder::Ladder<T, S>,
    pub work: &'a mut crate::newton::Workspace<T, S>,
}
