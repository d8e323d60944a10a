//! Between which values forces lie that are not known any better.

use crate::solution::Reading;

/// Between which values forces lie, N and N·mm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Interval {
    /// Sum of the normal forces.
    pub normal: [f32; 2],
    /// The force's magnitude. Its least value may be that of the normal forces alone, where friction vanishes.
    pub magnitude: [f32; 2],
    /// Torque that the contact demands of the motor.
    pub torque: [f32; 2],
}

impl Interval {
    /// Of what there may be: a reading, and others if the past may have brought it there as well.
    #[inline(never)]
    pub(super) fn over(one: &Reading<f32>, others: &[Reading<f32>]) -> Self {
        let mut found = Self { normal: [one.normal; 2], magnitude: [magnitude(one.force); 2], torque: [one.torque; 2] };
        for other in others.iter().filter(|&other| other != one) {
            take(&mut found.normal, other.normal);
            take(&mut found.magnitude, magnitude(other.force));
            take(&mut found.torque, other.torque);
            found.magnitude[0] = found.magnitude[0].min(found.normal[0]);
        }
        found
    }

    /// With the forces of an estimate, which rounding or the middle between two directions may leave outside.
    pub(super) fn with(mut self, force: [f32; 2], torque: f32) -> Self {
        take(&mut self.magnitude, magnitude(force));
        take(&mut self.torque, torque);
        self
    }

    /// With a reading near to those that it is over, so that friction does not vanish between them.
    #[inline(never)]
    pub(super) fn up_to(mut self, near: &Reading<f32>) -> Self {
        take(&mut self.normal, near.normal);
        self.with(near.force, near.torque)
    }

    /// The forces times what lies between two parts, the lesser first and at least zero.
    #[inline(never)]
    pub(super) fn times(self, [low, high]: [f32; 2]) -> Self {
        let low = low.max(0.0);
        let ends = |[least, most]: [f32; 2]| {
            [least * if least < 0.0 { high } else { low }, most * if most < 0.0 { low } else { high }]
        };
        Self { normal: ends(self.normal), magnitude: ends(self.magnitude), torque: ends(self.torque) }
    }

    /// Standard deviation of a magnitude of which no more is known, N.
    pub(super) fn deviation(&self) -> f32 {
        let [low, high] = self.magnitude;
        (high - low) * libm::sqrtf(1.0 / 12.0)
    }
}

/// Widens an interval to a value.
fn take([low, high]: &mut [f32; 2], value: f32) {
    (*low, *high) = (low.min(value), high.max(value));
}

/// Magnitude of a force: everywhere the same to the last bit, so that a force is never beside its own interval.
pub(super) fn magnitude([x, y]: [f32; 2]) -> f32 {
    libm::sqrtf(x * x + y * y)
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOW: Reading<f32> = Reading { force: [3.0, 4.0], normal: 4.5, torque: 200.0 };

    #[test]
    fn an_interval_spans_both_readings_and_friction_that_vanishes() {
        let other = Reading { force: [0.0, 6.0], normal: 5.0, torque: 150.0 };
        let found = Interval::over(&NOW, &[other]);
        assert_eq!((found.normal, found.magnitude, found.torque), ([4.5, 5.0], [4.5, 6.0], [150.0, 200.0]));
        assert_eq!(Interval::over(&NOW, &[NOW]).magnitude, [5.0, 5.0]);
        // The middle of two forces may be less than both.
        let widened = found.with([0.0, 4.0], 210.0);
        assert_eq!((widened.normal, widened.magnitude, widened.torque), ([4.5, 5.0], [4.0, 6.0], [150.0, 210.0]));
        assert!((found.deviation() - 1.5 / 12.0_f32.sqrt()).abs() < 1e-6);
    }
}
