//! How equilibria are followed: steps, iterations, and the ranges these may have.

use crate::bounds::{OutOfBounds, check};
use crate::newton::Hessian;

/// How equilibria are followed. Every field has a default.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Second derivative of the Newton step; default [`Hessian::Newton`].
    pub hessian: Hessian,
    /// Newton iterations allowed for one step of the coordinate, 1 to 100,000; default 25 (Gauss–Newton needs more).
    pub max_iterations: u32,
    /// Largest step of a motor angle, rad, 1e-6 to 1; default 1°.
    pub max_angle_step: f64,
    /// Largest step of a distance, in the finger's unit of length ([`crate::units`]), 1e-4 to 100: mm for a finger of 80 mm; default 1.
    pub max_distance_step: f64,
    /// A step that fails at this fraction of the largest one has met the end of its branch, 1e-6 to 1; default 1/512.
    pub min_step: f64,
    /// What a step with friction brings into contact slips from where the step began. If true, a step by whose new contacts the object pulls with more
    /// than 1 % of the normal forces is halved, down to 1/16 of the largest: the force no longer depends on where the steps of the way end (by
    /// up to 5 % where a flat side lands on a second place and sticks). About 2.5 times the iterations; default false.
    pub resolves_contact: bool,
    /// Gap within which a sample takes part in a step before it touches, mm, 0 to 10; default 0: those that penetrate. More
    /// rows cost more, and save no iterations.
    pub margin: f64,
}

impl Settings {
    /// The defaults.
    pub const DEFAULT: Self = Self {
        hessian: Hessian::Newton,
        max_iterations: 25,
        max_angle_step: core::f64::consts::PI / 180.0,
        max_distance_step: 1.0,
        min_step: 1.0 / 512.0,
        resolves_contact: false,
        margin: 0.0,
    };
    pub(super) const UNSET: Self = Self {
        hessian: Hessian::Newton,
        max_iterations: 0,
        max_angle_step: 0.0,
        max_distance_step: 0.0,
        min_step: 0.0,
        resolves_contact: false,
        margin: 0.0,
    };

    /// The defaults that suit a second derivative: Gauss–Newton converges linearly, about sixty iterations where Newton's
    /// method needs two.
    pub const fn of(hessian: Hessian) -> Self {
        match hessian {
            Hessian::Newton => Self::DEFAULT,
            Hessian::GaussNewton => Self { hessian, max_iterations: 500, ..Self::DEFAULT },
        }
    }

    /// Checks every value.
    ///
    /// # Errors
    /// The first value that is not allowed, by its field's name.
    pub fn validate(&self) -> Result<(), OutOfBounds> {
        check("max_iterations", f64::from(self.max_iterations), [1.0, 1e5])?;
        check("max_angle_step", self.max_angle_step, [1e-6, 1.0])?;
        check("max_distance_step", self.max_distance_step, [1e-4, 100.0])?;
        check("min_step", self.min_step, [1e-6, 1.0])?;
        check("margin", self.margin, [0.0, 10.0])
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self::DEFAULT
    }
}
