//! A closing and opening finger as the target estimates it: shared by the build on the PC and the test on the target.

use model_core::discretise::{Discretisation, Physics, Sampling};
use model_core::estimator::{Estimate, Estimator};
use model_core::size::{Reduced, Size};
use model_core::status::Status;

/// Contact heights of the 80 mm circle: Low, Mid, High.
pub const HEIGHTS: [f64; 3] = [30.0, 45.0, 60.0];
/// Largest motor angle, counts.
pub const CLOSED: i32 = 125;

/// Calls `each` with (force x, force y, torque) of every tick, closing and opening one count at a time; returns the number of
/// ticks without a trustworthy estimate.
pub fn closing_and_opening(
    estimator: &mut Estimator<f32, Reduced>,
    physics: Physics,
    height: f64,
    mut each: impl FnMut([f32; 3]),
) -> usize {
    let configured = estimator.configure(&reference_tests::ladder_80(), &Discretisation::estimator(physics)).is_ok();
    let placed = estimator.set_object(reference_tests::circle_80(height)).is_ok();
    let mut lost = usize::from(!(configured && placed));
    for count in (-3..=CLOSED).chain((-3..CLOSED).rev()) {
        let estimate = estimator.update(f64::from(count) * reference_tests::COUNT);
        lost += usize::from(!estimate.status.is_trustworthy());
        each([estimate.force[0], estimate.force[1], estimate.torque]);
    }
    lost
}

/// Newton iterations of a tick of the campaign, as the firmware allows.
pub const QUOTA: u32 = 1;

/// A finger that goes through the campaign.
#[derive(Clone, Copy)]
pub struct Case {
    /// Samples per element.
    pub samples: u8,
    /// Coefficient of friction.
    pub friction: f64,
    /// Terms of a material with memory.
    pub prony: &'static [[f64; 2]],
}

/// Two terms of a soft plastic.
const PRONY: &[[f64; 2]] = &[[0.15, 0.5], [0.1, 20.0]];

/// Without friction and memory, and with both.
pub const CASES: [Case; 5] = [
    Case { samples: 2, friction: 0.0, prony: &[] },
    Case { samples: 4, friction: 0.0, prony: &[] },
    Case { samples: 5, friction: 0.0, prony: &[] },
    Case { samples: 2, friction: 0.6, prony: PRONY },
    Case { samples: 5, friction: 0.6, prony: PRONY },
];

/// Calls `each` with (force x, force y, torque) and the cost of every tick of the campaign, as `costs` measures it; false if finger or objects were
/// refused.
pub fn campaign<S: Size, C>(
    estimator: &mut Estimator<f32, S>,
    case: &Case,
    mut costs: impl FnMut(&mut dyn FnMut()) -> C,
    mut each: impl FnMut([f32; 3], bool, C),
) -> bool {
    let sampling = Sampling::PerElement(case.samples);
    let how = Discretisation { sampling, ..Discretisation::estimator(Physics::Extended) };
    let mut sound = estimator.configure(&reference_tests::ladder_80(), &how).is_ok()
        && estimator.set_friction(case.friction).is_ok()
        && estimator.set_prony(case.prony).is_ok();
    estimator.set_budget(QUOTA);
    for tick in reference_tests::campaign::ticks() {
        sound &= tick.prepare(estimator);
        let mut estimate = Estimate::blank(Status::Stale);
        let cost = costs(&mut || estimate = estimator.update_after(tick.angle(), reference_tests::campaign::PERIOD_S));
        let touches = estimate.force != [0.0; 2] && estimate.age == 0;
        each([estimate.force[0], estimate.force[1], estimate.torque], touches, cost);
    }
    sound
}

/// Mixes a number's bits into a digest (FNV-1a).
pub fn mix(digest: u64, number: f32) -> u64 {
    number.to_bits().to_le_bytes().iter().fold(digest, |d, &byte| (d ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

/// Where a digest begins.
pub const DIGEST: u64 = 0xcbf2_9ce4_8422_2325;
