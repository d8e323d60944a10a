//! Friction at a place: what of the contact's force is along the object, and what that has cost.

use model_core::equilibrium::{Follower, SlipWay};
use model_core::real::Real;
use model_core::size::Size;
use serde::{Deserialize, Serialize};

/// Friction of all touching samples together.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Friction {
    /// Coulomb's coefficient.
    pub coefficient: f64,
    /// Sum of the normal forces, N.
    pub normal_n: f64,
    /// Sum of the tangential forces, N; positive where the object pulls the finger towards its tip, as it does while a finger closes.
    pub tangential_n: f64,
    /// Sum of the tangential forces' magnitudes over coefficient times normal forces: 1 where everything slips; 0 without contact.
    pub mobilised: f64,
    /// Energy that friction has dissipated since the path began, N·mm.
    pub dissipated_nmm: f64,
}

impl Friction {
    /// What a follower is at.
    pub fn of<T: Real, S: Size>(follower: &Follower<T, S>) -> Self {
        let solution = follower.solution();
        let coefficient = follower.friction().to_f64();
        let (mut normal_n, mut tangential_n, mut magnitude) = (0.0, 0.0, 0.0);
        for contact in solution.contacts() {
            let along = contact.tangential.to_f64();
            normal_n += contact.force.to_f64();
            tangential_n += along;
            magnitude += along.abs();
        }
        let cone = coefficient * normal_n;
        let mobilised = if cone > 0.0 { magnitude / cone } else { 0.0 };
        Self { coefficient, normal_n, tangential_n, mobilised, dissipated_nmm: solution.dissipated().to_f64() + 0.0 }
    }
}

/// Between which values the forces of a place lie if it is unknown how the finger came there: those of closing slip and of opening slip,
/// and of what the case itself has come to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ForceInterval {
    /// Sum of the normal forces, N.
    pub normal: [f64; 2],
    /// Magnitude of the force, N. The smallest is that of the normal forces alone.
    pub magnitude: [f64; 2],
    /// Torque that the contact demands of the motor, N·mm; of a translated base a force, N.
    pub torque_nmm: [f64; 2],
}

impl ForceInterval {
    /// The ways of slip between which a past lies.
    pub const WAYS: [SlipWay; 2] = [SlipWay::Closing, SlipWay::Opening];

    /// What lies between three followers at the same place: the case's own, and those on which everything slips one way.
    pub fn over<T: Real, S: Size>(followers: [&Follower<T, S>; 3]) -> Self {
        let mut found = Self { normal: [0.0; 2], magnitude: [0.0; 2], torque_nmm: [0.0; 2] };
        for (index, follower) in followers.into_iter().enumerate() {
            let (mut sum, mut push) = (0.0, [0.0; 2]);
            let solution = follower.solution();
            for contact in solution.contacts() {
                let force = contact.force.to_f64();
                sum += force;
                push = [0, 1].map(|i| push[i] + force * contact.normal[i].to_f64());
            }
            let [x, y] = solution.force_world().map(T::to_f64);
            let (whole, normal) = (x.hypot(y), push[0].hypot(push[1]));
            let torque = solution.motor_torque().to_f64() + 0.0;
            for (range, [low, high]) in [
                (&mut found.normal, [sum; 2]),
                (&mut found.magnitude, [whole.min(normal), whole]),
                (&mut found.torque_nmm, [torque; 2]),
            ] {
                *range = if index == 0 { [low, high] } else { [range[0].min(low), range[1].max(high)] };
            }
        }
        found
    }
}
