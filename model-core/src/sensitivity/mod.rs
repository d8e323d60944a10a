//! How what is read off an equilibrium changes with the motion, the object and the design: the implicit function theorem
//! on the factorised KKT.
//!
//! With the interior, the joints and the closures condensed, a change of the object enters through the contact border
//! only (`border`); a change of the design shifts every residual and is one more right-hand side (`design`). With the velocity of the
//! whole state, everything that can be read off an equilibrium has a derivative along any line of cases (`line`).
//!
//! All derivatives are taken with the touching samples staying the same. Where a sample comes into contact or leaves it the
//! force has a kink: there they hold on the side of the present set.

mod border;
mod design;
mod line;
#[cfg(test)]
mod line_tests;
#[cfg(test)]
mod tests;

use crate::equilibrium::{Follower, Parts};
use crate::object::{Motion, Object};
use crate::real::{Real, Vec2, vec2};
use crate::size::Size;
use border::{Cause, Response};
pub use design::{DesignParameter, Probe};
pub use line::{Neighbours, Side};

/// Derivative of what is read off an equilibrium, per unit of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Derivative<T> {
    /// Of the force of the finger on the object, world frame, N.
    pub force: [T; 2],
    /// Of the torque that the contact demands of the motor, N·mm (of a translated base: of the force against its motion, N).
    pub torque: T,
    /// Of the contact centre (mean of the touching surface points, weighted by force), world frame, mm.
    pub contact_centre: [T; 2],
}

impl<T: Real> Derivative<T> {
    const ZERO: Self = Self { force: [T::ZERO; 2], torque: T::ZERO, contact_centre: [T::ZERO; 2] };

    fn add(&mut self, part: T, other: &Self) {
        for i in 0..2 {
            self.force[i] += part * other.force[i];
            self.contact_centre[i] += part * other.contact_centre[i];
        }
        self.torque += part * other.torque;
    }
}

/// Derivatives with respect to what needs the contact border only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensitivity<T> {
    /// With the motion's coordinate: per rad of a motor angle, per mm of a distance.
    pub coordinate: Derivative<T>,
    /// With the object's place, world frame, per mm: `centre[i]` belongs to its i-th coordinate.
    pub centre: [Derivative<T>; 2],
    /// With the object's radius (an offset of its surface), per mm.
    pub radius: Derivative<T>,
    /// With Young's modulus, per MPa; a contact softness that was set in mm/N stays the same.
    pub youngs_modulus: Derivative<T>,
    /// With the motor axis (finger frame, base and object staying where they are at angle 0), per mm: `axis[i]` belongs to
    /// its i-th coordinate. Zero for a translated base.
    pub axis: [Derivative<T>; 2],
}

impl<T: Real> Sensitivity<T> {
    const ZERO: Self = Self {
        coordinate: Derivative::ZERO,
        centre: [Derivative::ZERO; 2],
        radius: Derivative::ZERO,
        youngs_modulus: Derivative::ZERO,
        axis: [Derivative::ZERO; 2],
    };
}

impl<T: Real, S: Size, O: Object<T>> Follower<T, S, O> {
    /// Derivatives at the last accepted equilibrium, by one factorisation with two contact rows per touching sample: within 1e-5 in
    /// `f64`. Where there is room for fewer rows ([`Size::CONTACTS`]), neighbours share the second one: within 3 % of the force's.
    ///
    /// `None` if there is no room for a single one of those, with friction, or without an equilibrium; zero without contact.
    pub fn sensitivity(&mut self) -> Option<Sensitivity<T>> {
        self.derive(false)
    }

    /// The same on the last step's factorisation where that is near: for a part of the cost, as exact as the state was near
    /// ([`crate::equilibrium::NEAR_ENOUGH`]).
    pub(crate) fn sensitivity_of_step(&mut self) -> Option<Sensitivity<T>> {
        self.derive(true)
    }

    fn derive(&mut self, is_rough: bool) -> Option<Sensitivity<T>> {
        if !self.has_equilibrium() {
            return None;
        }
        let mut result = Sensitivity::ZERO;
        if self.solution().touching() == 0 {
            return Some(result);
        }
        if self.rubs() {
            return None;
        }
        self.complete_tangent();
        let frame = self.frame();
        let motion = self.motion;
        let keeps = is_rough && self.is_factored();
        let mut parts = self.parts();
        let layout = border::widen(parts.model, parts.work, if is_rough { border::FEW } else { usize::MAX })?;
        if keeps {
            border::keep(&mut parts, layout);
        } else {
            parts.work.effort.solves();
            border::factorise(&mut parts, layout);
        }
        let Parts { model, work, .. } = parts;
        let mut derivative =
            |cause: Cause<T>| frame.derivative(&border::respond(model, work, layout, &cause, |_| T::ZERO, frame.axis));

        let (one, zero) = (T::one(), [T::ZERO; 2]);
        for (i, unit) in [Vec2::new(one, T::ZERO), Vec2::new(T::ZERO, one)].into_iter().enumerate() {
            let shift = frame.displacement.vector(unit);
            result.centre[i] = derivative(Cause { shift: [shift.x, shift.y], ..Cause::NONE });
        }
        result.radius = derivative(Cause { growth: one, ..Cause::NONE });
        match motion {
            Motion::Rotating { .. } => {
                result.coordinate = derivative(Cause { turn: one, pivot: frame.axis, ..Cause::NONE });
                for i in 0..2 {
                    result.axis[i] = frame.along_axis(&result.centre, i);
                }
            }
            Motion::Translating { direction } => {
                // The base moves forth as the object would move back.
                for (part, centre) in direction.iter().zip(&result.centre) {
                    result.coordinate.add(-T::of(*part), centre);
                }
                for i in 0..2 {
                    result.coordinate.contact_centre[i] += T::of(direction[i]);
                }
            }
        }
        // The force is E·f(E ε_c), the shape depends on E ε_c only; the beam's own softness goes with 1/E.
        let inverse = one / frame.youngs_modulus;
        let softness = model.contact_softness() * model.units.length / model.units.force;
        if !model.softness_follows() {
            result.youngs_modulus.add(inverse * softness, &derivative(Cause { softening: one, ..Cause::NONE }));
        }
        result
            .youngs_modulus
            .add(inverse, &Derivative { force: frame.force, torque: frame.torque, contact_centre: zero });
        border::narrow(work, layout);
        Some(result)
    }

    /// How force and moment on the object change when the object moves: `stiffness[i][k]` is the derivative of component i (x and
    /// y of the force, N, and its moment about a point of the object, N·mm, counter-clockwise) with the object's shift in x and
    /// y (mm) and its turn about that point (rad, counter-clockwise). World frame; symmetric, negative where the finger
    /// holds against the motion: the second derivative of the elastic energy with its sign changed.
    ///
    /// `None` and zero as for [`Self::sensitivity`].
    pub fn object_stiffness(&mut self, point: [T; 2]) -> Option<[[T; 3]; 3]> {
        if !self.has_equilibrium() {
            return None;
        }
        let mut stiffness = [[T::ZERO; 3]; 3];
        if self.solution().touching() == 0 {
            return Some(stiffness);
        }
        if self.rubs() {
            return None;
        }
        self.complete_tangent();
        let frame = self.frame();
        let pivot = frame.displacement.point(Vec2::new(point[0], point[1]));
        let pivot = [pivot.x, pivot.y];
        let mut parts = self.parts();
        let layout = border::widen(parts.model, parts.work, usize::MAX)?;
        parts.work.effort.solves();
        border::factorise(&mut parts, layout);
        let Parts { model, work, .. } = parts;
        let (one, zero) = (T::one(), T::ZERO);
        for (k, unit) in [Vec2::new(one, zero), Vec2::new(zero, one), Vec2::new(zero, zero)].into_iter().enumerate() {
            let shift = frame.displacement.vector(unit);
            let shift = [shift.x, shift.y];
            let turn = if k == 2 { one } else { zero };
            let cause = Cause { shift, turn, pivot, ..Cause::NONE };
            let response = border::respond(model, work, layout, &cause, |_| T::ZERO, pivot);
            let [x, y] = frame.to_world(response.force_change);
            // The point goes with the object: the moment about it changes by that of the force at its old place.
            let [fx, fy] = frame.force_finger;
            let moment = -response.moment_change - (shift[0] * fy - shift[1] * fx);
            for (row, value) in stiffness.iter_mut().zip([x, y, moment]) {
                row[k] = value;
            }
        }
        border::narrow(work, layout);
        Some(stiffness)
    }

    fn frame(&self) -> Frame<T> {
        let solution = self.solution();
        Frame {
            displacement: self.displacement(),
            motion: self.motion,
            axis: match self.motion {
                Motion::Rotating { axis } => axis.map(T::of),
                Motion::Translating { .. } => [T::ZERO; 2],
            },
            force: solution.force_world(),
            force_finger: solution.force_finger(),
            torque: solution.motor_torque(),
            youngs_modulus: self.youngs_modulus(),
        }
    }
}

/// The equilibrium's frame and forces.
#[derive(Clone, Copy)]
struct Frame<T: Real> {
    displacement: crate::object::Displacement<T>,
    motion: Motion,
    /// Motor axis; zero for a translated base.
    axis: [T; 2],
    force: [T; 2],
    force_finger: [T; 2],
    torque: T,
    youngs_modulus: T,
}

/// e_z × v.
#[inline]
fn quarter<T: Real>(v: [T; 2]) -> [T; 2] {
    [-v[1], v[0]]
}

impl<T: Real> Frame<T> {
    fn to_world(self, v: [T; 2]) -> [T; 2] {
        let w = self.displacement.vector_back(Vec2::new(v[0], v[1]));
        [w.x, w.y]
    }

    /// From the finger frame's changes to the world's: where the motor turns, the world turns against the finger.
    fn derivative(&self, response: &Response<T>) -> Derivative<T> {
        let turn = response.turn;
        let turned = |change: [T; 2], vector: [T; 2]| {
            let q = quarter(vector);
            self.to_world([change[0] - turn * q[0], change[1] - turn * q[1]])
        };
        let arm = [response.centre[0] - self.axis[0], response.centre[1] - self.axis[1]];
        let force = turned(response.force_change, self.force_finger);
        Derivative {
            force,
            torque: match self.motion {
                Motion::Rotating { .. } => response.moment_change,
                Motion::Translating { direction } => {
                    let d = vec2::<T>(direction);
                    force[0] * d.x + force[1] * d.y
                }
            },
            contact_centre: turned(response.centre_change, arm),
        }
    }

    /// Moving the motor axis by e_i moves the object, as the finger sees it at this angle, by e_i less its turned image.
    fn along_axis(&self, centre: &[Derivative<T>; 2], i: usize) -> Derivative<T> {
        let mut unit = [T::ZERO; 2];
        unit[i] = T::one();
        let image = self.to_world(unit);
        let mut derivative = Derivative::ZERO;
        for k in 0..2 {
            derivative.add(image[k] - unit[k], &centre[k]);
            derivative.contact_centre[k] += unit[k] - image[k];
        }
        let [x, y] = self.force_finger;
        derivative.torque += unit[0] * y - unit[1] * x;
        derivative
    }
}
