//! How near a rib is to buckling, cheaply.

use super::Solution;
use crate::access::Access as _;
use crate::real::Real;
use crate::size::Size;
use crate::topology::Role;

/// A rib is reported from this share of its buckling load between clamped ends on. In a finger its ends turn with the beams, and it bows a
/// tenth below that load (tests `ribs_that_bow_are_warned_of`, `near_buckling_the_reduced_model_says_so`); this is a tenth below again.
pub const NEAR_BUCKLING: f64 = 0.8;

/// A rib whose force is near its buckling load.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LoadedRib {
    /// The rib, from 0 at the base.
    pub rib: u8,
    /// Its force in percent of its buckling load between clamped ends, 4π²EI/L² of an even one, or of a sixteenth of that if its end is free
    /// before the back beam; from [`NEAR_BUCKLING`] on.
    pub percent: u8,
}

/// For people, who count ribs from 1: `rib 7, 93 % of its load`.
impl core::fmt::Display for LoadedRib {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "rib {}, {} % of its load", u16::from(self.rib) + 1, self.percent)
    }
}

impl<T: Real, S: Size> Solution<'_, T, S> {
    /// The rib that is nearest to buckling, from [`NEAR_BUCKLING`] on, by the force along its chord and the load of the undeformed rib: a few
    /// operations per rib. [`Follower::buckling`](crate::equilibrium::Follower::buckling) takes the bowed rib, and factorises for it.
    pub fn loaded_rib(self) -> Option<LoadedRib> {
        let (mut most, mut nearest) = (T::of(NEAR_BUCKLING), None);
        for (member, out) in self.model.members().iter().zip(self.kinematics.members.as_ref()) {
            let Role::Rung(rib, 0) = member.role else { continue };
            let load = self.model.buckling_loads.as_ref().at(usize::from(rib));
            let ([x, y], [u, v]) = (out.force, out.chord);
            let along = x * u + y * v;
            if load == T::ZERO || along <= T::ZERO {
                continue;
            }
            let pressed = along / (u * u + v * v).sqrt();
            // What it gives way by moves the force through its sections out of line, and stretching changes how stiff it bends.
            let [stretch, shear] = member.compliance;
            let softening = pressed * (T::one() - (stretch - shear) * pressed);
            let share = softening / (load * (T::one() - member.stiffening * pressed));
            if share >= most {
                let percent = T::of(100.0) * share.min(T::of(2.0));
                (most, nearest) = (share, Some(LoadedRib { rib, percent: percent.to_f64() as u8 }));
            }
        }
        nearest
    }
}
