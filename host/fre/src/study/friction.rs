//! Friction at a place: what of the contact's force is along the object, and what that has cost.

use model_core::equilibrium::Follower;
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
    /// Energy that friction has dissipated since the hand was open, N·mm.
    pub dissipated_nmm: f64,
}

impl Friction {
    /// What a follower is at.
    pub fn of<T: Real, S: Size>(follower: &Follower<T, S>) -> Self {
        let coefficient = follower.friction().to_f64();
        let (mut normal_n, mut tangential_n, mut magnitude) = (0.0, 0.0, 0.0);
        for contact in follower.contacts() {
            let along = contact.tangential.to_f64();
            normal_n += contact.force.to_f64();
            tangential_n += along;
            magnitude += along.abs();
        }
        let cone = coefficient * normal_n;
        let mobilised = if cone > 0.0 { magnitude / cone } else { 0.0 };
        Self { coefficient, normal_n, tangential_n, mobilised, dissipated_nmm: follower.dissipated().to_f64() + 0.0 }
    }
}
