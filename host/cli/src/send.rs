//! `fre calibrate --send`: a calibration into a gripper.

use messages::Object;
use model_core::discretise::Discretisation;

use crate::agreed::agreed;
use crate::exit::tell;
use fre::fit::calibrate::{Fit, Input, uncertainty, zero_counts};
use fre_gripper::calibrated::{Calibrated, SendError, Sent, send};
use fre_gripper::link::Link;

pub use fre_gripper::link::Address;

/// Sends the calibration to a finger of a gripper, counted from 0, which is to model it as `how` says.
///
/// On a terminal a person is asked whether it adds to another calibration, unless `on_top` says so.
pub fn transmit(
    address: &Address,
    number: u8,
    how: Discretisation,
    input: &Input,
    fit: &Fit,
    on_top: bool,
) -> Result<(), String> {
    let design = &input.finger.design;
    let prony = &input.finger.prony;
    let finger = messages::Finger::elastic(fit.trial.design(design), how).relaxing(&fit.trial.prony(prony));
    let rough: Vec<f64> = input.runs.iter().map(|run| fit.trial.friction(run.friction, design)).collect();
    let object = match (input.objects.as_slice(), rough.as_slice()) {
        ([one], [friction, others @ ..]) if others.iter().all(|other| other == friction) => {
            Some(Object { design: fit.trial.object(*one, design), friction: *friction })
        }
        // Which of them is in the gripper is not known.
        _ => None,
    };
    let calibrated = Calibrated {
        finger,
        zero_counts: zero_counts(fit, design),
        drive: fit.trial.drive(&input.drive, design),
        uncertainty: uncertainty(fit, design, prony),
        object,
    };
    let link = Link::open(address).map_err(|error| error.to_string())?;
    let failed = |error: SendError| format!("--send {address}: {error}");
    let sent = match send(&link, number, &calibrated, on_top) {
        Err(error @ SendError::OnTop { .. }) => {
            if !agreed(&error.to_string(), "--on-top").map_err(|error| format!("--send {address}: {error}"))? {
                return Err(format!("--send {address}: nothing was sent"));
            }
            send(&link, number, &calibrated, true)
        }
        sent => sent,
    };
    let Sent { before, now, was_there } = sent.map_err(failed)?;
    if was_there {
        tell!(
            "fre: finger {number} of the gripper at {address} has this calibration already: zero position {now:.2} counts, as before"
        );
        return Ok(());
    }
    let and = if object.is_some() { " and object" } else { "" };
    tell!(
        "fre: sent to finger {} of the gripper at {address}, and read back: finger{and}, uncertainty, zero position {before:.2} → {now:.2} counts",
        number
    );
    Ok(())
}
