//! A finger's force as `geometry_msgs/WrenchStamped`.
//!
//! It is the force of the finger **on the object**, in N. Frame: the finger's `finger_N_base`, which stands still: x towards the
//! object, y along the undeformed front beam towards the tip, z = x × y; its origin is the front beam's base at motor angle 0. The
//! torque is about that origin, in N·m.
//!
//! While the estimate is untrustworthy all six numbers are NaN. Silence would leave the last force on every screen and in every
//! controller; NaN is what `ros2_control` has for a value that is not known, and rviz refuses to draw it.

use messages::Report;
use model_core::drive::Drive;

use crate::finger::Finger;
use crate::message::{Header, Vector3, Wrench, WrenchStamped};

/// The description that goes with the topic, as a parameter and in the diagnostics.
pub const DESCRIPTION: &str = "Force of the finger on the object (N) and its moment (N m) about the origin of finger_N_base: x towards \
                               the object, y towards the tip, origin at the front beam's base at motor angle 0. All NaN while \
                               the estimate is untrustworthy.";

/// Of a report.
pub fn wrench(finger: &Finger, report: &Report, header: Header) -> WrenchStamped {
    let wrench = if is_trusted(report) { known(finger, report) } else { unknown() };
    WrenchStamped { header, wrench }
}

/// Whether a report's force may be used.
pub fn is_trusted(report: &Report) -> bool {
    report.estimate.status.is_trustworthy() && report.estimate.age == 0
}

fn known(finger: &Finger, report: &Report) -> Wrench {
    let [x, y] = report.estimate.force.map(f64::from);
    let moment = match (finger.drive, finger.axis) {
        // The torque that the contact demands of the motor is minus the moment about its axis, friction included.
        (Drive::Rotating, Some([mx, my])) => mx * y - my * x - f64::from(report.estimate.torque),
        // The contact's centre is on the line of action of what touches a cylinder.
        (Drive::Translating { .. }, Some(_)) => {
            let [cx, cy] = report.estimate.contact_centre.map(f64::from);
            cx * y - cy * x
        }
        (_, None) => f64::NAN,
    };
    Wrench { force: Vector3 { x, y, z: 0.0 }, torque: Vector3 { z: 1e-3 * moment, ..Vector3::default() } }
}

fn unknown() -> Wrench {
    let nan = Vector3 { x: f64::NAN, y: f64::NAN, z: f64::NAN };
    Wrench { force: nan, torque: nan }
}
