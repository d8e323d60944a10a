//! How far a force can be trusted, as `control_msgs/DynamicJointState`.
//!
//! ROS 2 has no message for a force with its uncertainty. Of the standard ones this has a time, names every number in itself, and takes
//! numbers that come later without becoming another type. NaN says that a number is not known.

use messages::Report;

use crate::finger::Finger;
use crate::message::{DynamicJointState, Header, InterfaceValue};
use crate::wrench::is_trusted;

/// Names of the values, in their order.
pub const NAMES: [&str; 8] = [
    // Magnitude of the force, N.
    "force",
    // Its standard deviation, N; infinite while no derivatives are known.
    "force_standard_deviation",
    // Least and greatest force, N, where friction leaves it open; NaN without friction.
    "force_interval_low",
    "force_interval_high",
    // The load that all fingers together bear in the weakest direction before the object slips, N.
    "margin",
    // 1 or 0.
    "trusted",
    // The status' number.
    "status",
    // s since the last trustworthy force; infinite before the first one.
    "age",
];

/// Of a report; `age`: s since the last trustworthy force; `margin`: that of the whole grip, N, if it is known.
pub fn certainty(finger: &Finger, report: &Report, age: f64, margin: Option<f64>, header: Header) -> DynamicJointState {
    let estimate = &report.estimate;
    let trusted = is_trusted(report);
    let known = |number: f32| if trusted { f64::from(number) } else { f64::NAN };
    // Without friction the force is where it is, and with it an end may not be known yet.
    let end = |which: usize| estimate.interval.map_or(f64::NAN, |interval| known(interval.magnitude[which]));
    let values = [
        known(estimate.force_magnitude()),
        known(estimate.standard_deviation),
        end(0),
        end(1),
        margin.filter(|_| trusted).unwrap_or(f64::NAN),
        f64::from(u8::from(trusted)),
        f64::from(estimate.status as u8),
        age,
    ];
    DynamicJointState {
        header,
        joint_names: vec![finger.joint()],
        interface_values: vec![InterfaceValue {
            interface_names: NAMES.map(str::to_owned).to_vec(),
            values: values.to_vec(),
        }],
    }
}
