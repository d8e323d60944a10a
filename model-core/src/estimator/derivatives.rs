//! Derivatives of the estimate without friction, in the ticks that have time for them.

use super::{CONVERGES_WITHIN, DIFFERENTIATE_EVERY, DIFFERENTIATE_WITHIN, Estimate, Estimator, SHORT_WAY, single};
use crate::real::Real;
use crate::sensitivity::Derivative;
use crate::size::Size;
use crate::uncertainty::Slopes;

/// Touching samples up to which derivatives fit into a tick beside its one step, if it has time for no more.
const FEW_TOUCHING: usize = 6;
/// Ticks after which they have a tick of their own there.
pub(super) const DIFFERENTIATE_AT_LAST: u16 = 2 * DIFFERENTIATE_EVERY;

impl<T: Real, S: Size> Estimator<T, S> {
    /// Derivatives and standard deviation of a trustworthy estimate. `iterations` is what it took, or `None` if this tick takes no derivatives.
    pub(super) fn differentiate(&mut self, estimate: &mut Estimate, iterations: Option<u32>) {
        if self.follower.solution().touching() == 0 {
            self.differentiated = false;
            (estimate.force_per_angle, estimate.standard_deviation, estimate.sensitivity_age) = ([0.0; 2], 0.0, 0);
            return;
        }
        if self.is_fresh {
            estimate.sensitivity_age = 0;
        }
        let budget = self.settings().budget;
        // Without any, as soon as they fit into the tick's budget: they cost less than an iteration.
        let within =
            if self.differentiated { DIFFERENTIATE_WITHIN } else { budget.saturating_sub(1).max(DIFFERENTIATE_WITHIN) };
        let fits = match iterations {
            None => false,
            Some(0) => true,
            Some(_) if budget < CONVERGES_WITHIN => self.follower.solution().touching() <= FEW_TOUCHING,
            Some(iterations) => iterations <= within,
        };
        if fits && (estimate.sensitivity_age >= DIFFERENTIATE_EVERY || !self.differentiated) {
            self.take_derivatives(estimate);
        }
        // The force is proportional to the modulus but for the contact's softness.
        self.slopes.youngs_modulus = estimate.force_magnitude();
        let given = self.given();
        estimate.standard_deviation =
            if self.differentiated { given.standard_deviation(&self.slopes) } else { f32::INFINITY };
        if !self.differentiated {
            estimate.force_per_angle = [0.0; 2];
        }
    }

    /// Takes derivatives at the equilibrium, whose force the estimate has: those of the coordinate, if there are any.
    fn take_derivatives(&mut self, estimate: &mut Estimate) -> Option<Derivative<T>> {
        let found = self.follower.sensitivity_of_step()?;
        let size = estimate.force_magnitude();
        let [x, y] = estimate.force.map(|f| f / size);
        let along = |v: [T; 2]| {
            let [u, v] = single(v);
            u * x + v * y
        };
        let per_angle = found.coordinate.force.map(|part| part * T::of(self.ratio));
        estimate.force_per_angle = single(per_angle);
        self.slopes = Slopes {
            angle: along(per_angle),
            youngs_modulus: size,
            centre: [along(found.centre[0].force), along(found.centre[1].force)],
            radius: along(found.radius.force),
        };
        (self.differentiated, self.is_fresh) = (true, true);
        estimate.sensitivity_age = 0;
        Some(found.coordinate)
    }

    /// The derivatives are so old that a tick is theirs. With many touching samples they cost as much as a step: both do not fit into one.
    pub(super) fn differentiates_first(&self, coordinate: f64) -> bool {
        let budget = self.settings().budget;
        let way = (T::of(coordinate).to_f64() - self.follower.solution().coordinate()) / self.ratio;
        let is_due = !self.differentiated || self.last.sensitivity_age >= DIFFERENTIATE_AT_LAST;
        is_due
            && budget < CONVERGES_WITHIN
            && self.last.age == 0
            && self.last.status.is_trustworthy()
            && self.follower.has_equilibrium()
            && (self.follower.solution().touching() > FEW_TOUCHING
                || self.last.sensitivity_age >= DIFFERENTIATE_AT_LAST)
            && way != 0.0
            && way.abs() <= SHORT_WAY
    }

    /// The last force, moved along to an angle nearby by fresh derivatives; false if there are none.
    pub(super) fn move_along(&mut self, estimate: &mut Estimate, motor_angle: f64) -> bool {
        let way = (motor_angle - f64::from(self.last.motor_angle)) as f32;
        let Some(found) = self.take_derivatives(estimate) else { return false };
        self.is_fresh = false;
        let [x, y] = estimate.force_per_angle;
        let before = estimate.force;
        estimate.force = [before[0] + way * x, before[1] + way * y];
        let ratio = self.ratio as f32;
        let [u, v] = single(found.contact_centre).map(|part| part * ratio * way);
        estimate.contact_centre = [estimate.contact_centre[0] + u, estimate.contact_centre[1] + v];
        estimate.torque += found.torque.to_f64() as f32 * ratio * ratio * way;
        if before[0] * estimate.force[0] + before[1] * estimate.force[1] < 0.0 {
            // Contacts do not pull.
            (estimate.force, estimate.torque) = ([0.0; 2], 0.0);
        }
        true
    }
}
