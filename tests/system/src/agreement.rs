//! What a gripper said while its finger closed, next to what the simulated servo's finger really does.

use fre_gripper::servo::{Load, OnBranch};
use messages::Report;

/// One count of the servo, rad.
const COUNT: f64 = std::f64::consts::TAU / 4096.0;
/// Force from which on two are compared, N.
const LEAST: f64 = 1.0;

/// How far the fresh reports of a finger that starts open, its zero in the servo's middle, are from its load.
#[derive(Clone, Copy, Debug, Default)]
pub struct Agreement {
    /// Reports compared: those of 1 N or more.
    pub places: usize,
    /// The largest error of the force's magnitude, as a part of it.
    pub force: f64,
    /// The same of the motor's torque.
    pub torque: f64,
}

impl Agreement {
    /// Compares them, in their order.
    ///
    /// # Panics
    /// A fresh report is not trustworthy.
    pub fn of(reports: &[Report], load: &Load) -> Self {
        let (mut agreement, mut on) = (Self::default(), OnBranch::default());
        for report in reports.iter().filter(|report| report.estimate.age == 0) {
            assert!(report.estimate.status.is_trustworthy(), "{report:?}");
            let truth = load.at(f64::from(report.position - 2048) * COUNT, &mut on);
            let force = truth.force[0].hypot(truth.force[1]);
            if force > LEAST {
                let off = |told: f32, true_one: f64| (f64::from(told) / true_one - 1.0).abs();
                agreement.places += 1;
                agreement.force = agreement.force.max(off(report.estimate.force_magnitude(), force));
                agreement.torque = agreement.torque.max(off(report.estimate.torque, truth.torque));
            }
        }
        eprintln!(
            "{} places: force {:.2} %, torque {:.2} %",
            agreement.places,
            100.0 * agreement.force,
            100.0 * agreement.torque
        );
        agreement
    }

    /// There were more than 50 places, and force and torque are within a part of what they should be.
    pub fn is_within(&self, part: f64) -> bool {
        self.places > 50 && self.force < part && self.torque < part
    }
}
