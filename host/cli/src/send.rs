//! `fre calibrate --send`: a calibration into a gripper.

use model_core::discretise::Discretisation;

use crate::exit::tell;
use fre::fit::calibrate::{Fit, Input, uncertainty, zero_counts};
use fre_gripper::calibrated::{Calibrated, send};
use fre_gripper::link::Link;

pub use fre_gripper::link::Address;

/// Sends the calibration to a finger of a gripper, counted from 0, which is to model it as `how` says.
pub fn transmit(address: &Address, number: u8, how: Discretisation, input: &Input, fit: &Fit) -> Result<(), String> {
    let design = &input.finger.design;
    let finger = messages::Finger { design: fit.trial.design(design), how };
    let object = match input.objects.as_slice() {
        [one] => Some(fit.trial.object(*one, design)),
        // Which of them is in the gripper is not known.
        _ => None,
    };
    let calibrated = Calibrated {
        finger,
        zero_counts: zero_counts(fit, design),
        drive: fit.trial.drive(&input.drive, design),
        uncertainty: uncertainty(fit, design),
        object,
    };
    let link = Link::open(address).map_err(|error| error.to_string())?;
    let [before, now] = send(&link, number, &calibrated).map_err(|error| format!("--send {address}: {error}"))?;
    let and = if object.is_some() { " and object" } else { "" };
    tell!(
        "fre: sent to finger {} of the gripper at {address}, and read back: finger{and}, uncertainty, zero position {before:.2} → {now:.2} counts",
        number
    );
    Ok(())
}
