//! What is on a bus, and how it is estimated.

use messages::Settings;
use model_core::newton::Hessian;
use model_core::object::Motion;

use crate::source::Modelled;
use fre::drive::fits_finger;
use fre::study::model::Precision;

/// What is on the bus, and how it is estimated.
#[derive(Clone, Debug, PartialEq)]
pub struct BusOptions {
    /// Rate, shapes and mounts.
    pub settings: Settings,
    /// Whether the mounts name the servos; otherwise those that answer are the fingers, in the order of their addresses.
    pub names_servos: bool,
    /// One model per finger; the last one stands for those behind it.
    pub models: Vec<Modelled>,
    /// Precision.
    pub precision: Precision,
    /// Second derivative of the Newton step.
    pub hessian: Hessian,
}

impl BusOptions {
    /// Whether the case of every finger moves its base as the finger's drive does; there is one per finger, and the last one stands for those behind
    /// it. Servos that nobody has named are mounted as the first.
    ///
    /// # Errors
    /// The number of the case that does not, and why, for people.
    pub fn check_motions(settings: &Settings, names_servos: bool, cases: &[Motion]) -> Result<(), (usize, String)> {
        let [first, ..] = settings.fingers;
        for (finger, mount) in settings.fingers.iter().enumerate() {
            let mount = mount.or(first.filter(|_| !names_servos));
            let case = finger.min(cases.len().saturating_sub(1));
            if let (Some(mount), Some(motion)) = (mount, cases.get(case)) {
                fits_finger(motion, &mount.drive, finger).map_err(|why| (case, why))?;
            }
        }
        Ok(())
    }
}
