//! The estimate of a material with memory: the elastic one, faded ([`crate::fading`]), and the interval while its past is not known.
//!
//! A finger that touches when its estimate begins may have been closed just now, or may have relaxed for ever. The force is then the middle
//! between both. What is not known fades as the material does. A finger that does not touch is taken for one that has been open for long.

use super::{Estimate, Estimator, Interval};
use crate::bounds::OutOfBounds;
use crate::fading::Load;
use crate::real::Real;
use crate::size::Size;
use crate::solution::Reading;
use crate::status::Status;
use crate::uncertainty::Slopes;

/// Part of the force below which an unknown past is not reported as an interval.
const KNOWN: f32 = 1e-3;

impl<T: Real, S: Size> Estimator<T, S> {
    /// Takes the terms [gᵢ, τᵢ in s] of a material with memory, none for an elastic one; the state starts anew, if they are others.
    /// [`Self::update_after`] lets time pass.
    ///
    /// # Errors
    /// As [`crate::fading::Fading::set`]; the old ones then stay.
    pub fn set_prony(&mut self, terms: &[[f64; 2]]) -> Result<(), OutOfBounds> {
        if !self.memory.has(terms) {
            self.memory.set(terms)?;
            self.start_anew();
        }
        Ok(())
    }

    /// The material has memory: the force changes while the motor rests.
    pub fn fades(&self) -> bool {
        self.memory.fades()
    }

    /// What an elastic estimate is with memory. With friction its forces along the object do not fade by themselves: they stay within the cones of
    /// the normal forces, and those fade.
    pub(super) fn fade(&mut self, elastic: &Estimate) -> Estimate {
        let ([x, y], is_new, rubs) = (elastic.force, elastic.status.is_trustworthy(), self.follower.rubs());
        let load = match (is_new, rubs) {
            (false, _) => self.memory.accepted(),
            (true, true) => [self.normal(), 0.0, 0.0],
            (true, false) => [x, y, elastic.torque],
        };
        if is_new {
            if core::mem::replace(&mut self.is_found, true) {
                self.memory.accept(load);
            } else {
                self.memory.find(load);
            }
        }
        let size = libm::hypotf(load[0], load[1]);
        if size == 0.0 {
            return *elastic;
        }
        let [u, v, torque] = self.memory.faded(load);
        let (part, doubt) = (libm::hypotf(u, v) / size, self.memory.doubt() / size);
        let mut estimate = *elastic;
        (estimate.force, estimate.torque) =
            if is_new && !rubs { ([u, v], torque) } else { ([part * x, part * y], part * elastic.torque) };
        if part == 0.0 {
            // It has let go.
            if is_new {
                estimate.status = Status::NoContact;
            }
            estimate.interval = None;
            return estimate;
        }
        // What is not known of either past may be anything within their range.
        let reading = Reading { force: elastic.force, normal: self.normal(), torque: elastic.torque };
        let rubbed = elastic.interval.unwrap_or_else(|| Interval::over(&reading, &[]));
        let interval = rubbed.times([part - doubt, part + doubt]).with(estimate.force, estimate.torque);
        if elastic.interval.is_some() || doubt > KNOWN * part {
            estimate.interval = Some(interval);
        }
        let squared = |x: f32| x * x;
        let others = squared(part) * (squared(elastic.standard_deviation) - squared(rubbed.deviation())).max(0.0);
        let memory = self.memory_variance(load, part, elastic.force_magnitude() / size);
        let variance = others + memory + squared(interval.deviation());
        estimate.standard_deviation = if variance.is_nan() { f32::INFINITY } else { libm::sqrtf(variance.max(0.0)) };
        estimate
    }

    /// What uncertain terms add to the variance of the force, N². The elastic finger's load, what is left of it, and the force's magnitude
    /// as a multiple of the load's.
    fn memory_variance(&self, load: Load<f32>, part: f32, scale: f32) -> f32 {
        let memory = self.memory.slopes(load).map(|term| term.map(|slope| scale * slope));
        let Slopes { angle, youngs_modulus, centre: [x, y], radius } = self.slopes;
        let [angle, youngs_modulus, x, y, radius] = [angle, youngs_modulus, x, y, radius].map(|slope| part * slope);
        self.given().memory_variance(&Slopes { angle, youngs_modulus, centre: [x, y], radius }, &memory)
    }

    /// Sum of the normal forces of the elastic finger, N.
    fn normal(&self) -> f32 {
        let mut sum = T::ZERO;
        for contact in self.follower.solution().contacts() {
            sum += contact.force;
        }
        sum.to_f64() as f32
    }
}
