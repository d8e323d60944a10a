//! What can be read off an equilibrium: forces, torque, energy, contacts; in files beside this one its shape, strains and reactions.
//!
//! Shapes are in the finger frame, mm; forces act on the object, N. [`Solution::to_world`] turns points into the world frame.

mod reactions;
mod rib_load;
mod rungs;
mod shape;
mod strains;

use crate::contact::{Contact, ContactState, Direction, SlipState};
use crate::model::{Model, vec2_of};
use crate::newton::gaps::Contacts;
use crate::newton::kinematics::Kinematics;
use crate::newton::slip::Slip;
use crate::object::{Displacement, Motion};
use crate::real::{Real, Vec2, cross, vec2};
use crate::size::Size;
use crate::state::State;
pub use rib_load::{LoadedRib, NEAR_BUCKLING};
pub use strains::{Place, Strain};

/// The forces of an equilibrium, N and N·mm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Reading<T> {
    /// Force on the object, world frame.
    pub force: [T; 2],
    /// Sum of the normal forces.
    pub normal: T,
    /// Torque that the contact demands of the motor; of a translated base the force against its motion.
    pub torque: T,
}

impl<T: Real> Reading<T> {
    /// None of it is infinite, or not a number.
    pub(crate) fn is_finite(&self) -> bool {
        (self.force[0] + self.force[1] + self.torque + self.normal).is_finite()
    }
}

/// An equilibrium, to be read: what [`Follower::solution`](crate::equilibrium::Follower::solution) borrows of the follower.
///
/// It is that of the coordinate accepted last; the undeformed finger's before the first.
pub struct Solution<'a, T: Real, S: Size> {
    pub(crate) model: &'a Model<T, S>,
    pub(crate) state: &'a State<T, S>,
    pub(crate) kinematics: &'a Kinematics<T, S>,
    pub(crate) rows: &'a Contacts<T, S>,
    pub(crate) slip: &'a Slip<T, S>,
    pub(crate) motion: Motion,
    pub(crate) coordinate: T,
    /// Smallest distance to the object over all samples, in the finger's units.
    pub(crate) nearest: T,
}

impl<T: Real, S: Size> Clone for Solution<'_, T, S> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T: Real, S: Size> Copy for Solution<'_, T, S> {}

impl<'a, T: Real, S: Size> Solution<'a, T, S> {
    /// Coordinate of the motion, rad or mm.
    pub fn coordinate(self) -> f64 {
        self.coordinate.to_f64()
    }

    /// Number of samples that touch.
    pub fn touching(self) -> usize {
        self.state.touching_count
    }

    /// Smallest distance to the object over all samples, mm; slightly negative in contact (softness).
    pub fn distance(self) -> T {
        self.nearest * self.model.units.length
    }

    /// From the world frame into the finger's.
    pub(crate) fn displacement(self) -> Displacement<T> {
        self.motion.world_to_finger(self.coordinate)
    }

    /// Force of the finger on the object in the finger frame, N.
    pub fn force_finger(self) -> [T; 2] {
        let mut force = [T::ZERO; 2];
        for contact in self.contacts() {
            let [x, y] = contact.on_object();
            force = [force[0] + x, force[1] + y];
        }
        force
    }

    /// Force of the finger on the object in the world frame, N.
    pub fn force_world(self) -> [T; 2] {
        let f = self.force_finger();
        let world = self.displacement().vector_back(Vec2::new(f[0], f[1]));
        [world.x, world.y]
    }

    /// Torque that the contact demands of the motor, N·mm: τ = −((C − M) × F)_z, positive when the motor must push to
    /// close. For a translated base: the force against its motion, N.
    pub fn motor_torque(self) -> T {
        match self.motion {
            Motion::Rotating { axis } => {
                let m = vec2::<T>(axis);
                let mut torque = T::ZERO;
                for contact in self.contacts() {
                    let arm = Vec2::new(contact.position[0], contact.position[1]) - m;
                    torque -= cross(arm, vec2_of(contact.on_object()));
                }
                torque
            }
            Motion::Translating { direction } => {
                let f = self.force_world();
                let d = vec2::<T>(direction);
                f[0] * d.x + f[1] * d.y
            }
        }
    }

    /// Its forces in one.
    pub(crate) fn reading(self) -> Reading<T> {
        let normal = self.contacts().fold(T::ZERO, |sum, contact| sum + contact.force);
        Reading { force: self.force_world(), normal, torque: self.motor_torque() }
    }

    /// Elastic energy V (without the contact term), N·mm.
    pub fn energy(self) -> T {
        let energy = self.state.bending_energy(self.model) + self.kinematics.energy(self.model, self.rows.rows());
        energy * self.model.units.moment()
    }

    /// Elastic energy with the contact's softness, V + ½ ε_c Σ μ² + ½ Σ ε_t τ², N·mm: without friction what torque and force are derivatives of.
    pub fn potential(self) -> T {
        let units = &self.model.units;
        let half = T::of(0.5) * self.model.contact_softness() * units.length / units.force;
        let stored = self.contacts().fold(self.energy(), |sum, contact| sum + half * contact.force * contact.force);
        if !self.rubs() {
            return stored;
        }
        let unit = T::of(0.5) * units.moment();
        let along = self.rows.rows().iter().filter(|row| row.direction == Direction::Tangent);
        along.fold(stored, |sum, row| sum + unit * row.softness * row.multiplier * row.multiplier)
    }

    /// There is friction.
    fn rubs(self) -> bool {
        self.slip.rubs()
    }

    /// Energy that friction has dissipated since the path began, N·mm, however often the hand was open since: with the potential it is the
    /// work that the path has taken.
    pub fn dissipated(self) -> T {
        self.slip.dissipated * self.model.units.moment()
    }

    /// Touching samples, base to tip, finger frame.
    pub fn contacts(self) -> impl Iterator<Item = Contact<T>> + 'a {
        let rows = self.rows.rows();
        rows.iter().enumerate().filter(|(_, row)| row.touches()).map(|(j, row)| {
            let tangent = j.checked_sub(1).filter(|_| S::RUBS).and_then(|before| rows.get(before));
            let tangent = tangent.filter(|row| row.direction == Direction::Tangent);
            let sample = &row.place;
            let centre = self.kinematics.position(self.model, sample);
            let units = &self.model.units;
            Contact {
                arc: sample.arc * units.length,
                position: units.millimetres([
                    centre.x - sample.half_thickness * row.normal[0],
                    centre.y - sample.half_thickness * row.normal[1],
                ]),
                normal: row.normal,
                force: row.multiplier * units.force,
                tangential: tangent.map_or(T::ZERO, |row| row.multiplier * units.force),
                slip: tangent.and_then(|row| match row.state {
                    ContactState::Stick => Some(SlipState::Stick),
                    ContactState::SlipUp => Some(SlipState::Up),
                    ContactState::SlipDown => Some(SlipState::Down),
                    ContactState::Open | ContactState::Closed => None,
                }),
            }
        })
    }

    /// Force (N, world frame) on the object and its moment (N·mm, counter-clockwise) about a point (mm, world frame).
    pub fn wrench(self, about: [T; 2]) -> [T; 3] {
        let pivot = self.displacement().point(Vec2::new(about[0], about[1]));
        let mut moment = T::ZERO;
        for contact in self.contacts() {
            let arm = [contact.position[0] - pivot.x, contact.position[1] - pivot.y];
            moment -= contact.force * (arm[0] * contact.normal[1] - arm[1] * contact.normal[0]);
            moment += contact.tangential * (arm[0] * contact.normal[0] + arm[1] * contact.normal[1]);
        }
        let [x, y] = self.force_world();
        [x, y, moment]
    }
}
