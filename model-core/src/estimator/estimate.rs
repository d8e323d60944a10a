//! What the estimator says at one tick, and the bounds that it keeps.

use super::interval::{Interval, magnitude};
use crate::bounds::{OutOfBounds, check};
use crate::equilibrium::Tracking;
use crate::solution::LoadedRib;
use crate::status::Status;

/// Bounds of an estimator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EstimatorSettings {
    /// Newton iterations allowed per tick; default 8. With fewer than three, in which a tick does not always converge, the
    /// estimator is content with [`Tracking::DEFAULT`], unless `one_iteration` says otherwise.
    pub budget: u32,
    /// Motor angles outside this range (rad, within ±1000) are answered with `out-of-range`; default ±90°.
    pub range: [f64; 2],
    /// Content with one Newton iteration per tick (status `tracking`) where the residual is below these bounds; default none:
    /// every tick converges.
    pub one_iteration: Option<Tracking>,
}

impl EstimatorSettings {
    /// The defaults.
    pub const DEFAULT: Self =
        Self { budget: 8, range: [-core::f64::consts::FRAC_PI_2, core::f64::consts::FRAC_PI_2], one_iteration: None };

    /// Checks every value.
    ///
    /// # Errors
    /// The first value that is not allowed, by its field's name.
    pub fn validate(&self) -> Result<(), OutOfBounds> {
        let [least, most] = self.range;
        check("range", least, [-1e3, 1e3])?;
        check("range", most, [least, 1e3])?;
        if let Some(Tracking { gradient, length }) = self.one_iteration {
            check("one_iteration.gradient", gradient, [0.0, 1e6])?;
            check("one_iteration.length", length, [0.0, 1e3])?;
        }
        Ok(())
    }
}

impl Default for EstimatorSettings {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// What the estimator says at one tick. Angles in rad, lengths in mm, forces in N, torques in N·mm.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Estimate {
    /// Whether the numbers below may be used.
    pub status: Status,
    /// Motor angle the estimate was asked for.
    pub motor_angle: f32,
    /// Force of the finger on the object, world frame.
    pub force: [f32; 2],
    /// Centre of the contact (mean of the touching surface points, weighted by force), world frame; zero without contact.
    pub contact_centre: [f32; 2],
    /// Arc length of the front beam between the outermost touching samples.
    pub contact_extent: f32,
    /// Torque the contact demands of the motor, positive when it must push to close; through a drive that translates the base, the
    /// force against its motion times mm per rad.
    pub torque: f32,
    /// Smallest distance between finger and object; negative by the contact's softness (at most a few µm) when touching.
    pub distance: f32,
    /// Newton iterations spent in this tick: the cost.
    pub iterations: u16,
    /// Largest gradient component left, N·mm.
    pub residual: f32,
    /// Ticks since the last trustworthy estimate; 0 for a trustworthy one.
    pub age: u32,
    /// Derivative of the force with respect to the motor angle, world frame, N/rad; zero without contact.
    pub force_per_angle: [f32; 2],
    /// Standard deviation of the force's magnitude from what the estimator's
    /// [`Uncertainty`](crate::uncertainty::Uncertainty) says, N: infinite while no
    /// derivatives are known, zero without contact (`distance` says how near a contact is).
    pub standard_deviation: f32,
    /// Ticks since the derivatives behind the last two were those of the present equilibrium.
    pub sensitivity_age: u16,
    /// Between which values the forces lie, with friction, and with memory while the past is not known. `None` without both, without
    /// contact, and while an end is not known yet: the standard deviation is then infinite.
    pub interval: Option<Interval>,
    /// The rib that is nearest to buckling, from [`NEAR_BUCKLING`](crate::solution::NEAR_BUCKLING) on: the force is known less well
    /// then, within 2 % instead of 0.6 % of what finer elements give. `None` otherwise, and without ribs.
    pub loaded_rib: Option<LoadedRib>,
}

impl Estimate {
    /// Magnitude of the force, N.
    pub fn force_magnitude(&self) -> f32 {
        magnitude(self.force)
    }

    /// All numbers zero, with a status that says why.
    pub const fn blank(status: Status) -> Self {
        Self {
            status,
            motor_angle: 0.0,
            force: [0.0; 2],
            contact_centre: [0.0; 2],
            contact_extent: 0.0,
            torque: 0.0,
            distance: 0.0,
            iterations: 0,
            residual: 0.0,
            age: 0,
            force_per_angle: [0.0; 2],
            standard_deviation: 0.0,
            sensitivity_age: 0,
            interval: None,
            loaded_rib: None,
        }
    }
}
