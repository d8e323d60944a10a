//! A finger's motor as `sensor_msgs/JointState`.
//!
//! Position: the motor angle in rad, positive closes; of a finger whose base is moved along a line, the way in m. No velocity. Effort:
//! what the contact demands of the joint according to the model (N·m or N), NaN while the estimate is untrustworthy.

use messages::Report;
use model_core::drive::Drive;
use model_core::status::Status;

use crate::finger::Finger;
use crate::message::{Header, JointState};
use crate::wrench::is_trusted;

/// Of a report; none if no position came from the servo in its tick, or the drive has no place for it.
pub fn joint_state(finger: &Finger, report: &Report, header: Header) -> Option<JointState> {
    let estimate = &report.estimate;
    if estimate.status == Status::Stale {
        return None;
    }
    let angle = f64::from(estimate.motor_angle);
    let torque = if is_trusted(report) { f64::from(estimate.torque) } else { f64::NAN };
    let (position, effort) = match finger.drive {
        Drive::Rotating => (angle, 1e-3 * torque),
        Drive::Translating { .. } => {
            // mm, and mm per rad: the torque is N·mm at the motor.
            let [way, ratio] = finger.drive.coordinate(angle)?;
            (1e-3 * way, if ratio > 0.0 { torque / ratio } else { f64::NAN })
        }
    };
    Some(JointState {
        header,
        name: vec![finger.joint()],
        position: vec![position],
        velocity: Vec::new(),
        effort: vec![effort],
    })
}
